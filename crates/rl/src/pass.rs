//! Forward and backward passes of a network over a batch of rows.

use crate::{
    Isa,
    affine::sum_rows,
    buffer::Buffer,
    kernel::{Finish, Matrix, dots, matmul, matmul_and_sums},
    mlp::Mlp,
    thin::{MOST_OUTPUTS, Thin},
};

/// What one network remembers of a batch between its forward and its backward pass. Memory is kept from call to call.
#[derive(Debug, Clone)]
pub(crate) struct Pass {
    pub(crate) isa: Isa,
    /// Output of every layer, (rows, outputs) each.
    outputs: Vec<Buffer>,
    thin: Thin,
}

/// ∂L/∂(output of a layer) and ∂L/∂(input of that layer), taking turns: memory of a backward pass that no later one needs, so
/// that those of all networks share it, and it stays in the caches.
#[derive(Debug, Clone, Default)]
pub(crate) struct Deltas([Buffer; 2]);

impl Pass {
    /// Memory of a pass that runs with the instructions `isa`.
    pub(crate) fn new(isa: Isa) -> Self {
        Self { isa, outputs: Vec::new(), thin: Thin::default() }
    }

    /// Runs `net` on the rows of `inputs` (rows, inputs); returns the outputs (rows, outputs).
    pub(crate) fn forward(&mut self, net: &Mlp, inputs: &[f32], rows: usize) -> &[f32] {
        self.outputs.resize_with(net.depth(), Buffer::default);
        for l in 0..net.depth() {
            let layer = net.layer(l);
            let (weights, biases) = layer.of(&net.params);
            let (before, after) = self.outputs.split_at_mut(l);
            let x = before.last().map_or(inputs, |x| &**x);
            let y = after[0].sized(rows * layer.outputs);
            let hidden = l + 1 < net.depth();
            if layer.outputs <= MOST_OUTPUTS && !hidden {
                self.thin.forward(self.isa, x, weights, biases, y);
            } else {
                let (x, weights) =
                    (Matrix::new(x, rows, layer.inputs), Matrix::new(weights, layer.inputs, layer.outputs));
                let finish = if hidden { Finish::BiasesRelu(biases) } else { Finish::Biases(biases) };
                matmul(self.isa, y, x, weights, finish);
            }
        }
        self.outputs.last().map_or(&[], |y| &**y)
    }

    /// Overwrites `gradients` with ∂L/∂params, given ∂L/∂outputs `d_outputs` of the first rows of the last forward
    /// pass over `inputs`; rows beyond those of `d_outputs` do not count.
    pub(crate) fn backward_params(
        &mut self,
        net: &Mlp,
        inputs: &[f32],
        d_outputs: &[f32],
        deltas: &mut Deltas,
        gradients: &mut [f32],
    ) {
        let rows = d_outputs.len() / net.outputs();
        deltas.begin(d_outputs);
        let last = net.layer(net.depth() - 1);
        sum_rows(d_outputs, last.of_mut(gradients).1);
        for l in (0..net.depth()).rev() {
            let layer = net.layer(l);
            let x = if l == 0 { inputs } else { &self.outputs[l - 1] };
            let x = &x[..rows * layer.inputs];
            let (d_weights, _) = layer.of_mut(gradients);
            if layer.outputs <= MOST_OUTPUTS {
                self.thin.weight_gradients(self.isa, x, &deltas.0[0], layer.outputs, d_weights);
            } else {
                let delta = Matrix::new(&deltas.0[0], rows, layer.outputs);
                matmul(self.isa, d_weights, Matrix::new(x, rows, layer.inputs).t(), delta, Finish::Plain);
            }
            if l > 0 {
                self.through_layer(net, l, None, deltas, Some(net.layer(l - 1).of_mut(gradients).1));
            }
        }
    }

    /// ∂L/∂inputs from column `first` on, shape (rows of `d_outputs`, inputs - first). `d_outputs` is ∂L/∂outputs of
    /// the rows `rows` of the last forward pass. No parameter's gradient is computed.
    pub(crate) fn backward_inputs<'a>(
        &self,
        net: &Mlp,
        rows: &[usize],
        d_outputs: &[f32],
        deltas: &'a mut Deltas,
        first: usize,
    ) -> &'a [f32] {
        debug_assert_eq!(d_outputs.len(), rows.len() * net.outputs());
        deltas.begin(d_outputs);
        for l in (1..net.depth()).rev() {
            self.through_layer(net, l, Some(rows), deltas, None);
        }
        let layer = net.layer(0);
        let (weights, _) = layer.of(&net.params);
        let wanted = layer.inputs - first;
        let [delta, d_inputs] = &mut deltas.0;
        let d_inputs = d_inputs.sized(rows.len() * wanted);
        // A row of W belongs to an input, so the few that are wanted are products of rows.
        dots(self.isa, d_inputs, delta, &weights[first * layer.outputs..], layer.outputs, None);
        d_inputs
    }

    /// Carries the first of `deltas` from the output of layer `l` (at least 1) to the output of the layer before, through W and
    /// ReLU, and overwrites `d_biases` with the gradient by that layer's biases. Its rows belong to the first of the last
    /// forward pass, or to `rows` of it.
    fn through_layer(
        &self,
        net: &Mlp,
        l: usize,
        rows: Option<&[usize]>,
        deltas: &mut Deltas,
        d_biases: Option<&mut [f32]>,
    ) {
        let layer = net.layer(l);
        let (weights, _) = layer.of(&net.params);
        let [delta, d_inputs] = &mut deltas.0;
        let n_rows = delta.len() / layer.outputs;
        let d_inputs = d_inputs.sized(n_rows * layer.inputs);
        let weights = Matrix::new(weights, layer.inputs, layer.outputs).t();
        let finish = Finish::ThroughRelu { outputs: &self.outputs[l - 1], rows };
        let delta = Matrix::new(delta, n_rows, layer.outputs);
        matmul_and_sums(self.isa, d_inputs, delta, weights, finish, d_biases);
        deltas.0.swap(0, 1);
    }
}

impl Deltas {
    fn begin(&mut self, d_outputs: &[f32]) {
        self.0[0].sized(d_outputs.len()).copy_from_slice(d_outputs);
    }
}
