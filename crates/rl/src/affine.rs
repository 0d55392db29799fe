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

/// Adds `biases` to every row of `y`, and applies ReLU if this is a `hidden` layer.
pub(crate) fn add_biases(y: &mut [f32], biases: &[f32], hidden: bool) {
    vectorized(
        #[inline(always)]
        || {
            for row in y.chunks_exact_mut(biases.len()) {
                if hidden {
                    row.iter_mut().zip(biases).for_each(|(v, b)| *v = relu(*v + b));
                } else {
                    row.iter_mut().zip(biases).for_each(|(v, b)| *v += b);
                }
            }
        },
    );
}

/// Clears the gradients `d` of units whose output was 0; gradient row i belongs to row `rows[i]` of the outputs `y`,
/// both `width` wide.
pub(crate) fn through_relu(d: &mut [f32], y: &[f32], rows: impl Iterator<Item = usize>, width: usize) {
    vectorized(
        #[inline(always)]
        || {
            for (d, row) in d.chunks_exact_mut(width).zip(rows) {
                for (d, y) in d.iter_mut().zip(&y[row * width..(row + 1) * width]) {
                    *d *= passes(*y);
                }
            }
        },
    );
}

/// 1 where a ReLU that gave `y` lets gradients pass, else 0.
///
/// A factor, because a branch is no vector code and a select becomes a masked store, which is ten times slower on some
/// processors.
#[inline(always)]
pub(crate) fn passes(y: f32) -> f32 {
    if y > 0.0 { 1.0 } else { 0.0 }
}

/// Overwrites `sums` with the sums over the rows of `values`.
pub(crate) fn sum_rows(values: &[f32], sums: &mut [f32]) {
    vectorized(
        #[inline(always)]
        || {
            sums.fill(0.0);
            for row in values.chunks_exact(sums.len()) {
                sums.iter_mut().zip(row).for_each(|(s, v)| *s += v);
            }
        },
    );
}
