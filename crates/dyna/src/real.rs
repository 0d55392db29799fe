//! Real episodes between imagined ones: what they teach, and whether they keep what the model promised.

use sindyna_core::{Agent, Dataset, End, EnvError, Environment, Inverse, Mode, Policy, Replay, Rng, Transition};

use crate::belief::Belief;
use crate::collect::{Actor, Amount, CollectError, collect};
use crate::imagine::Trial;

/// One real episode of a policy beside what the models promised for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Confirmation {
    /// Return of the real episode.
    pub real: f64,
    /// Return of the same policy from the same start in each of the models drawn.
    pub promised: Vec<f64>,
    /// Magnitude of the returns of the task, against which differences are measured.
    pub scale: f64,
}

/// Share of the returns' magnitude by which reality may differ from what was promised.
const TOLERANCE: f64 = 0.03;

/// The same for what the models drawn promise, as a standard deviation.
const DISAGREEMENT: f64 = 0.1;

/// Standard deviations of these by which reality may differ from their mean.
const LIKELY: f64 = 2.0;

impl Confirmation {
    /// Mean return promised.
    #[must_use]
    pub fn expected(&self) -> f64 {
        self.promised.iter().sum::<f64>() / self.promised.len().max(1) as f64
    }

    /// What the real return lacks of the one expected.
    #[must_use]
    pub fn shortfall(&self) -> f64 {
        self.expected() - self.real
    }

    /// Standard deviation of what the models promise.
    #[must_use]
    pub fn disagreement(&self) -> f64 {
        let mean = self.expected();
        let squares: f64 = self.promised.iter().map(|p| (p - mean).powi(2)).sum();
        (squares / self.promised.len().max(1) as f64).sqrt()
    }

    /// What real and promised returns differ by beyond what the models and the noise tell, as a standard deviation.
    pub(crate) fn misfit(&self) -> f64 {
        (self.shortfall().powi(2) - self.disagreement().powi(2)).max(0.0).sqrt()
    }

    /// Whether the models agreed on a promise, and reality kept it. More than was promised is no better: the models are wrong then, too.
    #[must_use]
    pub fn is_kept(&self) -> bool {
        let disagreement = self.disagreement();
        let likely = (LIKELY * disagreement).max(TOLERANCE * self.scale);
        disagreement <= DISAGREEMENT * self.scale && self.shortfall().abs() <= likely
    }
}

/// One real episode of the policy being trained, added to the data.
pub(crate) fn explore<A: Agent>(
    env: &mut dyn Environment,
    agent: &A,
    data: &mut Dataset,
    rng: &mut Rng,
    interrupted: &dyn Fn() -> bool,
) -> Result<(), CollectError> {
    collect(env, Actor::Policy(agent, Mode::Explore), Amount::Episode, data, rng, interrupted)
}

/// One real episode of `policy` at its best, added to the data, beside the same in each of the models believed in. `inverse` tells in which state it
/// began; returns of the task are of the magnitude `scale`.
pub(crate) fn confirm(
    env: &mut dyn Environment,
    policy: &dyn Policy,
    (belief, inverse, scale): (&Belief<'_>, &Inverse, f64),
    data: &mut Dataset,
    rng: &mut Rng,
    interrupted: &dyn Fn() -> bool,
) -> Result<Confirmation, CollectError> {
    collect(env, Actor::Policy(policy, Mode::Exploit), Amount::Episode, data, rng, interrupted)?;
    let Some(rollout) = data.rollouts().last() else {
        return Ok(Confirmation { real: 0.0, promised: Vec::new(), scale });
    };
    let first = rollout.observations.row(0).to_vec();
    let mut start = vec![0.0; env.spec().state_dim()];
    inverse.state(&first, &vec![0.0; start.len()], &mut start);
    let promised = (0..belief.models.len()).map(|i| promise(belief, i, policy, &start, rng));
    let promised = promised.collect::<Result<_, _>>()?;
    Ok(Confirmation { real: rollout.rewards.sum(), promised, scale })
}

/// Return of `policy` in model `i`, from the state `start` (n).
fn promise(belief: &Belief<'_>, i: usize, policy: &dyn Policy, start: &[f64], rng: &mut Rng) -> Result<f64, EnvError> {
    let mut world = Trial::new(belief, i);
    let mut action = vec![0.0; world.spec().action_space.action_dim()];
    world.reset_to(start, rng);
    let mut earned = 0.0;
    loop {
        policy.act(world.observation(), Mode::Exploit, rng, &mut action);
        let outcome = world.step(&action, rng)?;
        earned += outcome.reward;
        if outcome.terminated || outcome.truncated {
            return Ok(earned + world.charged());
        }
    }
}

/// Puts the rollouts of `data` from number `first` on into `replay`.
pub(crate) fn remember(replay: &mut Replay, data: &Dataset, first: usize) {
    for rollout in data.rollouts().skip(first) {
        let steps = rollout.rewards.len();
        for i in 0..steps {
            replay.push(Transition {
                observation: &rollout.observations.row(i).to_vec(),
                action: &rollout.actions.row(i).to_vec(),
                reward: rollout.rewards[i],
                next_observation: &rollout.observations.row(i + 1).to_vec(),
                terminated: i + 1 == steps && rollout.end == End::Terminated,
            });
        }
    }
}
