//! Row by row arithmetic of layers: all of it that is not a matrix product.

use crate::simd::vectorized;

/// max(v, 0), except that a number that is none stays none: a broken input must not look healthy.
#[inline(always)]
pub(crate) fn relu(v: f32) -> f32 {
    if v < 0.0 { 0.0 } else { v }
}

/// y = x W + b for R rows of numbers, each `stride` after the one before, with ReLU if this is a `hidden` layer. Every sum
/// starts at the bias and runs over the inputs in order, whatever R.
#[inline(always)]
pub(crate) fn affine_rows<const R: usize>(
    x: &[f32],
    stride: usize,
    (weights, biases): (&[f32], &[f32]),
    hidden: bool,
    y: &mut [f32],
) {
    let rows: [&[f32]; R] = std::array::from_fn(|r| &x[r * stride..(r + 1) * stride]);
    let layer = (weights, biases);
    let at = affine_blocks::<R, 16>(rows, layer, hidden, y, stride, 0);
    let at = affine_blocks::<R, 8>(rows, layer, hidden, y, stride, at);
    let at = affine_blocks::<R, 2>(rows, layer, hidden, y, stride, at);
    affine_blocks::<R, 1>(rows, layer, hidden, y, stride, at);
}

/// Outputs from `at` on, N at a time so that their sums stay in registers; returns the first that is left.
#[inline(always)]
fn affine_blocks<const R: usize, const N: usize>(
    x: [&[f32]; R],
    (weights, biases): (&[f32], &[f32]),
    hidden: bool,
    y: &mut [f32],
    stride: usize,
    mut at: usize,
) -> usize {
    let n = biases.len();
    while at + N <= n {
        let mut sums = [[0.0; N]; R];
        sums.iter_mut().for_each(|sums| sums.copy_from_slice(&biases[at..at + N]));
        for (i, row) in weights.chunks_exact(n).enumerate() {
            let row: &[f32; N] = row[at..].first_chunk().expect("N outputs are left");
            for (sums, x) in sums.iter_mut().zip(x) {
                let v = x[i];
                for (s, w) in sums.iter_mut().zip(row) {
                    *s += v * w;
                }
            }
        }
        for (r, mut sums) in sums.into_iter().enumerate() {
            if hidden {
                sums.iter_mut().for_each(|s| *s = relu(*s));
            }
            y[r * stride + at..r * stride + at + N].copy_from_slice(&sums);
        }
        at += N;
    }
    at
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
