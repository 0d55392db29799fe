//! Forward and backward passes through a network of an ensemble.

use super::activation::{Activation, swish_and_slope};
use crate::{
    Isa,
    affine::sum_rows,
    buffer::Buffer,
    kernel::{Finish, Matrix, matmul, matmul_and_sums},
    mlp::Mlp,
    thin::Thin,
};

/// What a network remembers of a batch between its passes. Memory is kept from call to call and serves every member in
/// turn.
///
/// SAC's [`Pass`](crate::pass::Pass) knows ReLU alone, whose slope is in its output; here slopes are kept.
#[derive(Debug, Clone)]
pub(super) struct Pass {
    isa: Isa,
    activation: Activation,
    /// Output of every layer, (rows, outputs) each.
    outputs: Vec<Buffer>,
    /// Slope of every hidden layer's activation at its sums; unused with ReLU.
    slopes: Vec<Buffer>,
    /// ∂L/∂(output of a layer) and ∂L/∂(input of that layer), taking turns.
    deltas: [Buffer; 2],
    thin: Thin,
}

impl Pass {
    pub(super) fn new(isa: Isa, activation: Activation) -> Self {
        Self {
            isa,
            activation,
            outputs: Vec::new(),
            slopes: Vec::new(),
            deltas: Default::default(),
            thin: Thin::default(),
        }
    }

    /// Runs `net` on the rows of `inputs` (rows, inputs); returns the outputs (rows, outputs).
    pub(super) fn forward(&mut self, net: &Mlp, inputs: &[f32]) -> &[f32] {
        let rows = inputs.len() / net.inputs();
        self.outputs.resize_with(net.depth(), Buffer::default);
        self.slopes.resize_with(net.depth(), Buffer::default);
        for l in 0..net.depth() {
            let layer = net.layer(l);
            let (weights, biases) = layer.of(&net.params);
            let (before, after) = self.outputs.split_at_mut(l);
            let x = Matrix::new(before.last().map_or(inputs, |x| &**x), rows, layer.inputs);
            let weights = Matrix::new(weights, layer.inputs, layer.outputs);
            let y = after[0].sized(rows * layer.outputs);
            match self.activation {
                _ if l + 1 == net.depth() => matmul(self.isa, y, x, weights, Finish::Biases(biases)),
                Activation::Relu => matmul(self.isa, y, x, weights, Finish::BiasesRelu(biases)),
                Activation::Swish => {
                    let z = self.slopes[l].sized(rows * layer.outputs);
                    matmul(self.isa, z, x, weights, Finish::Biases(biases));
                    swish_and_slope(z, y);
                }
            }
        }
        self.outputs.last().map_or(&[], |y| &**y)
    }

    /// Overwrites `gradients` with ∂L/∂params, given ∂L/∂outputs of the last forward pass over `inputs`.
    pub(super) fn backward(&mut self, net: &Mlp, inputs: &[f32], d_outputs: &[f32], gradients: &mut [f32]) {
        let rows = inputs.len() / net.inputs();
        self.deltas[0].sized(d_outputs.len()).copy_from_slice(d_outputs);
        sum_rows(d_outputs, net.layer(net.depth() - 1).of_mut(gradients).1);
        for l in (0..net.depth()).rev() {
            let layer = net.layer(l);
            let x = if l == 0 { inputs } else { &self.outputs[l - 1] };
            let (d_weights, _) = layer.of_mut(gradients);
            let [delta, d_inputs] = &mut self.deltas;
            let d_sums = Matrix::new(delta, rows, layer.outputs);
            if l + 1 == net.depth() {
                // Its few outputs fill vectors badly, its inputs well.
                self.thin.weight_gradients(self.isa, x, delta, layer.outputs, d_weights);
            } else {
                matmul(self.isa, d_weights, Matrix::new(x, rows, layer.inputs).t(), d_sums, Finish::Plain);
            }
            if l > 0 {
                let (weights, _) = layer.of(&net.params);
                let weights = Matrix::new(weights, layer.inputs, layer.outputs).t();
                let d_inputs = d_inputs.sized(rows * layer.inputs);
                let finish = match self.activation {
                    Activation::Relu => Finish::ThroughRelu { outputs: x, rows: None },
                    Activation::Swish => Finish::ThroughSlopes(&self.slopes[l - 1]),
                };
                let (_, d_biases) = net.layer(l - 1).of_mut(gradients);
                matmul_and_sums(self.isa, d_inputs, d_sums, weights, finish, Some(d_biases));
                self.deltas.swap(0, 1);
            }
        }
    }
}

/// The outputs of `net` for the rows `x`; nothing is remembered. The same bits as [`Pass::forward`]'s, whatever the
/// number of rows.
pub(super) fn infer(isa: Isa, activation: Activation, net: &Mlp, mut x: Vec<f32>) -> Vec<f32> {
    let rows = x.len() / net.inputs();
    let mut y = Vec::new();
    for l in 0..net.depth() {
        let layer = net.layer(l);
        let (weights, biases) = layer.of(&net.params);
        y.resize(rows * layer.outputs, 0.0);
        let weights = Matrix::new(weights, layer.inputs, layer.outputs);
        matmul(isa, &mut y, Matrix::new(&x, rows, layer.inputs), weights, Finish::Biases(biases));
        if l + 1 < net.depth() {
            activation.apply(&mut y);
        }
        std::mem::swap(&mut x, &mut y);
    }
    x
}
