//! Forward and backward passes of a network over a batch of rows.

use crate::{
    matmul::{Matrix, matmul},
    mlp::{Mlp, relu},
    simd::vectorized,
};

/// What one network remembers of a batch between its forward and its backward pass. Memory is kept from call to call.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pass {
    rows: usize,
    /// Output of every layer, (rows, outputs) each.
    outputs: Vec<Vec<f32>>,
    /// ∂L/∂(output of a layer) and ∂L/∂(input of that layer), taking turns.
    deltas: [Vec<f32>; 2],
}

impl Pass {
    /// Runs `net` on the rows of `inputs` (rows, inputs); returns the outputs (rows, outputs).
    pub(crate) fn forward(&mut self, net: &Mlp, inputs: &[f32], rows: usize) -> &[f32] {
        self.rows = rows;
        self.outputs.resize(net.depth(), Vec::new());
        for l in 0..net.depth() {
            let layer = net.layer(l);
            let (weights, biases) = layer.of(&net.params);
            let (before, after) = self.outputs.split_at_mut(l);
            let x = before.last().map_or(inputs, Vec::as_slice);
            let y = &mut after[0];
            y.resize(rows * layer.outputs, 0.0);
            let x = Matrix::new(x, rows, layer.inputs);
            matmul(y, x, Matrix::new(weights, layer.inputs, layer.outputs));
            add_biases(y, biases, l + 1 < net.depth());
        }
        self.outputs.last().map_or(&[], Vec::as_slice)
    }

    /// Overwrites `gradients` with ∂L/∂params, given ∂L/∂outputs `d_outputs` of the first rows of the last forward
    /// pass over `inputs`; rows beyond those of `d_outputs` do not count.
    pub(crate) fn backward_params(&mut self, net: &Mlp, inputs: &[f32], d_outputs: &[f32], gradients: &mut [f32]) {
        let rows = self.begin(net, d_outputs);
        for l in (0..net.depth()).rev() {
            let layer = net.layer(l);
            let x = if l == 0 { inputs } else { &self.outputs[l - 1] };
            let x = &x[..rows * layer.inputs];
            let (d_weights, d_biases) = layer.of_mut(gradients);
            let delta = Matrix::new(&self.deltas[0], rows, layer.outputs);
            matmul(d_weights, Matrix::new(x, rows, layer.inputs).t(), delta);
            sum_rows(&self.deltas[0], d_biases);
            if l > 0 {
                self.through_layer(net, l);
            }
        }
    }

    /// ∂L/∂inputs from column `first` on, shape (rows, inputs - first), given ∂L/∂outputs `d_outputs` of the last
    /// forward pass. No parameter's gradient is computed.
    pub(crate) fn backward_inputs(&mut self, net: &Mlp, d_outputs: &[f32], first: usize) -> &[f32] {
        let rows = self.begin(net, d_outputs);
        for l in (1..net.depth()).rev() {
            self.through_layer(net, l);
        }
        let layer = net.layer(0);
        let (weights, _) = layer.of(&net.params);
        let wanted = layer.inputs - first;
        let weights = Matrix::new(&weights[first * layer.outputs..], wanted, layer.outputs);
        let [delta, d_inputs] = &mut self.deltas;
        d_inputs.resize(rows * wanted, 0.0);
        matmul(d_inputs, Matrix::new(delta, rows, layer.outputs), weights.t());
        d_inputs
    }

    /// Takes ∂L/∂outputs in; returns the number of its rows.
    fn begin(&mut self, net: &Mlp, d_outputs: &[f32]) -> usize {
        let rows = d_outputs.len() / net.outputs();
        debug_assert!(rows <= self.rows && d_outputs.len() == rows * net.outputs());
        self.deltas[0].clear();
        self.deltas[0].extend_from_slice(d_outputs);
        rows
    }

    /// Carries `deltas[0]` from the output of layer `l` (at least 1) to the output of the layer before, through W and ReLU.
    fn through_layer(&mut self, net: &Mlp, l: usize) {
        let layer = net.layer(l);
        let (weights, _) = layer.of(&net.params);
        let [delta, d_inputs] = &mut self.deltas;
        let rows = delta.len() / layer.outputs;
        d_inputs.resize(rows * layer.inputs, 0.0);
        let weights = Matrix::new(weights, layer.inputs, layer.outputs);
        matmul(d_inputs, Matrix::new(delta, rows, layer.outputs), weights.t());
        let active = &self.outputs[l - 1][..rows * layer.inputs];
        vectorized(
            #[inline(always)]
            || {
                for (d, y) in d_inputs.iter_mut().zip(active) {
                    // A select, not a branch: branches keep this loop from becoming vector code.
                    *d = if *y > 0.0 { *d } else { 0.0 };
                }
            },
        );
        self.deltas.swap(0, 1);
    }
}

/// Adds `biases` to every row of `y`, and applies ReLU if this is a `hidden` layer.
fn add_biases(y: &mut [f32], biases: &[f32], hidden: bool) {
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

/// Overwrites `sums` with the sums over the rows of `values`.
fn sum_rows(values: &[f32], sums: &mut [f32]) {
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
