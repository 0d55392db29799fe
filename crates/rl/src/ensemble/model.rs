//! The ensemble as what the loop knows: a learner of dynamics over the task's state.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ndarray::Array2;
use sindyna_core::{Dataset, Diverged, Dynamics, DynamicsLearner, FitError, Knowledge, Rng, Spec};

use super::{
    Ensemble, EnsembleConfig, EnsembleError, EnsembleTrainer, RewardHead, coordinates::Coordinates, trainer::shape,
};
use crate::{Isa, IsaError};

/// Learns an ensemble of probabilistic networks (o, u) → (o' - o, reward) from recorded rollouts.
///
/// o (m) is what the sensors showed, u (k) the control that was applied. Every fit goes on from the weights of the model
/// before it, on all of the data. The predicted reward is not used: reward and termination are the task's.
///
/// # References
/// Janner et al. (2019), arXiv:1906.08253.
#[derive(Debug, Clone)]
pub struct EnsembleLearner {
    trainer: EnsembleTrainer,
    coordinates: Coordinates,
    observation_dim: usize,
    control_dim: usize,
}

/// x' = F(x, u) + noise by a trained ensemble: x → o → a random elite's Gaussian → o' → x'.
///
/// o is the observation of x without the sensors' noise, which the networks have learned as part of their own. Every step
/// draws an elite anew. An angle seen as cosine and sine is read back by its arctangent, as near to the angle before as
/// whole turns allow; that the predicted pair is not quite on the circle does no harm.
#[derive(Debug, Clone)]
pub struct EnsembleModel {
    ensemble: Ensemble,
    coordinates: Coordinates,
    observation_dim: usize,
}

impl EnsembleLearner {
    /// A learner for the system `spec` declares, with the widest instructions this machine has.
    ///
    /// # Errors
    /// [`EnsembleError`] if a setting is outside its range, or states do not follow from observations.
    pub fn new(config: EnsembleConfig, spec: &Spec) -> Result<Self, EnsembleError> {
        Ok(Self {
            trainer: EnsembleTrainer::new(config)?,
            coordinates: Coordinates::new(spec)?,
            observation_dim: spec.observation_dim(),
            control_dim: spec.control_dim(),
        })
    }

    /// The same with the matrix products run by the instructions `isa`.
    ///
    /// # Errors
    /// [`IsaError::Missing`] if this machine lacks them.
    pub fn with_isa(self, isa: Isa) -> Result<Self, IsaError> {
        Ok(Self { trainer: self.trainer.with_isa(isa)?, ..self })
    }

    /// The same, whose fits end with [`FitError::Interrupted`] once `stop` is set.
    #[must_use]
    pub fn until(self, stop: Arc<AtomicBool>) -> Self {
        Self { trainer: self.trainer.until(stop), ..self }
    }

    /// Numbers that training adjusts.
    #[must_use]
    pub fn n_parameters(&self) -> usize {
        self.trainer.config().n_parameters(self.observation_dim, self.control_dim)
    }

    /// Inputs (N, m + k) and targets (N, q) of every step of `data`.
    fn table(&self, data: &Dataset) -> (Array2<f64>, Array2<f64>) {
        let (m, config) = (self.observation_dim, self.trainer.config());
        let (d, q) = (m + self.control_dim, config.n_targets(m));
        let (mut inputs, mut targets) = (Array2::zeros((data.n_steps(), d)), Array2::zeros((data.n_steps(), q)));
        let steps = data.rollouts().flat_map(|r| (0..r.controls.nrows()).map(move |t| (r, t)));
        for (row, (rollout, t)) in steps.enumerate() {
            let (o, next) = (rollout.observations.row(t), rollout.observations.row(t + 1));
            for (to, from) in inputs.row_mut(row).iter_mut().zip(o.iter().chain(rollout.controls.row(t))) {
                *to = *from;
            }
            for ((to, next), o) in targets.row_mut(row).iter_mut().zip(next).zip(o) {
                *to = next - o;
            }
            if config.reward_head == RewardHead::Trained {
                targets[[row, m]] = rollout.rewards[t];
            }
        }
        (inputs, targets)
    }
}

impl DynamicsLearner for EnsembleLearner {
    type Model = EnsembleModel;

    fn goes_on(&self) -> bool {
        true
    }

    fn fit(
        &self,
        data: &Dataset,
        previous: Option<&EnsembleModel>,
        rng: &mut Rng,
    ) -> Result<Option<Knowledge<EnsembleModel>>, FitError> {
        shape("observed values", self.observation_dim, data.observation_dim())?;
        shape("control values", self.control_dim, data.control_dim())?;
        let (inputs, targets) = self.table(data);
        let ensemble = self.trainer.fit(inputs.view(), targets.view(), previous.map(|p| &p.ensemble), rng)?;
        let (coordinates, observation_dim) = (self.coordinates.clone(), self.observation_dim);
        Ok(Some(Knowledge::approximate(EnsembleModel { ensemble, coordinates, observation_dim })))
    }

    fn describe(&self, model: &EnsembleModel) -> Vec<String> {
        let (config, report) = (model.ensemble.config(), model.ensemble.report());
        let widths = config.widths(model.ensemble.n_inputs(), model.ensemble.n_targets());
        let widths: Vec<String> = widths.iter().map(ToString::to_string).collect();
        let errors: Vec<String> =
            model.ensemble.elites().iter().map(|i| format!("{:.2e}", report.holdout_mse[*i])).collect();
        vec![
            format!("{} networks {}, {} numbers", config.members, widths.join("→"), model.ensemble.n_parameters()),
            format!(
                "{} epochs on {} rows; squared errors of {} elites on {} others: {}",
                report.history.len(),
                report.training_rows,
                errors.len(),
                report.holdout_rows.len(),
                errors.join(", ")
            ),
        ]
    }
}

impl EnsembleModel {
    /// The networks, in observation space: inputs (o; u), targets (o' - o, then the reward if it is predicted).
    #[must_use]
    pub fn ensemble(&self) -> &Ensemble {
        &self.ensemble
    }
}

impl Dynamics for EnsembleModel {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        let m = self.observation_dim;
        let mut inputs = vec![0.0; self.ensemble.n_inputs()];
        let (o, controls) = inputs.split_at_mut(m);
        self.coordinates.observe(x, rng, o);
        controls.copy_from_slice(u);
        let mut moved = vec![0.0; m];
        self.ensemble.sample(&inputs, rng, &mut moved);
        for (moved, o) in moved.iter_mut().zip(&inputs) {
            *moved += o;
        }
        self.coordinates.state(&moved, x, next);
        Diverged::check(next)
    }
}
