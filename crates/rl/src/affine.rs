//! Row by row arithmetic of layers: all of it that is not a matrix product.

use pulp::Simd;

use sindyna_core::vectorized;

/// max(v, 0), except that a number that is none stays none: a broken input must not look healthy.
#[inline(always)]
pub(crate) fn relu(v: f32) -> f32 {
    if v < 0.0 { 0.0 } else { v }
}

/// y = x W + b for R rows of numbers, each `stride` after the one before, with ReLU if this is a `hidden` layer. Every sum
/// starts at the bias and runs over the inputs in order, whatever R and however wide the vectors: products and sums are not fused.
#[inline(always)]
pub(crate) fn affine_rows<S: Simd, const R: usize>(
    simd: S,
    x: &[f32],
    stride: usize,
    (weights, biases): (&[f32], &[f32]),
    hidden: bool,
    y: &mut [f32],
) {
    let rows: [&[f32]; R] = std::array::from_fn(|r| &x[r * stride..(r + 1) * stride]);
    let layer = Layer { simd, weights, biases, hidden };
    let whole = S::as_simd_f32s(biases).0.len();
    let mut at = 0;
    while at + 2 <= whole {
        layer.vectors::<R, 2>(rows, at, y, stride);
        at += 2;
    }
    if at < whole {
        layer.vectors::<R, 1>(rows, at, y, stride);
    }
    layer.rest(rows, biases.len() - S::as_simd_f32s(biases).1.len(), y, stride);
}

/// A layer's weights (inputs, outputs) and biases (outputs).
struct Layer<'a, S> {
    simd: S,
    weights: &'a [f32],
    biases: &'a [f32],
    hidden: bool,
}

impl<S: Simd> Layer<'_, S> {
    /// N vectors of outputs from the `at`-th vector on, so that their sums stay in registers.
    #[inline(always)]
    fn vectors<const R: usize, const N: usize>(&self, x: [&[f32]; R], at: usize, y: &mut [f32], stride: usize) {
        let of = |row| -> [S::f32s; N] { *S::as_simd_f32s(row).0[at..].first_chunk().expect("N vectors are left") };
        let mut sums = [of(self.biases); R];
        for (i, row) in self.weights.chunks_exact(self.biases.len()).enumerate() {
            let row = of(row);
            for (sums, x) in sums.iter_mut().zip(x) {
                let x = self.simd.splat_f32s(x[i]);
                for (sum, w) in sums.iter_mut().zip(row) {
                    *sum = self.simd.add_f32s(*sum, self.simd.mul_f32s(x, w));
                }
            }
        }
        for (sums, y) in sums.into_iter().zip(y.chunks_exact_mut(stride)) {
            for (y, sum) in S::as_mut_simd_f32s(y).0[at..].iter_mut().zip(sums) {
                *y = self.finished(sum);
            }
        }
    }

    /// Outputs from `at` on, fewer than fill a vector.
    #[inline(always)]
    fn rest<const R: usize>(&self, x: [&[f32]; R], at: usize, y: &mut [f32], stride: usize) {
        let n = self.biases.len();
        if at == n {
            return;
        }
        let mut sums = [self.simd.partial_load_f32s(&self.biases[at..]); R];
        for (i, row) in self.weights.chunks_exact(n).enumerate() {
            let row = self.simd.partial_load_f32s(&row[at..]);
            for (sum, x) in sums.iter_mut().zip(x) {
                *sum = self.simd.add_f32s(*sum, self.simd.mul_f32s(self.simd.splat_f32s(x[i]), row));
            }
        }
        for (sum, y) in sums.into_iter().zip(y.chunks_exact_mut(stride)) {
            self.simd.partial_store_f32s(&mut y[at..n], self.finished(sum));
        }
    }

    /// [`relu`] of a hidden layer's sums.
    #[inline(always)]
    fn finished(&self, sum: S::f32s) -> S::f32s {
        let zero = self.simd.splat_f32s(0.0);
        if self.hidden { self.simd.select_f32s(self.simd.less_than_f32s(sum, zero), zero, sum) } else { sum }
    }
}

/// Overwrites `sums` with the sums over the rows of `values`.
pub(crate) fn sum_rows(values: &[f32], sums: &mut [f32]) {
    vectorized(
        #[inline(always)]
        || {
            let at = sum_blocks::<64>(values, sums, 0);
            let at = sum_blocks::<8>(values, sums, at);
            sum_blocks::<1>(values, sums, at);
        },
    );
}

/// Columns from `at` on, N at a time so that their sums stay in registers; returns the first that is left.
#[inline(always)]
fn sum_blocks<const N: usize>(values: &[f32], sums: &mut [f32], mut at: usize) -> usize {
    let n = sums.len();
    while at + N <= n {
        let mut block = [0.0; N];
        for row in values.chunks_exact(n) {
            for (s, v) in block.iter_mut().zip(&row[at..at + N]) {
                *s += v;
            }
        }
        sums[at..at + N].copy_from_slice(&block);
        at += N;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = x W + b, one number after the other.
    fn plain(x: &[f32], weights: &[f32], biases: &[f32], hidden: bool) -> Vec<f32> {
        let sum =
            |j: usize| x.iter().enumerate().fold(biases[j], |sum, (i, x)| sum + x * weights[i * biases.len() + j]);
        (0..biases.len()).map(|j| if hidden { relu(sum(j)) } else { sum(j) }).collect()
    }

    struct Affine<'a>(&'a [f32], (&'a [f32], &'a [f32]), bool);

    impl pulp::WithSimd for Affine<'_> {
        type Output = Vec<f32>;
        fn with_simd<S: Simd>(self, simd: S) -> Vec<f32> {
            let Self(x, layer, hidden) = self;
            let mut y = vec![0.0; x.len()];
            affine_rows::<S, 3>(simd, x, x.len() / 3, layer, hidden, &mut y);
            y
        }
    }

    #[test]
    fn vectors_of_any_width_give_the_sums_in_order() {
        const INPUTS: usize = 7;
        let number = |i: usize| (1.7 * i as f32).sin() * if i.is_multiple_of(11) { 0.0 } else { 3.0 };
        for outputs in 1..=70 {
            let stride = outputs.max(INPUTS);
            let x: Vec<f32> = (0..3 * stride).map(|i| if i == 2 { f32::NAN } else { number(i) }).collect();
            let weights: Vec<f32> = (0..INPUTS * outputs).map(|i| number(i + 5)).collect();
            let biases: Vec<f32> = (0..outputs).map(number).collect();
            for hidden in [false, true] {
                let layer = (&weights[..], &biases[..]);
                for y in [
                    pulp::Arch::new().dispatch(Affine(&x, layer, hidden)),
                    pulp::Arch::Scalar.dispatch(Affine(&x, layer, hidden)),
                ] {
                    for (x, y) in x.chunks(stride).zip(y.chunks(stride)) {
                        let bits = |v: &[f32]| {
                            v.iter()
                                .map(|v| if v.is_nan() { f32::NAN.to_bits() } else { v.to_bits() })
                                .collect::<Vec<_>>()
                        };
                        assert_eq!(
                            bits(&y[..outputs]),
                            bits(&plain(&x[..INPUTS], &weights, &biases, hidden)),
                            "{outputs} outputs"
                        );
                    }
                }
            }
        }
    }
}
