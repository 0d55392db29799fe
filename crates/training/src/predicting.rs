//! Policies for controls that act late.

use std::collections::VecDeque;
use std::sync::Arc;

use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use sindyna_core::{Acting, Inverse, Memory, Mode, Observe as _, Policy, Rng, Seed, Sensors, Space, TrainedPolicy};
use sindyna_sindy::Model;

use crate::Error;
use crate::problem::{Late, Problem};

/// A policy whose controls act late: it acts on the state that `model` predicts for the moment in which its control begins to act, from the state now and the controls
/// that have not acted yet (Smith predictor). What actuators with a lag deliver, the last states, is computed from its controls: no sensor shows it. Before an episode the controls were
/// zero.
///
/// O. J. M. Smith, "Closer control of loops with dead time", Chemical Engineering Progress 53 (1957).
pub struct Predicting<P> {
    policy: P,
    model: Model,
    late: Late,
    inverse: Inverse,
    sensors: Sensors,
    space: Space,
}

impl<P: Policy> Predicting<P> {
    /// `policy` for `problem`, whose controls act as `late` as that says, with predictions of `model`.
    ///
    /// # Errors
    /// [`Error::System`] if the states do not follow from the observation.
    pub fn new(policy: P, problem: &dyn Problem, model: Model, late: Late) -> Result<Self, Error> {
        let spec = problem.spec();
        let refused = |why: String| Error::System { name: spec.name.clone(), why };
        let unseen = |unseen| refused(format!("its controls act late, and a state cannot be predicted: {unseen}"));
        let inverse = Inverse::of(spec).map_err(unseen)?;
        let (sensors, space) = (problem.sensors().without_noise(), spec.action_space.clone());
        Ok(Self { policy, model, late, inverse, sensors, space })
    }

    /// How many actuators have a lag: none, or one for each control.
    fn actuators(&self) -> usize {
        if self.late.lags() { self.space.control_dim() } else { 0 }
    }

    /// The state behind `observation` (m), near the one before, `x` (n), and written there; what actuators deliver stays.
    fn measured(&self, observation: &[f64], x: &mut [f64]) {
        let near = x.to_vec();
        self.inverse.state(observation, &near, x);
        let first = near.len() - self.actuators();
        x[first..].copy_from_slice(&near[first..]);
    }

    /// The observation of the state that follows `x` (n), seen as `observation` (m), once the controls `pending` have acted; as it is where predictions diverge.
    fn predicted(&self, observation: &[f64], x: &[f64], pending: &VecDeque<Vec<f64>>) -> Vec<f64> {
        let mut seen = observation.to_vec();
        if let Some(x) = self.late.moved(&self.model, x, pending.iter().map(Vec::as_slice)) {
            self.sensors.observe(&x, &mut Seed::new(0).stream("no noise", 0), &mut seen);
        }
        seen
    }

    /// Those before an episode.
    fn none(&self) -> VecDeque<Vec<f64>> {
        self.late.none(self.space.control_dim())
    }
}

impl<P: Policy> Policy for Predicting<P> {
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        let none = self.none();
        let mut seen = Array2::zeros(observations.raw_dim());
        for (mut seen, o) in seen.rows_mut().into_iter().zip(observations.rows()) {
            let (o, mut x) = (o.to_vec(), vec![0.0; self.inverse.n_states()]);
            self.measured(&o, &mut x);
            let predicted = self.predicted(&o, &x, &none);
            seen.iter_mut().zip(predicted).for_each(|(seen, predicted)| *seen = predicted);
        }
        self.policy.act_batch(seen.view(), mode, rng, actions);
    }

    fn begin(&self) -> Option<Box<dyn Memory + '_>> {
        let x = vec![0.0; self.inverse.n_states()];
        Some(Box::new(Ahead { acting: Acting::begin(&self.policy), pending: self.none(), x, of: self }))
    }
}

impl TrainedPolicy for Predicting<Arc<dyn TrainedPolicy>> {
    /// Those of the policy, which acts on predicted states.
    fn to_bytes(&self) -> Vec<u8> {
        self.policy.to_bytes()
    }
}

/// A [`Predicting`] policy in the middle of an episode.
struct Ahead<'a, P> {
    acting: Acting<'a>,
    /// Controls that have not acted yet, the oldest first.
    pending: VecDeque<Vec<f64>>,
    /// The state last measured, with what actuators deliver now.
    x: Vec<f64>,
    of: &'a Predicting<P>,
}

impl<P: Policy> Memory for Ahead<'_, P> {
    fn act(&mut self, observation: &[f64], mode: Mode, rng: &mut Rng, action: &mut [f64]) {
        self.of.measured(observation, &mut self.x);
        let seen = self.of.predicted(observation, &self.x, &self.pending);
        self.acting.act(&seen, mode, rng, action);
        let mut control = vec![0.0; self.of.space.control_dim()];
        self.of.space.control_into(action, &mut control);
        self.pending.push_back(control);
        if self.of.late.lags() {
            let next = self.of.late.stepped(&self.of.model, &self.x, &self.pending);
            let first = self.x.len() - self.of.actuators();
            // It depends on no other state.
            next.into_iter().for_each(|next| self.x[first..].copy_from_slice(&next[first..]));
        }
        self.pending.pop_front();
    }
}
