//! How far a policy is from better plans in its model.

use std::sync::Arc;

use rayon::prelude::*;
use sindyna_control::{Rollout, improved};
use sindyna_core::{Acting, Bounded, Dynamics, Environment as _, Memory as _, Mode, Policy, Seed, Simulated};
use sindyna_record::run::Improvable;

use crate::problem::Problem;

/// Episodes in the model.
const EPISODES: u64 = 4;

/// What `policy` earns in `model`, and what it earns once its controls are improved; `None` where an episode fails.
pub(crate) fn improvable(problem: &dyn Problem, model: Arc<dyn Dynamics>, policy: &dyn Policy) -> Option<Improvable> {
    let rollouts: Option<Vec<Rollout>> =
        (0..EPISODES).into_par_iter().map(|episode| rollout(problem, &model, policy, episode)).collect();
    let rollouts = rollouts?;
    let earned = rollouts.iter().map(|rollout| rollout.earned).sum::<f64>() / rollouts.len() as f64;
    let improved = improved(model, problem.task(), &rollouts);
    Some(Improvable { episodes: rollouts.len(), policy: earned, improved })
}

/// One episode of `policy` in `model`.
fn rollout(problem: &dyn Problem, model: &dyn Dynamics, policy: &dyn Policy, episode: u64) -> Option<Rollout> {
    let (spec, task) = (problem.spec(), problem.task());
    let mut rng = Seed::new(0).stream("improvable", episode);
    let mut system = Simulated::new(Bounded::new(model, &spec.state), &*task, problem.sensors().without_noise());
    system.reset(&mut rng).ok()?;
    let mut rollout = Rollout { start: system.state().to_vec(), controls: Vec::new(), earned: 0.0 };
    let (mut action, mut policy) = (vec![0.0; spec.action_space.action_dim()], Acting::begin(policy));
    loop {
        policy.act(system.observation(), Mode::Exploit, &mut rng, &mut action);
        let outcome = system.step(&action, &mut rng).ok()?;
        rollout.controls.push(system.control().to_vec());
        rollout.earned += outcome.reward;
        if outcome.terminated || outcome.truncated {
            return Some(rollout);
        }
    }
}
