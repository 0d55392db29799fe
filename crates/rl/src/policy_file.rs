//! Policies as bytes: a safetensors file with everything that is needed to act.

use std::collections::HashMap;

use safetensors::{Dtype, SafeTensorError, SafeTensors, tensor::TensorView};

use crate::{
    CategoricalPolicy, GaussianPolicy, SacError, Scaling, interface::ActionRange, mlp::Mlp, scaled_net::ScaledNet,
};

/// The only metadata entry. There must be only one, because the order of several would not be fixed.
const FORMAT_KEY: &str = "format";

pub(crate) const GAUSSIAN: &str = "sindyna squashed-gaussian policy 1: x = (observation - center) / scale; \
    x = relu(weight x + bias) per layer, the last without relu; (mean, log_std) = x; \
    action = low + (tanh(mean) + 1) / 2 * (high - low)";

pub(crate) const CATEGORICAL: &str = "sindyna categorical policy 1: x = (observation - center) / scale; \
    x = relu(weight x + bias) per layer, the last without relu; \
    action = index of the largest x, counted from 0, the lowest of equal ones";

/// Wider or deeper networks than these are taken for broken files, before memory is asked for.
const MOST_LAYERS: usize = 64;

/// Why bytes are not a policy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PolicyFileError {
    /// The bytes are not a safetensors file.
    #[error("not a safetensors file")]
    Container(#[source] SafeTensorError),
    /// The file holds something else.
    #[error("the file holds no such policy; the format it declares is {found:?}")]
    Format {
        /// What it declares.
        found: Option<String>,
    },
    /// A tensor is missing.
    #[error("tensor `{name}` is missing")]
    Missing {
        /// Name of the tensor.
        name: String,
    },
    /// The file holds a tensor a policy does not have.
    #[error("tensor `{name}` belongs to no policy")]
    Unexpected {
        /// Name of the tensor.
        name: String,
    },
    /// A tensor has another type or shape than the policy needs.
    #[error("tensor `{name}` is {got}, expected {expected}")]
    Shape {
        /// Name of the tensor.
        name: String,
        /// Type and shape wanted.
        expected: String,
        /// Type and shape found.
        got: String,
    },
    /// A tensor holds a number that is none, or an infinite one.
    #[error("tensor `{name}` holds {value}")]
    NotFinite {
        /// Name of the tensor.
        name: String,
        /// The value.
        value: f64,
    },
    /// The numbers make no policy.
    #[error(transparent)]
    Values(#[from] SacError),
}

impl GaussianPolicy {
    /// The policy as a safetensors file; equal policies give equal bytes.
    ///
    /// Tensors: `center`, `scale` (m) and `low`, `high` (k) in f64; `layers.0.weight` (outputs, inputs),
    /// `layers.0.bias` (outputs) and so on in f32, as PyTorch's `nn.Linear` has them. The metadata entry `format`
    /// says how they make an action.
    #[must_use]
    pub fn to_safetensors(&self) -> Vec<u8> {
        write(GAUSSIAN, &self.net, &[("low", self.range.low()), ("high", self.range.high())])
    }

    /// The policy of a file made by [`Self::to_safetensors`].
    ///
    /// # Errors
    /// [`PolicyFileError`] if the bytes are no such file, whatever is wrong with them.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, PolicyFileError> {
        let file = open(bytes, GAUSSIAN)?;
        refuse_strangers(&file, &["low", "high"])?;
        let range = ActionRange::new(&doubles(&file, "low")?, &doubles(&file, "high")?)?;
        Ok(Self { net: read_net(&file, Some(2 * range.width()))?, range })
    }
}

impl CategoricalPolicy {
    /// The policy as a safetensors file; equal policies give equal bytes.
    ///
    /// The file is that of [`GaussianPolicy::to_safetensors`] without `low` and `high`; `format` tells them apart.
    #[must_use]
    pub fn to_safetensors(&self) -> Vec<u8> {
        write(CATEGORICAL, &self.net, &[])
    }

