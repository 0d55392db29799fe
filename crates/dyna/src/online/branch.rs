//! Rollouts branched off from states the real system was in.

use ndarray::{Array2, ArrayView1};
use sindyna_core::{
    Dynamics, Environment as _, Inverse, Mode, Observe, Policy, Replay, Rng, Seed, Sensors, Simulated, Task, Transition,
};

use super::Branches;
use crate::base::Counts;

/// Branches stepped side by side.
const GROUP: usize = 256;

/// The model, seen and judged as the real system is.
pub(super) struct Stage<'a, M> {
    pub(super) model: &'a M,
    pub(super) task: &'a dyn Task,
    pub(super) sensors: &'a Sensors,
    pub(super) inverse: &'a Inverse,
}

impl<M: Dynamics> Stage<'_, M> {
    /// Branches rollouts off from states in the memory `real`, acts by `policy`, and remembers every step in the one `imagined`.
    pub(super) fn branch(
        &self,
        branches: &Branches,
        policy: &dyn Policy,
        (real, imagined): (&Replay, &mut Replay),
        counts: &mut Counts,
        (seed, round): (Seed, u64),
    ) {
        let count = branches.every * branches.per_step;
        let mut rng = seed.stream("branches", round);
        for first in (0..count).step_by(GROUP) {
            let lanes = (first..count.min(first + GROUP)).filter_map(|_| self.begin(real, &mut rng));
            let mut lanes: Vec<_> = lanes.collect();
            for _ in 0..branches.length {
                lanes = self.step(lanes, policy, imagined, &mut rng, counts);
            }
        }
    }

    /// A rollout that begins in a state of `real`; `None` where that ends the task.
    fn begin(&self, real: &Replay, rng: &mut Rng) -> Option<Lane<'_, M>> {
        let mut x = vec![0.0; self.task.spec().state_dim()];
        // Tasks and models look at whole turns of an angle alike: any will do.
        let turns = vec![0.0; x.len()];
        self.inverse.state(real.sample_observation(rng)?, &turns, &mut x);
        if self.task.terminated(&x) {
            return None;
        }
        let mut env = Simulated::new(self.model, self.task, self.sensors as &dyn Observe);
        env.reset_to(&x, rng);
        Some(env)
    }

    /// One step of every rollout; those that go on.
    fn step<'b>(
        &self,
        mut lanes: Vec<Lane<'b, M>>,
        policy: &dyn Policy,
        imagined: &mut Replay,
        rng: &mut Rng,
        counts: &mut Counts,
    ) -> Vec<Lane<'b, M>> {
        let spec = self.task.spec();
        let mut observations = Array2::zeros((lanes.len(), spec.observation_dim()));
        let mut actions = Array2::zeros((lanes.len(), spec.action_space.action_dim()));
        for (mut row, lane) in observations.rows_mut().into_iter().zip(&lanes) {
            row.assign(&ArrayView1::from(lane.observation()));
        }
        policy.act_batch(observations.view(), Mode::Explore, rng, actions.view_mut());
        let mut at = 0;
        lanes.retain_mut(|lane| {
            let (before, action) = (observations.row(at), actions.row(at));
            let (before, action) = (before.as_slice().unwrap_or(&[]), action.as_slice().unwrap_or(&[]));
            at += 1;
            counts.steps += 1;
            match lane.step(action, rng) {
                Ok(outcome) => {
                    imagined.push(Transition {
                        observation: before,
                        action,
                        reward: outcome.reward,
                        next_observation: lane.observation(),
                        terminated: outcome.terminated,
                    });
                    !(outcome.terminated || outcome.truncated)
                }
                Err(_) => {
                    counts.diverged += 1;
                    false
                }
            }
        });
        lanes
    }
}

type Lane<'a, M> = Simulated<&'a M, &'a dyn Task, &'a dyn Observe>;
