//! Confirmation episodes: real episodes of a policy, compared with what the models predict for them.

use serde::{Deserialize, Serialize};
use sindyna_core::{Acting, EnvError, Environment, Inverse, Memory as _, Mode, Policy, Rng};

use crate::belief::Belief;
use crate::collect::{Actor, Amount, CollectError, Collector};
use crate::imagine::Trial;

/// One real episode of a policy, with the returns that the models predict for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    /// Return of the real episode.
    pub real: f64,
    /// Return of the same policy from the same start state in each of the models drawn.
    pub predicted: Vec<f64>,
    /// Standard deviation of the same with the same sensor noise in all models: their disagreement.
    pub disagreement: f64,
    /// Magnitude of the returns of the task, against which differences are measured.
    pub scale: f64,
}

/// Share of the returns' magnitude by which the real return may differ from the predicted one.
const TOLERANCE: f64 = 0.03;

/// The same for the disagreement of the models, as a standard deviation.
const DISAGREEMENT: f64 = 0.1;

/// Predicted episodes where there are fewer models, since noise alone makes returns differ, and of planners, each step of which takes time.
pub(crate) const PREDICTED: usize = 8;

/// Standard deviations of the predicted returns by which the real one may differ from their mean.
const LIKELY: f64 = 2.0;

/// Standard deviation of `values`.
fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

impl Confirmation {
    /// Mean of the predicted returns.
    #[must_use]
    pub fn expected(&self) -> f64 {
        self.predicted.iter().sum::<f64>() / self.predicted.len().max(1) as f64
    }

    /// Expected minus real return.
    #[must_use]
    pub fn shortfall(&self) -> f64 {
        self.expected() - self.real
    }

    /// Standard deviation of the predicted returns, each with noise of its own.
    #[must_use]
    pub fn spread(&self) -> f64 {
        deviation(&self.predicted)
    }

    /// Difference of real and predicted return beyond that which models and noise explain, as a standard deviation.
    pub(crate) fn misfit(&self) -> f64 {
        (self.shortfall().powi(2) - self.spread().powi(2)).max(0.0).sqrt()
    }

    /// Whether the models agree on a return, and the real one agrees with it. A higher return is no better: the models are wrong then, too.
    #[must_use]
    pub fn agrees(&self) -> bool {
        let likely = (LIKELY * self.spread()).max(TOLERANCE * self.scale);
        self.disagreement <= DISAGREEMENT * self.scale && self.shortfall().abs() <= likely
    }

    /// Whether a mean return that is lower by `loss` in the next model still agrees with the prediction.
    pub(crate) fn allows(&self, loss: f64) -> bool {
        loss <= TOLERANCE * self.scale
    }
}

/// One real episode of `policy` at its best, added to the data, beside the same in `models` of the models believed in. `inverse` tells in which state it
/// began; returns of the task are of the magnitude `scale`.
pub(crate) fn confirm(
    env: &mut dyn Environment,
    policy: &dyn Policy,
    (belief, models, inverse, scale): (&Belief<'_>, usize, &Inverse, f64),
    system: &mut Collector,
    interrupted: &dyn Fn() -> bool,
) -> Result<Confirmation, CollectError> {
    system.collect(env, Actor::policy(policy, Mode::Exploit), Amount::Episode(belief.task.max_steps()), interrupted)?;
    let Collector { data, rng, .. } = system;
    let Some(rollout) = data.rollouts().last() else {
        return Ok(Confirmation { real: 0.0, predicted: Vec::new(), disagreement: 0.0, scale });
    };
    let first = rollout.observations.row(0).to_vec();
    let mut start = vec![0.0; env.spec().state_dim()];
    inverse.state(&first, &vec![0.0; start.len()], &mut start);
    let common = rng.clone();
    let alike = (0..models).map(|i| predict(belief, i, policy, &start, &mut common.clone()));
    let disagreement = deviation(&alike.collect::<Result<Vec<f64>, _>>()?);
    let predicted = (0..models.max(PREDICTED)).map(|i| predict(belief, i, policy, &start, rng));
    let predicted = predicted.collect::<Result<_, _>>()?;
    Ok(Confirmation { real: rollout.rewards.sum(), predicted, disagreement, scale })
}

/// Return of `policy` in model `i`, from the state `start` (n).
fn predict(belief: &Belief<'_>, i: usize, policy: &dyn Policy, start: &[f64], rng: &mut Rng) -> Result<f64, EnvError> {
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
