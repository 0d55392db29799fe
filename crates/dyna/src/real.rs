//! Real rollouts between imagined ones: what they teach, and whether they keep what the model promised.

use sindyna_core::{Agent, Dataset, Dynamics, End, EnvError, Environment, Mode, Policy, Rng, Transition};

use crate::collect::{Actor, Amount, CollectError, collect};
use crate::imagine::{Imagined, Trial};
use crate::improve::Improvement;

/// A policy tried on the real system, beside what the model promised.
#[derive(Debug, Clone)]
pub(crate) struct Tried<P> {
    pub(crate) policy: P,
    /// Return of the real episode.
    pub(crate) real: f64,
    /// Return of the same policy in the model, from the same start where the real system is a simulation.
    pub(crate) promised: f64,
}

/// Share of the promised return's magnitude by which reality may fall short of it.
const SHORTFALL: f64 = 0.1;

impl<P> Tried<P> {
    /// Whether reality kept the promise.
    pub(crate) fn kept(&self) -> bool {
        self.shortfall() <= SHORTFALL * self.promised.abs()
    }

    pub(crate) fn shortfall(&self) -> f64 {
        self.promised - self.real
    }
}

/// One real episode of the policy being trained; it is learned from, and added to the real data.
pub(crate) fn explore<A: Agent>(
    env: &mut dyn Environment,
    improvement: &mut Improvement<'_, A>,
    data: &mut Dataset,
    rng: &mut Rng,
    interrupted: &dyn Fn() -> bool,
) -> Result<(), CollectError> {
    collect(env, Actor::Policy(&improvement.agent, Mode::Explore), Amount::Episode, data, rng, interrupted)?;
    learn_from_last(improvement, data);
    Ok(())
}

/// One real episode of `policy` at its best, beside one in the model.
pub(crate) fn confirm<A: Agent, M: Dynamics>(
    env: &mut dyn Environment,
    improvement: &mut Improvement<'_, A>,
    model: &Imagined<'_, M>,
    policy: A::Frozen,
    data: &mut Dataset,
    rng: &mut Rng,
    interrupted: &dyn Fn() -> bool,
) -> Result<Tried<A::Frozen>, CollectError> {
    let promised = promise(model, &policy, &mut rng.clone())?;
    collect(env, Actor::Policy(&policy, Mode::Exploit), Amount::Episode, data, rng, interrupted)?;
    learn_from_last(improvement, data);
    let real = data.rollouts().last().map_or(0.0, |rollout| rollout.rewards.sum());
    Ok(Tried { policy, real, promised })
}

/// Return of `policy` in the model, from the start a simulation would draw from `rng`.
fn promise<M: Dynamics>(model: &Imagined<'_, M>, policy: &dyn Policy, rng: &mut Rng) -> Result<f64, EnvError> {
    let mut world = Trial::like(model);
    let mut action = vec![0.0; world.spec().action_space.action_dim()];
    world.reset(rng)?;
    let mut earned = 0.0;
    loop {
        policy.act(world.observation(), Mode::Exploit, rng, &mut action);
        let outcome = world.step(&action, rng)?;
        earned += outcome.reward;
        if outcome.terminated || outcome.truncated {
            return Ok(earned);
        }
    }
}

/// Puts the last real rollout into replay.
fn learn_from_last<A: Agent>(improvement: &mut Improvement<'_, A>, data: &Dataset) {
    let Some(rollout) = data.rollouts().last() else { return };
    let steps = rollout.rewards.len();
    for i in 0..steps {
        improvement.replay.push(Transition {
            observation: &rollout.observations.row(i).to_vec(),
            action: &rollout.actions.row(i).to_vec(),
            reward: rollout.rewards[i],
            next_observation: &rollout.observations.row(i + 1).to_vec(),
            terminated: i + 1 == steps && rollout.end == End::Terminated,
        });
    }
}
