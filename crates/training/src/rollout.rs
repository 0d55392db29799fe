//! An episode of a policy in a model.

use sindyna_core::{Acting, Bounded, Dynamics, Environment as _, Memory as _, Mode, Policy, Seed, Simulated};

use crate::problem::Problem;

/// What a policy did in a model, seen without noise.
pub(crate) struct Rollout {
    /// States (n each), the first one included.
    pub(crate) states: Vec<Vec<f64>>,
    /// Controls (k each).
    pub(crate) controls: Vec<Vec<f64>>,
    /// Sum of the rewards.
    pub(crate) earned: f64,
    /// Whether the episode came to its end; it did not where a step failed.
    pub(crate) ended: bool,
    /// Whether a condition of the task ended it.
    pub(crate) terminated: bool,
}

/// Episode number `episode` of the random `stream`: `policy` (its best actions) in `model`.
pub(crate) fn rollout(
    problem: &dyn Problem,
    model: &dyn Dynamics,
    policy: &dyn Policy,
    (stream, episode): (&str, u64),
) -> Rollout {
    let (spec, task) = (problem.spec(), problem.task());
    let mut rng = Seed::new(0).stream(stream, episode);
    let mut system = Simulated::new(Bounded::new(model, &spec.state), &*task, problem.sensors().without_noise());
    let mut rollout =
        Rollout { states: Vec::new(), controls: Vec::new(), earned: 0.0, ended: false, terminated: false };
    if system.reset(&mut rng).is_err() {
        return rollout;
    }
    rollout.states.push(system.state().to_vec());
    let (mut action, mut policy) = (vec![0.0; spec.action_space.action_dim()], Acting::begin(policy));
    while !rollout.ended {
        policy.act(system.observation(), Mode::Exploit, &mut rng, &mut action);
        let Ok(outcome) = system.step(&action, &mut rng) else { break };
        rollout.states.push(system.state().to_vec());
        rollout.controls.push(system.control().to_vec());
        rollout.earned += outcome.reward;
        rollout.terminated = outcome.terminated;
        rollout.ended = outcome.terminated || outcome.truncated;
    }
    rollout
}
