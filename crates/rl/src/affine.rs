//! Row by row arithmetic of layers: all of it that is not a matrix product.

use crate::simd::vectorized;

/// max(v, 0), except that a number that is none stays none: a broken input must not look healthy.
#[inline(always)]
pub(crate) fn relu(v: f32) -> f32 {
    if v < 0.0 { 0.0 } else { v }
}

/// y = x W + b for one row, with ReLU if this is a `hidden` layer. Every sum starts at the bias and runs over the
/// inputs in order.
#[inline(always)]
pub(crate) fn affine_row(x: &[f32], weights: &[f32], biases: &[f32], hidden: bool, y: &mut [f32]) {
    let at = affine_blocks::<32>(x, weights, biases, hidden, y, 0);
    let at = affine_blocks::<8>(x, weights, biases, hidden, y, at);
    let at = affine_blocks::<2>(x, weights, biases, hidden, y, at);
    affine_blocks::<1>(x, weights, biases, hidden, y, at);
}

/// Outputs from `at` on, N at a time so that their sums stay in registers; returns the first that is left.
#[inline(always)]
fn affine_blocks<const N: usize>(
    x: &[f32],
    weights: &[f32],
    biases: &[f32],
    hidden: bool,
    y: &mut [f32],
    mut at: usize,
) -> usize {
    let n = biases.len();
    while at + N <= n {
        let mut sums = [0.0; N];
        sums.copy_from_slice(&biases[at..at + N]);
        for (v, row) in x.iter().zip(weights.chunks_exact(n)) {
            for (s, w) in sums.iter_mut().zip(&row[at..at + N]) {
                *s += v * w;
            }
        }
        if hidden {
            sums.iter_mut().for_each(|s| *s = relu(*s));
        }
        y[at..at + N].copy_from_slice(&sums);
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