    /// The policy of a file made by [`Self::to_safetensors`].
    ///
    /// # Errors
    /// [`PolicyFileError`] if the bytes are no such file, whatever is wrong with them.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, PolicyFileError> {
        let file = open(bytes, CATEGORICAL)?;
        refuse_strangers(&file, &[])?;
        Ok(Self { net: read_net(&file, None)? })
    }
}

/// A file of `net` and of further tensors `others`, in f64.
fn write(format: &str, net: &ScaledNet, others: &[(&str, &[f64])]) -> Vec<u8> {
    let scaling = [("center", net.scaling.center.as_slice()), ("scale", net.scaling.scale.as_slice())];
    let doubles = scaling.iter().chain(others);
    let mut tensors: Vec<_> = doubles
        .map(|(name, values)| {
            ((*name).to_owned(), (Dtype::F64, vec![values.len()], bytes(values, |v| v.to_le_bytes())))
        })
        .collect();
    for l in 0..net.net.depth() {
        let layer = net.net.layer(l);
        let (weights, biases) = layer.of(&net.net.params);
        let transposed = transpose(weights, layer.inputs, layer.outputs);
        let shape = vec![layer.outputs, layer.inputs];
        tensors.push((name(l, "weight"), (Dtype::F32, shape, bytes(&transposed, |v| v.to_le_bytes()))));
        let shape = vec![layer.outputs];
        tensors.push((name(l, "bias"), (Dtype::F32, shape, bytes(biases, |v| v.to_le_bytes()))));
    }
    let views = tensors.iter().map(|(name, (dtype, shape, data))| {
        let view = TensorView::new(*dtype, shape.clone(), data).expect("the data were made from the shape");
        (name, view)
    });
    let metadata = HashMap::from([(FORMAT_KEY.to_owned(), format.to_owned())]);
    safetensors::serialize(views, Some(metadata)).expect("names are short and data match their shapes")
}

/// The format a file declares.
pub(crate) fn declared_format(bytes: &[u8]) -> Result<Option<String>, PolicyFileError> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(PolicyFileError::Container)?;
    Ok(metadata.metadata().as_ref().and_then(|m| m.get(FORMAT_KEY)).cloned())
}

/// The tensors of a file that declares `format`.
fn open<'a>(bytes: &'a [u8], format: &str) -> Result<SafeTensors<'a>, PolicyFileError> {
    let found = declared_format(bytes)?;
    if found.as_deref() != Some(format) {
        return Err(PolicyFileError::Format { found });
    }
    SafeTensors::deserialize(bytes).map_err(PolicyFileError::Container)
}

/// Number of layers in `file`; their tensors may still be missing.
fn depth(file: &SafeTensors<'_>) -> usize {
    file.names().iter().filter(|n| n.ends_with(".weight")).count().clamp(1, MOST_LAYERS)
}

/// Refuses tensors that are neither a network's, nor its scaling's, nor `others`.
fn refuse_strangers(file: &SafeTensors<'_>, others: &[&str]) -> Result<(), PolicyFileError> {
    let depth = depth(file);
    let layer = |n: &str| n.strip_prefix("layers.")?.split_once('.')?.0.parse().ok().filter(|l| *l < depth);
    let of_layer = |n: &str| layer(n).is_some_and(|l| n == name(l, "weight") || n == name(l, "bias"));
    let known = |n: &str| ["center", "scale"].contains(&n) || others.contains(&n) || of_layer(n);
    match file.names().into_iter().filter(|n| !known(n)).min() {
        Some(name) => Err(PolicyFileError::Unexpected { name: name.to_owned() }),
        None => Ok(()),
    }
}

