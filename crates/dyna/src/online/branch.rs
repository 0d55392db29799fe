//! Rollouts branched off from states the system was in.

use std::convert::Infallible;

use sindyna_core::{Dynamics, Inverse, Mode, Observe, Policy, Replay, Rng, Seed, Sensors, Simulated, Task};

use super::schedule::Branches;
use crate::base::Progress;
use crate::lockstep::{Lane, Lockstep};

/// Branches stepped side by side.
const GROUP: usize = 256;

/// The model, seen and judged as the system is.
pub(super) struct Stage<'a, M> {
    pub(super) model: &'a M,
    pub(super) task: &'a dyn Task,
    pub(super) sensors: &'a Sensors,
    pub(super) inverse: &'a Inverse,
}

impl<M: Dynamics> Stage<'_, M> {
    /// Branches rollouts off from real states, acts by `policy`, and remembers every step in `imagined`.
    pub(super) fn branch(
        &self,
        branches: &Branches,
        policy: &dyn Policy,
        Progress { replay, counts, model, .. }: &mut Progress,
        imagined: &mut Replay,
        (seed, round): (Seed, u64),
    ) {
        let count = branches.every * branches.per_step;
        let mut rng = seed.stream("branches", round);
        for first in (0..count).step_by(GROUP) {
            let lanes = (first..count.min(first + GROUP)).filter_map(|_| self.begin(replay, &mut rng));
            let mut lockstep = Lockstep::new(self.task.spec(), lanes.collect());
            for _ in 0..branches.length {
                let Ok::<_, Infallible>(()) = lockstep.step((policy, Mode::Explore), &mut rng, |branch, step| {
                    counts.steps += 1;
                    let Some((transition, ended)) = step.transition(branch) else {
                        counts.diverged += 1;
                        return Ok(false);
                    };
                    imagined.push_imagined(*model, transition);
                    Ok(!ended)
                });
            }
        }
    }

    /// A rollout that begins in a state of `real`; `None` where that ends the task.
    fn begin(&self, real: &Replay, rng: &mut Rng) -> Option<Branch<'_, M>> {
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
}

type Branch<'a, M> = Simulated<&'a M, &'a dyn Task, &'a dyn Observe>;

impl<M: Dynamics> Lane for Branch<'_, M> {
    type System = Self;

    fn system(&self) -> &Self {
        self
    }

    fn with_rng<'a>(&'a mut self, common: &'a mut Rng) -> (&'a mut Self, &'a mut Rng) {
        (self, common)
    }
}
