//! One step of training: the loss of a batch, its gradient, and a move against it.

use super::{Ensemble, likelihood::likelihood, pass::Pass, rows::Table};

/// The memory of one step of all members.
pub(super) struct Step {
    pub(super) pass: Pass,
    /// Widths of the networks from the inputs to the outputs.
    layers: Vec<usize>,
    batch: Table,
    /// ∂loss/∂outputs of the network at hand.
    d_outputs: Vec<f32>,
    pub(super) gradients: Vec<f32>,
    pub(super) d_bounds: Vec<f64>,
    bound_gradients: Vec<f32>,
}

impl Step {
    pub(super) fn new(ensemble: &Ensemble) -> Self {
        Self {
            pass: Pass::new(ensemble.isa, ensemble.config.activation),
            layers: ensemble.config.widths(ensemble.n_inputs(), ensemble.n_targets()),
            batch: Table::default(),
            d_outputs: Vec::new(),
            gradients: vec![0.0; ensemble.members.first().map_or(0, |m| m.net.params.len())],
            d_bounds: vec![0.0; ensemble.bounds.len()],
            bound_gradients: Vec::new(),
        }
    }

    /// Moves every member against the gradient of the loss of its part of `samples`, then the bounds.
    ///
    /// # Errors
    /// The first member whose loss is not finite, and that loss.
    pub(super) fn take<'a>(
        &mut self,
        ensemble: &mut Ensemble,
        training: &Table,
        samples: impl Iterator<Item = &'a [usize]>,
    ) -> Result<(), (usize, f64)> {
        let widths = (ensemble.n_inputs(), ensemble.n_targets());
        self.begin(ensemble);
        for (i, sample) in samples.enumerate() {
            let mut batch = std::mem::take(&mut self.batch);
            batch.gather(training, widths, sample);
            let loss = self.gradient(ensemble, i, &batch);
            self.batch = batch;
            if !loss.is_finite() {
                return Err((i, loss));
            }
            let member = &mut ensemble.members[i];
            // Weights decay, biases do not.
            let layers = self.layers.windows(2).zip(&ensemble.config.weight_decay);
            let parts = layers.flat_map(|(w, decay)| [(w[0] * w[1], *decay), (w[1], 0.0)]);
            member.adam.step_decaying(&mut member.net.params, &self.gradients, parts);
        }
        self.bound_gradients.clear();
        self.bound_gradients.extend(self.d_bounds.iter().map(|d| *d as f32));
        ensemble.bounds_adam.step(&mut ensemble.bounds, &self.bound_gradients);
        Ok(())
    }

    /// Sets the bounds' gradient to that of their own term of the loss.
    pub(super) fn begin(&mut self, ensemble: &Ensemble) {
        let (high, low) = self.d_bounds.split_at_mut(ensemble.bounds.len() / 2);
        high.fill(ensemble.config.bound_weight);
        low.fill(-ensemble.config.bound_weight);
    }

    /// Leaves the gradient of the loss of member `i` on `batch`, but for the weights' decay, in `gradients` and adds its
    /// part to the bounds'; returns the loss without the terms of weights and bounds.
    pub(super) fn gradient(&mut self, ensemble: &Ensemble, i: usize, batch: &Table) -> f64 {
        let net = &ensemble.members[i].net;
        let outputs = self.pass.forward(net, &batch.inputs);
        self.d_outputs.resize(outputs.len(), 0.0);
        let loss = likelihood(outputs, &batch.targets, &ensemble.bounds, &mut self.d_outputs, &mut self.d_bounds);
        self.pass.backward(net, &batch.inputs, &self.d_outputs, &mut self.gradients);
        loss
    }
}
