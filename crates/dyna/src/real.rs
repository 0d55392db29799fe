//! Real episodes between imagined ones: what they teach, and whether they keep what the model promised.

use serde::{Deserialize, Serialize};
use sindyna_core::{Acting, EnvError, Environment, Inverse, Memory as _, Mode, Policy, Rng};

use crate::belief::Belief;
use crate::collect::{Actor, Amount, CollectError, Collector};
use crate::imagine::Trial;

/// One real episode of a policy beside what the models promised for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    /// Return of the real episode.
    pub real: f64,
    /// Return of the same policy from the same start in each of the models drawn.
    pub promised: Vec<f64>,
    /// Standard deviation of the same with the same noise of the sensors in all models: what they disagree by.
    pub disagreement: f64,
    /// Magnitude of the returns of the task, against which differences are measured.
    pub scale: f64,
}

/// Share of the returns' magnitude by which reality may differ from what was promised.
const TOLERANCE: f64 = 0.03;

/// The same for what the models drawn promise, as a standard deviation.
const DISAGREEMENT: f64 = 0.1;

/// Episodes promised where there are fewer models: noise alone makes returns differ.
const PROMISES: usize = 8;

/// Standard deviations of what is promised by which reality may differ from their mean.
const LIKELY: f64 = 2.0;

/// Standard deviation of `values`.
fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

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

    /// Standard deviation of what the models promise, each with noise of its own.
    #[must_use]
    pub fn spread(&self) -> f64 {
        deviation(&self.promised)
    }

    /// What real and promised returns differ by beyond what the models and the noise tell, as a standard deviation.
    pub(crate) fn misfit(&self) -> f64 {
        (self.shortfall().powi(2) - self.spread().powi(2)).max(0.0).sqrt()
    }

    /// Whether the models agreed on a promise, and reality kept it. More than was promised is no better: the models are wrong then, too.
    #[must_use]
    pub fn is_kept(&self) -> bool {
        let likely = (LIKELY * self.spread()).max(TOLERANCE * self.scale);
        self.disagreement <= DISAGREEMENT * self.scale && self.shortfall().abs() <= likely
    }

    /// Whether a mean return that is lower by `loss` in the next model is as it was promised.
    pub(crate) fn allows(&self, loss: f64) -> bool {
        loss <= TOLERANCE * self.scale
    }
}

/// One real episode of `policy` at its best, added to the data, beside the same in each of the models believed in. `inverse` tells in which state it
/// began; returns of the task are of the magnitude `scale`.
pub(crate) fn confirm(
    env: &mut dyn Environment,
    policy: &dyn Policy,
    (belief, inverse, scale): (&Belief<'_>, &Inverse, f64),
    system: &mut Collector,
    interrupted: &dyn Fn() -> bool,
) -> Result<Confirmation, CollectError> {
    system.collect(env, Actor::policy(policy, Mode::Exploit), Amount::Episode(belief.task.max_steps()), interrupted)?;
    let Collector { data, rng, .. } = system;
    let Some(rollout) = data.rollouts().last() else {
        return Ok(Confirmation { real: 0.0, promised: Vec::new(), disagreement: 0.0, scale });
    };
    let first = rollout.observations.row(0).to_vec();
    let mut start = vec![0.0; env.spec().state_dim()];
    inverse.state(&first, &vec![0.0; start.len()], &mut start);
    let common = rng.clone();
    let alike = (0..belief.n_systems()).map(|i| promise(belief, i, policy, &start, &mut common.clone()));
    let disagreement = deviation(&alike.collect::<Result<Vec<f64>, _>>()?);
    let promised = (0..belief.n_systems().max(PROMISES)).map(|i| promise(belief, i, policy, &start, rng));
    let promised = promised.collect::<Result<_, _>>()?;
    Ok(Confirmation { real: rollout.rewards.sum(), promised, disagreement, scale })
}

/// Return of `policy` in model `i`, from the state `start` (n).
fn promise(belief: &Belief<'_>, i: usize, policy: &dyn Policy, start: &[f64], rng: &mut Rng) -> Result<f64, EnvError> {
    let mut system = Trial::new(belief, i);
    let mut action = vec![0.0; system.spec().action_space.action_dim()];
    system.reset_to(start, rng);
    let (mut earned, mut policy) = (0.0, Acting::begin(policy));
    loop {
        policy.act(system.observation(), Mode::Exploit, rng, &mut action);
        let outcome = system.step(&action, rng)?;
        earned += outcome.reward;
        if outcome.terminated || outcome.truncated {
            return Ok(earned + system.charged());
        }
    }
}
