//! Layers with a handful of outputs, whose outputs are too few to lie across a vector: inputs do instead.

use crate::{
    Isa,
    kernel::{Finish, Matrix, dots, matmul},
};

/// Up to so many outputs a layer is thin.
pub(crate) const MOST_OUTPUTS: usize = 4;

/// Weights of a thin layer as (outputs, inputs). Memory is kept from call to call.
#[derive(Debug, Clone, Default)]
pub(crate) struct Thin {
    columns: Vec<f32>,
}

impl Thin {
    /// y = x W + b for rows x (inputs), y (outputs): each row's products with the columns of W.
    pub(crate) fn forward(&mut self, isa: Isa, x: &[f32], weights: &[f32], biases: &[f32], y: &mut [f32]) {
        let outputs = biases.len();
        let columns = if outputs == 1 {
            weights
        } else {
            self.columns.clear();
            for o in 0..outputs {
                self.columns.extend(weights.iter().skip(o).step_by(outputs));
            }
            &self.columns
        };
        dots(isa, y, x, columns, weights.len() / outputs, Some(biases));
    }

    /// Overwrites `d_weights` (inputs, outputs) with ∂L/∂W = xᵀ ∂L/∂y, by way of its transpose.
    pub(crate) fn weight_gradients(&mut self, isa: Isa, x: &[f32], d_y: &[f32], outputs: usize, d_weights: &mut [f32]) {
        let inputs = d_weights.len() / outputs;
        let rows = d_y.len() / outputs;
        self.columns.resize(d_weights.len(), 0.0);
        let d_y = Matrix::new(d_y, rows, outputs).t();
        matmul(isa, &mut self.columns, d_y, Matrix::new(x, rows, inputs), Finish::Plain);
        for (i, row) in d_weights.chunks_exact_mut(outputs).enumerate() {
            for (o, d) in row.iter_mut().enumerate() {
                *d = self.columns[o * inputs + i];
            }
        }
    }
}
