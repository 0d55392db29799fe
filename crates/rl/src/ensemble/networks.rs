//! Trained networks and what they predict.

use ndarray::{Array2, ArrayView2};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::Rng;

use super::{EnsembleConfig, FitReport, likelihood::deviation, pass::infer, standard::Standard};
use crate::{Isa, adam::Adam, mlp::Mlp};

/// One network, its optimiser, which a later fit goes on with, and the bounds of log σ² it predicts under.
#[derive(Debug, Clone)]
pub(super) struct Member {
    pub(super) net: Mlp,
    pub(super) adam: Adam,
    pub(super) bounds: Vec<f32>,
}

/// Networks that each predict a Gaussian of some targets (q) from some inputs (d): what
/// [`EnsembleTrainer::fit`](super::EnsembleTrainer::fit) hands over.
#[derive(Debug, Clone)]
pub struct Ensemble {
    pub(super) config: EnsembleConfig,
    pub(super) isa: Isa,
    pub(super) members: Vec<Member>,
    /// Bounds of log σ² that all members train under, upper ones of all targets first.
    pub(super) bounds: Vec<f32>,
    pub(super) bounds_adam: Adam,
    pub(super) input_scale: Standard,
    pub(super) target_scale: Standard,
    pub(super) elites: Vec<usize>,
    pub(super) report: FitReport,
}

/// Gaussians of every target for some rows of inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Means (rows, q), in the targets' units.
    pub mean: Array2<f64>,
    /// Standard deviations (rows, q), in the targets' units.
    pub deviation: Array2<f64>,
}

impl Ensemble {
    /// Number of inputs, d.
    #[must_use]
    pub fn n_inputs(&self) -> usize {
        self.input_scale.center.len()
    }

    /// Number of targets, q.
    #[must_use]
    pub fn n_targets(&self) -> usize {
        self.target_scale.center.len()
    }

    /// Numbers that training adjusts.
    #[must_use]
    pub fn n_parameters(&self) -> usize {
        self.parameters().count()
    }

    /// The numbers that training adjusts: members one after the other, layer by layer weights (inputs, outputs) and
    /// biases, then the upper bounds of log σ² and the lower ones.
    pub fn parameters(&self) -> impl Iterator<Item = f32> {
        self.members.iter().flat_map(|m| &m.net.params).chain(&self.bounds).copied()
    }

    /// The members used for prediction, the best on the holdout rows first.
    #[must_use]
    pub fn elites(&self) -> &[usize] {
        &self.elites
    }

    /// What it was made with.
    #[must_use]
    pub fn config(&self) -> &EnsembleConfig {
        &self.config
    }

    /// What the last fit did.
    #[must_use]
    pub fn report(&self) -> &FitReport {
        &self.report
    }

    /// What `member` predicts for each row of `inputs` (rows, d). A row's result does not depend on those beside it.
    ///
    /// # Panics
    /// If there is no such member, or the rows are not as wide as those of the fit.
    #[must_use]
    pub fn predict(&self, member: usize, inputs: ArrayView2<'_, f64>) -> Prediction {
        assert_eq!(inputs.ncols(), self.n_inputs(), "inputs of a row");
        let x = inputs.rows().into_iter().flat_map(|row| self.input_scale.apply(row).collect::<Vec<_>>()).collect();
        let member = &self.members[member];
        let outputs = infer(self.isa, self.config.activation, &member.net, x);
        let q = self.n_targets();
        let at = |row: usize, j: usize| self.target(&outputs[2 * q * row..2 * q * (row + 1)], &member.bounds, j);
        Prediction {
            mean: Array2::from_shape_fn((inputs.nrows(), q), |(row, j)| at(row, j).0),
            deviation: Array2::from_shape_fn((inputs.nrows(), q), |(row, j)| at(row, j).1),
        }
    }

    /// Draws an elite, and from its Gaussian for one row of `inputs` (d) the first of the targets, as many as `targets`
    /// has places.
    ///
    /// # Panics
    /// If `inputs` is not as wide as the rows of the fit, or `targets` wider.
    pub fn sample(&self, inputs: &[f64], rng: &mut Rng, targets: &mut [f64]) {
        assert_eq!(inputs.len(), self.n_inputs(), "inputs");
        assert!(targets.len() <= self.n_targets(), "targets");
        let elite = &self.members[self.elites[rng.random_range(0..self.elites.len())]];
        let x = self.input_scale.apply(inputs).collect();
        let outputs = infer(self.isa, self.config.activation, &elite.net, x);
        for (j, target) in targets.iter_mut().enumerate() {
            let (mean, deviation) = self.target(&outputs, &elite.bounds, j);
            let normal: f64 = StandardNormal.sample(rng);
            *target = mean + deviation * normal;
        }
    }

    /// Sets the bounds that all members train under to the mean of those they predict under.
    pub(super) fn meet_bounds(&mut self) {
        let count = self.members.len() as f32;
        for (j, bound) in self.bounds.iter_mut().enumerate() {
            *bound = self.members.iter().map(|m| m.bounds[j]).sum::<f32>() / count;
        }
    }

    /// Mean and standard deviation of target `j`, in its unit, from one row of a network's outputs (2q) under
    /// `bounds` (2q).
    fn target(&self, outputs: &[f32], bounds: &[f32], j: usize) -> (f64, f64) {
        let q = self.n_targets();
        let (center, spread) = (self.target_scale.center[j], self.target_scale.spread[j]);
        let deviation = deviation(outputs[q + j], bounds[q + j], bounds[j]);
        (center + spread * f64::from(outputs[j]), spread * deviation)
    }
}
