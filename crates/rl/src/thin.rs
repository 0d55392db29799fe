//! Layers with a handful of outputs, for which a general matrix product spends its time on preparations.

use crate::{
    affine::passes,
    matmul::{Matrix, matmul},
    simd::vectorized,
};

/// Up to so many outputs a layer is thin.
pub(crate) const MOST_OUTPUTS: usize = 4;

/// Weights of a thin layer as (outputs, inputs). Memory is kept from call to call.
#[derive(Debug, Clone, Default)]
pub(crate) struct Thin {
    columns: Vec<f32>,
    d_columns: Vec<f32>,
    values: Vec<f32>,
}

impl Thin {
    fn load(&mut self, weights: &[f32], outputs: usize) {
        self.columns.clear();
        for o in 0..outputs {
            self.columns.extend(weights.iter().skip(o).step_by(outputs));
        }
    }

    /// y = x W + b for rows x (inputs), y (outputs): one product of a matrix and a vector per output.
    pub(crate) fn forward(&mut self, x: &[f32], weights: &[f32], biases: &[f32], y: &mut [f32]) {
        let outputs = biases.len();
        let inputs = weights.len() / outputs;
        let rows = y.len() / outputs;
        self.load(weights, outputs);
        self.values.resize(rows, 0.0);
        for (o, (w, b)) in self.columns.chunks_exact(inputs).zip(biases).enumerate() {
            matmul(&mut self.values, Matrix::new(x, rows, inputs), Matrix::new(w, inputs, 1));
            y.iter_mut().skip(o).step_by(outputs).zip(&self.values).for_each(|(y, v)| *y = v + b);
        }
    }

    /// ∂L/∂x into `d_x`, taken through the ReLU that made the layer's inputs `x`. Row i of ∂L/∂y `d_y` (outputs) and of
    /// `d_x` (inputs) belongs to row `rows[i]` of `x`.
    pub(crate) fn backward(
        &mut self,
        x: &[f32],
        rows: impl Iterator<Item = usize>,
        weights: &[f32],
        outputs: usize,
        d_y: &[f32],
        d_x: &mut [f32],
    ) {
        let inputs = weights.len() / outputs;
        self.load(weights, outputs);
        let (first, rest) = self.columns.split_at(inputs);
        vectorized(
            #[inline(always)]
            || {
                for ((row, d_x), d_y) in rows.zip(d_x.chunks_exact_mut(inputs)).zip(d_y.chunks_exact(outputs)) {
                    let x = &x[row * inputs..(row + 1) * inputs];
                    for ((d_x, x), w) in d_x.iter_mut().zip(x).zip(first) {
                        *d_x = d_y[0] * w * passes(*x);
                    }
                    for (d_y, w) in d_y[1..].iter().zip(rest.chunks_exact(inputs)) {
                        for ((d_x, x), w) in d_x.iter_mut().zip(x).zip(w) {
                            *d_x += d_y * w * passes(*x);
                        }
                    }
                }
            },
        );
    }

    /// Overwrites `d_weights` (inputs, outputs) with ∂L/∂W = xᵀ ∂L/∂y.
    pub(crate) fn weight_gradients(&mut self, x: &[f32], d_y: &[f32], outputs: usize, d_weights: &mut [f32]) {
        let inputs = d_weights.len() / outputs;
        self.d_columns.clear();
        self.d_columns.resize(d_weights.len(), 0.0);
        vectorized(
            #[inline(always)]
            || {
                for (x, d_y) in x.chunks_exact(inputs).zip(d_y.chunks_exact(outputs)) {
                    for (sums, d_y) in self.d_columns.chunks_exact_mut(inputs).zip(d_y) {
                        sums.iter_mut().zip(x).for_each(|(s, x)| *s += d_y * x);
                    }
                }
            },
        );
        for (i, row) in d_weights.chunks_exact_mut(outputs).enumerate() {
            for (o, d) in row.iter_mut().enumerate() {
                *d = self.d_columns[o * inputs + i];
            }
        }
    }
}
