//! Many systems stepped side by side, so that a policy acts for all of them at once.

use ndarray::{Array2, ArrayView1, s};
use sindyna_core::{EnvError, Environment, Memory, Mode, Outcome, Policy, Rng, Spec, Transition};

/// A system among others, with what is kept in mind of its rollout.
pub(crate) trait Lane {
    type System: Environment;

    fn system(&self) -> &Self::System;

    /// The system, and what its steps draw from: random numbers of its own, or those that all have in `common`.
    fn with_rng<'a>(&'a mut self, common: &'a mut Rng) -> (&'a mut Self::System, &'a mut Rng);

    /// Who acts in this rollout alone; `None` where the policy acts for all of them at once.
    fn memory(&mut self) -> Option<&mut dyn Memory> {
        None
    }
}

/// Systems stepped side by side.
pub(crate) struct Lockstep<T> {
    pub(crate) lanes: Vec<T>,
    observations: Array2<f64>,
    actions: Array2<f64>,
}

/// What a step led to in one lane.
pub(crate) struct Step<'a> {
    before: &'a [f64],
    action: &'a [f64],
    pub(crate) outcome: Result<Outcome, EnvError>,
}

impl Step<'_> {
    /// The step as it is replayed, after which `system` is as it is, and whether the rollout ended; `None` if the step failed.
    pub(crate) fn transition<'a>(&'a self, system: &'a impl Environment) -> Option<(Transition<'a>, bool)> {
        let Outcome { reward, terminated, truncated } = *self.outcome.as_ref().ok()?;
        let (observation, action, next_observation) = (self.before, self.action, system.observation());
        Some((Transition { observation, action, reward, next_observation, terminated }, terminated || truncated))
    }
}

impl<T: Lane> Lockstep<T> {
    /// The systems in `lanes`, all of them as `spec` says.
    pub(crate) fn new(spec: &Spec, lanes: Vec<T>) -> Self {
        let observations = Array2::zeros((lanes.len(), spec.observation_dim()));
        let actions = Array2::zeros((lanes.len(), spec.action_space.action_dim()));
        Self { lanes, observations, actions }
    }

    /// One step of every lane by `policy`. `then` is told what came of it, lane after lane; those for which it says `false` are left out from then on.
    ///
    /// # Errors
    /// Those of `then`.
    pub(crate) fn step<E>(
        &mut self,
        (policy, mode): (&dyn Policy, Mode),
        rng: &mut Rng,
        mut then: impl FnMut(&mut T, Step<'_>) -> Result<bool, E>,
    ) -> Result<(), E> {
        let n = self.lanes.len();
        let mut observations = self.observations.slice_mut(s![..n, ..]);
        let mut actions = self.actions.slice_mut(s![..n, ..]);
        for (mut row, lane) in observations.rows_mut().into_iter().zip(&self.lanes) {
            row.assign(&ArrayView1::from(lane.system().observation()));
        }
        let mut is_common = false;
        for (i, lane) in self.lanes.iter_mut().enumerate() {
            let (o, mut a) = (observations.row(i), actions.row_mut(i));
            let (o, a) = o.to_slice().zip(a.as_slice_mut()).expect("rows are contiguous");
            match lane.memory() {
                Some(memory) => memory.act(o, mode, rng, a),
                None => is_common = true,
            }
        }
        if is_common {
            policy.act_batch(observations.view(), mode, rng, actions.view_mut());
        }
        let (mut at, mut told) = (0, Ok(()));
        self.lanes.retain_mut(|lane| {
            let (before, action) = (observations.row(at), actions.row(at));
            let (before, action) = before.to_slice().zip(action.to_slice()).expect("rows are contiguous");
            at += 1;
            if told.is_err() {
                return true;
            }
            let (system, rng) = lane.with_rng(rng);
            let outcome = system.step(action, rng);
            match then(lane, Step { before, action, outcome }) {
                Ok(goes_on) => goes_on,
                Err(error) => {
                    told = Err(error);
                    true
                }
            }
        });
        told
    }
}
