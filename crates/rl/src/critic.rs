//! One of the twin critics: Q(o, a), its slow target, its optimiser.

use sindyna_core::Rng;

use crate::{
    Isa,
    adam::Adam,
    mlp::Mlp,
    pass::{Deltas, Pass},
};

/// A critic and everything it learns with.
///
/// For real actions its input rows are the scaled observation followed by the action in -1..1, and its output is the one
/// value; for numbered actions they are the scaled observation alone, and there is a value per action.
#[derive(Debug, Clone)]
pub(crate) struct Critic {
    pub(crate) net: Mlp,
    pub(crate) target: Mlp,
    pub(crate) adam: Adam,
    pub(crate) gradients: Vec<f32>,
    pub(crate) pass: Pass,
    d_values: Vec<f32>,
}

impl Critic {
    /// A random critic of `sizes`; its target begins as a copy.
    pub(crate) fn new(sizes: &[usize], learning_rate: f64, rng: &mut Rng) -> Self {
        let net = Mlp::random(sizes, rng);
        let n_params = net.params.len();
        Self {
            target: net.clone(),
            net,
            adam: Adam::new(n_params, learning_rate),
            gradients: vec![0.0; n_params],
            pass: Pass::new(Isa::widest()),
            d_values: Vec::new(),
        }
    }

    /// The target's values of `rows` inputs.
    pub(crate) fn target_values(&mut self, inputs: &[f32], rows: usize) -> &[f32] {
        self.pass.forward(&self.target, inputs, rows)
    }

    /// The values of `rows` inputs.
    pub(crate) fn values(&mut self, inputs: &[f32], rows: usize) -> &[f32] {
        self.pass.forward(&self.net, inputs, rows)
    }

    /// Computes ½ mean (Q - y)² over the rows of `inputs` and its gradient; returns the loss. A row's Q is the output
    /// that `chosen` names.
    pub(crate) fn regress(
        &mut self,
        inputs: &[f32],
        chosen: impl Iterator<Item = usize>,
        targets: &[f32],
        deltas: &mut Deltas,
    ) -> f64 {
        let rows = targets.len();
        let width = self.net.outputs();
        let values = self.pass.forward(&self.net, inputs, rows);
        let per_row = 1.0 / rows as f32;
        self.d_values.clear();
        self.d_values.resize(rows * width, 0.0);
        let mut sum = 0.0;
        for (((values, d_values), column), y) in
            values.chunks_exact(width).zip(self.d_values.chunks_exact_mut(width)).zip(chosen).zip(targets)
        {
            let error = values[column] - y;
            sum += f64::from(error) * f64::from(error);
            d_values[column] = error * per_row;
        }
        self.pass.backward_params(&self.net, inputs, &self.d_values, deltas, &mut self.gradients);
        0.5 * sum / rows as f64
    }

    /// Moves the critic against the gradient of [`Self::regress`], and its target after it.
    pub(crate) fn step(&mut self, polyak: f64) {
        self.adam.step_and_track(&mut self.net.params, &self.gradients, &mut self.target.params, polyak);
    }

    /// ∂L/∂(input columns from `first` on), given that ∂L/∂Q is `d_value` in the rows `rows` of the last
    /// [`Self::values`].
    pub(crate) fn input_gradients<'a>(
        &mut self,
        rows: &[usize],
        d_value: f32,
        deltas: &'a mut Deltas,
        first: usize,
    ) -> &'a [f32] {
        self.d_values.clear();
        self.d_values.resize(rows.len(), d_value);
        self.pass.backward_inputs(&self.net, rows, &self.d_values, deltas, first)
    }
}
