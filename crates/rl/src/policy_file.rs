//! Policies as bytes: a safetensors file with everything that is needed to act.

use std::collections::HashMap;

use safetensors::{Dtype, SafeTensorError, SafeTensors, tensor::TensorView};

use crate::{GaussianPolicy, SacError, Scaling, interface::ActionRange, mlp::Mlp};

/// The only metadata entry. There must be only one, because the order of several would not be fixed.
const FORMAT_KEY: &str = "format";
const FORMAT: &str = "sindyna squashed-gaussian policy 1: x = (observation - center) / scale; \
    x = relu(weight x + bias) per layer, the last without relu; (mean, log_std) = x; \
    action = low + (tanh(mean) + 1) / 2 * (high - low)";

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
    #[error("the file does not declare the format `{FORMAT}`, but {found:?}")]
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
        let doubles = |values: &[f64]| (Dtype::F64, vec![values.len()], bytes(values, |v| v.to_le_bytes()));
        let mut tensors = vec![
            ("center".to_owned(), doubles(&self.scaling.center)),
            ("scale".to_owned(), doubles(&self.scaling.scale)),
            ("low".to_owned(), doubles(self.range.low())),
            ("high".to_owned(), doubles(self.range.high())),
        ];
        for l in 0..self.net.depth() {
            let layer = self.net.layer(l);
            let (weights, biases) = layer.of(&self.net.params);
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
        let metadata = HashMap::from([(FORMAT_KEY.to_owned(), FORMAT.to_owned())]);
        safetensors::serialize(views, Some(metadata)).expect("names are short and data match their shapes")
    }

    /// The policy of a file made by [`Self::to_safetensors`].
    ///
    /// # Errors
    /// [`PolicyFileError`] if the bytes are no such file, whatever is wrong with them.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, PolicyFileError> {
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(PolicyFileError::Container)?;
        let found = metadata.metadata().as_ref().and_then(|m| m.get(FORMAT_KEY)).cloned();
        if found.as_deref() != Some(FORMAT) {
            return Err(PolicyFileError::Format { found });
        }
        let file = SafeTensors::deserialize(bytes).map_err(PolicyFileError::Container)?;
        let depth = file.names().iter().filter(|n| n.ends_with(".weight")).count().clamp(1, MOST_LAYERS);
        let known = |n: &str| {
            matches!(n, "center" | "scale" | "low" | "high")
                || (0..depth).any(|l| n == name(l, "weight") || n == name(l, "bias"))
        };
        if let Some(name) = file.names().into_iter().filter(|n| !known(n)).min() {
            return Err(PolicyFileError::Unexpected { name: name.to_owned() });
        }

        let scaling = Scaling { center: doubles(&file, "center")?, scale: doubles(&file, "scale")? };
        scaling.check()?;
        let range = ActionRange::new(&doubles(&file, "low")?, &doubles(&file, "high")?)?;

        let mut sizes = vec![scaling.width()];
        for l in 0..depth {
            let bias = tensor(&file, &name(l, "bias"))?;
            sizes.push(if l + 1 == depth { 2 * range.width() } else { bias.shape().iter().product() });
        }
        let mut params = Vec::new();
        for (l, widths) in sizes.windows(2).enumerate() {
            let (inputs, outputs) = (widths[0], widths[1]);
            let weights = numbers(&file, &name(l, "weight"), Dtype::F32, &[outputs, inputs], f32::from_le_bytes)?;
            params.extend(transpose(&weights, outputs, inputs));
            params.extend(numbers(&file, &name(l, "bias"), Dtype::F32, &[outputs], f32::from_le_bytes)?);
        }
        let net = Mlp::from_params(&sizes, params);
        Ok(Self { net, scaling, range })
    }
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