/// The network of `file`, as wide at its end as `head` says, if that says anything.
fn read_net(file: &SafeTensors<'_>, head: Option<usize>) -> Result<ScaledNet, PolicyFileError> {
    let scaling = Scaling { center: doubles(file, "center")?, scale: doubles(file, "scale")? };
    scaling.check()?;
    let depth = depth(file);
    let mut sizes = vec![scaling.width()];
    for l in 0..depth {
        let declared = tensor(file, &name(l, "bias"))?.shape().iter().product();
        sizes.push(head.filter(|_| l + 1 == depth).unwrap_or(declared));
    }
    let mut params = Vec::new();
    for (l, widths) in sizes.windows(2).enumerate() {
        let (inputs, outputs) = (widths[0], widths[1]);
        let weights = numbers(file, &name(l, "weight"), Dtype::F32, &[outputs, inputs], f32::from_le_bytes)?;
        params.extend(transpose(&weights, outputs, inputs));
        params.extend(numbers(file, &name(l, "bias"), Dtype::F32, &[outputs], f32::from_le_bytes)?);
    }
    Ok(ScaledNet { net: Mlp::from_params(&sizes, params), scaling })
}

fn name(l: usize, part: &str) -> String {
    format!("layers.{l}.{part}")
}

fn bytes<T: Copy, const N: usize>(values: &[T], encode: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|v| encode(*v)).collect()
}

/// The transpose of the row-major (rows, columns) `values`.
fn transpose(values: &[f32], rows: usize, columns: usize) -> Vec<f32> {
    (0..columns).flat_map(|c| (0..rows).map(move |r| values[r * columns + c])).collect()
}

fn tensor<'a>(file: &SafeTensors<'a>, name: &str) -> Result<TensorView<'a>, PolicyFileError> {
    file.tensor(name).map_err(|_| PolicyFileError::Missing { name: name.to_owned() })
}

fn doubles(file: &SafeTensors<'_>, name: &str) -> Result<Vec<f64>, PolicyFileError> {
    let len = tensor(file, name)?.shape().iter().product();
    numbers(file, name, Dtype::F64, &[len], f64::from_le_bytes)
}

/// The numbers of tensor `name`, all finite, if it has this type and shape.
fn numbers<T: Copy + Into<f64>, const N: usize>(
    file: &SafeTensors<'_>,
    name: &str,
    dtype: Dtype,
    shape: &[usize],
    decode: impl Fn([u8; N]) -> T,
) -> Result<Vec<T>, PolicyFileError> {
    let view = tensor(file, name)?;
    if view.dtype() != dtype || view.shape() != shape || shape.contains(&0) {
        let expected = format!("{dtype:?} {shape:?}");
        let got = format!("{:?} {:?}", view.dtype(), view.shape());
        return Err(PolicyFileError::Shape { name: name.to_owned(), expected, got });
    }
    let (chunks, _) = view.data().as_chunks::<N>();
    let values: Vec<T> = chunks.iter().map(|c| decode(*c)).collect();
    match values.iter().map(|v| (*v).into()).find(|v| !v.is_finite()) {
        Some(value) => Err(PolicyFileError::NotFinite { name: name.to_owned(), value }),
        None => Ok(values),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use sindyna_core::{Mode, Policy as _, Seed};

    use super::*;
    use crate::SavedPolicy;

    fn policy() -> GaussianPolicy {
        let scaling = Scaling { center: vec![0.1, -3.0, 0.0], scale: vec![1.0, 1.0 / 3.0, 8.0] };
        let range = ActionRange::new(&[-2.0, 0.1], &[2.0, 0.7]).expect("finite ends");
        GaussianPolicy { net: ScaledNet { net: Mlp::random(&[3, 5, 4, 4], &mut Seed::new(2).numpy()), scaling }, range }
    }

    fn categorical() -> CategoricalPolicy {
        CategoricalPolicy { net: policy().net }
    }

    /// The tensors of [`policy`]'s file, with `change` made to them, as a file again.
    fn changed(change: impl Fn(&str, &mut Dtype, &mut Vec<usize>, &mut Vec<u8>)) -> Vec<u8> {
        let original = policy().to_safetensors();
        let file = SafeTensors::deserialize(&original).expect("just written");
        let mut tensors: Vec<_> =
            file.tensors().into_iter().map(|(n, t)| (n, t.dtype(), t.shape().to_vec(), t.data().to_vec())).collect();
        tensors.iter_mut().for_each(|(n, dtype, shape, data)| change(n, dtype, shape, data));
        let views = tensors.iter().map(|(n, dtype, shape, data)| {
            (n, TensorView::new(*dtype, shape.clone(), data).expect("changes keep data and shape together"))
        });
        let metadata = HashMap::from([(FORMAT_KEY.to_owned(), GAUSSIAN.to_owned())]);
        safetensors::serialize(views, Some(metadata)).expect("a small file")
    }

    #[test]
    fn a_policy_survives_its_file_to_the_last_bit() {
        let original = policy();
        let bytes = original.to_safetensors();
        let read = GaussianPolicy::from_safetensors(&bytes).expect("just written");
        assert_eq!(read, original);
        assert_eq!(read.to_safetensors(), bytes);
        let act = |p: &GaussianPolicy| {
            let mut a = [0.0; 2];
            p.act(&[0.3, -2.9, 1.0], Mode::Exploit, &mut Seed::new(0).numpy(), &mut a);
            a
        };
        assert_eq!(act(&read), act(&original));
    }

    #[test]
    fn either_kind_is_recognised_by_its_file_and_refused_as_the_other() {
        let kinds = [SavedPolicy::from(policy()), SavedPolicy::from(categorical())];
        for (kind, values) in kinds.into_iter().zip([2, 1]) {
            let bytes = kind.to_safetensors();
            let read = SavedPolicy::from_safetensors(&bytes).expect("just written");
            assert_eq!(read, kind);
            assert_eq!((read.observation_dim(), read.action_dim(), read.to_safetensors()), (3, values, bytes));
        }
        let other = GaussianPolicy::from_safetensors(&categorical().to_safetensors());
        assert!(matches!(other, Err(PolicyFileError::Format { found: Some(f) }) if f == CATEGORICAL));
        let other = CategoricalPolicy::from_safetensors(&policy().to_safetensors());
        assert!(matches!(other, Err(PolicyFileError::Format { found: Some(f) }) if f == GAUSSIAN));
    }

    #[test]
    fn a_file_tells_a_reader_without_this_crate_how_to_act() {
        let bytes = policy().to_safetensors();
        let file = SafeTensors::deserialize(&bytes).expect("just written");
        let weight = file.tensor("layers.0.weight").expect("a first layer");
        assert_eq!((weight.dtype(), weight.shape()), (Dtype::F32, [5, 3].as_slice()));
        let (_, metadata) = SafeTensors::read_metadata(&bytes).expect("just written");
        assert_eq!(metadata.metadata().as_ref().and_then(|m| m.get("format")).map(String::as_str), Some(GAUSSIAN));
    }

    #[test]
    fn broken_tensors_are_named() {
        type Change = fn(&mut Dtype, &mut Vec<usize>, &mut Vec<u8>);
        // The tensor that is changed, how, and the tensor that then fails.
        let cases: [(&str, Change, &str); 6] = [
            ("layers.1.weight", |_, _, d| d[..4].copy_from_slice(&f32::NAN.to_le_bytes()), "layers.1.weight"),
            ("center", |_, _, d| d[8..16].copy_from_slice(&f64::INFINITY.to_le_bytes()), "center"),
            ("layers.0.weight", |_, shape, _| shape.reverse(), "layers.0.weight"),
            ("layers.2.bias", |dtype, _, _| *dtype = Dtype::I32, "layers.2.bias"),
            ("layers.1.bias", |_, shape, d| (*shape, *d) = (vec![3], d[..12].to_vec()), "layers.1.weight"),
            ("layers.1.bias", |_, shape, d| (*shape, *d) = (vec![0], Vec::new()), "layers.1.weight"),
        ];
        for (broken, change, named) in cases {
            let bytes = changed(|n, dtype, shape, data| {
                if n == broken {
                    change(dtype, shape, data);
                }
            });
            let message = GaussianPolicy::from_safetensors(&bytes).expect_err(broken).to_string();
            assert!(message.contains(&format!("`{named}`")), "{broken}: {message}");
        }
    }

    #[test]
    fn impossible_scalings_and_ranges_are_refused() {
        for (tensor, value) in [("scale", -1.0), ("scale", 0.0), ("low", 9.0), ("high", -9.0)] {
            let bytes = changed(|n, _, _, data| {
                if n == tensor {
                    data[..8].copy_from_slice(&f64::to_le_bytes(value));
                }
            });
            let result = GaussianPolicy::from_safetensors(&bytes);
            assert!(matches!(result, Err(PolicyFileError::Values(_))), "{tensor}: {result:?}");
        }
    }

    #[test]
    fn files_of_another_kind_are_refused() {
        let other = safetensors::serialize(Vec::<(String, TensorView<'_>)>::new(), None).expect("an empty file");
        assert!(matches!(GaussianPolicy::from_safetensors(&other), Err(PolicyFileError::Format { found: None })));
        assert!(matches!(GaussianPolicy::from_safetensors(b"{}"), Err(PolicyFileError::Container(_))));
    }

    proptest! {
        #[test]
        fn truncated_files_are_refused(keep in 0_usize..10_000) {
            let bytes = policy().to_safetensors();
            let keep = keep % bytes.len();
            prop_assert!(SavedPolicy::from_safetensors(&bytes[..keep]).is_err());
            let bytes = categorical().to_safetensors();
            prop_assert!(SavedPolicy::from_safetensors(&bytes[..keep % bytes.len()]).is_err());
        }

        #[test]
        fn random_bytes_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..512)) {
            prop_assert!(SavedPolicy::from_safetensors(&bytes).is_err());
        }

        #[test]
        fn a_changed_byte_is_refused_or_makes_a_policy_that_acts(at in 0_usize..10_000, byte in any::<u8>()) {
            let mut bytes = policy().to_safetensors();
            let at = at % bytes.len();
            bytes[at] = byte;
            if let Ok(policy) = GaussianPolicy::from_safetensors(&bytes) {
                let mut action = vec![0.0; policy.action_dim()];
                let observation = vec![0.5; policy.observation_dim()];
                policy.act(&observation, Mode::Exploit, &mut Seed::new(0).numpy(), &mut action);
                // Huge parameters may overflow on the way; what they give then is no number, never a wild action.
                let ends = policy.action_low().iter().zip(policy.action_high());
                prop_assert!(action.iter().zip(ends).all(|(a, (low, high))| a.is_nan() || (low..=high).contains(&a)));
            }
        }

        #[test]
        fn a_changed_byte_is_refused_or_makes_a_policy_that_chooses(at in 0_usize..10_000, byte in any::<u8>()) {
            let mut bytes = categorical().to_safetensors();
            let at = at % bytes.len();
            bytes[at] = byte;
            if let Ok(policy) = CategoricalPolicy::from_safetensors(&bytes) {
                let n = policy.n_actions();
                let (observation, mut rng) = (vec![0.5; policy.observation_dim()], Seed::new(0).numpy());
                for mode in [Mode::Exploit, Mode::Explore] {
                    let mut action = [f64::NEG_INFINITY];
                    policy.act(&observation, mode, &mut rng, &mut action);
                    prop_assert!(action[0].is_nan() || (0..n).any(|a| action[0] == a as f64), "{action:?}");
                }
            }
        }
    }
}
