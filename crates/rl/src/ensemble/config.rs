//! What can be set about an ensemble, and the two settings of the literature.

use serde::{Deserialize, Serialize};
use sindyna_core::Unseen;

use super::Activation;

/// Whether the networks predict the reward beside the observation's increment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RewardHead {
    /// They do, as in the papers. Imagined rewards are the task's all the same: the head costs parameters and shapes
    /// the hidden layers, nothing else.
    Trained,
    /// They predict the observation's increment alone.
    Absent,
}

/// In which unit the networks see what they are to predict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetScale {
    /// Less the mean and divided by the standard deviation over the training rows, each.
    Standardised,
    /// As they are, as in Janner's and the paper's programs: a reward of -16 then outweighs an increment of 0.01.
    Raw,
}

/// Settings of an ensemble. The fields are plain; [`EnsembleTrainer::new`](super::EnsembleTrainer::new) checks them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnsembleConfig {
    /// Networks.
    pub members: usize,
    /// How many of them, the best on the holdout rows, are used for prediction.
    pub elites: usize,
    /// Widths of the hidden layers of each.
    pub hidden: Vec<usize>,
    /// What follows every hidden layer.
    pub activation: Activation,
    /// Whether the reward is predicted too.
    pub reward_head: RewardHead,
    /// Unit of the predicted numbers inside the networks.
    pub targets: TargetScale,
    /// Adam's step size.
    pub learning_rate: f64,
    /// Factor c of c/2 ‖W‖² in the loss, one for the weights W of each layer.
    pub weight_decay: Vec<f64>,
    /// Factor of Σ max - Σ min of the bounds of log σ² in the loss.
    pub bound_weight: f64,
    /// Rows in a step.
    pub batch_size: usize,
    /// Share of the rows that is held out of training, to stop and to choose elites by.
    pub holdout: f64,
    /// The most rows held out.
    pub max_holdout: usize,
    /// Training stops after more than so many epochs in which no member improved.
    pub patience: usize,
    /// The fraction by which a member's holdout error must fall below its best to count as improved.
    pub min_improvement: f64,
    /// The most epochs of one fit, if there is a limit.
    pub max_epochs: Option<usize>,
    /// No further epoch of a fit begins after so many steps, if there is a limit.
    pub max_steps: Option<usize>,
}

impl EnsembleConfig {
    /// Those of Janner's program for MBPO: seven networks of four hidden layers of 200 with swish, five elites.
    ///
    /// # Deviations
    /// 1. Targets are standardised. Theirs are not; unequal scales of rewards and increments are known to spoil the
    ///    fit (arXiv:2412.14312).
    ///
    /// # References
    /// Janner et al. (2019), arXiv:1906.08253, appendix C, and their program `jannerm/mbpo`.
    #[must_use]
    pub fn janner() -> Self {
        Self {
            members: 7,
            elites: 5,
            hidden: vec![200; 4],
            activation: Activation::Swish,
            reward_head: RewardHead::Trained,
            targets: TargetScale::Standardised,
            learning_rate: 1e-3,
            weight_decay: vec![2.5e-5, 5e-5, 7.5e-5, 7.5e-5, 1e-4],
            bound_weight: 0.01,
            batch_size: 256,
            holdout: 0.2,
            max_holdout: 5000,
            patience: 5,
            min_improvement: 0.01,
            max_epochs: None,
            max_steps: None,
        }
    }

    /// Those behind the parameter counts of Arora, da Silva and Moss (2022): five networks with ReLU, two elites, a
    /// tenth of the rows held out, at most 200 epochs. The size matches the programs of Alegre (`mbcd`,
    /// `morl-baselines`).
    ///
    /// # Deviations
    /// 1. Targets are standardised, as in [`Self::janner`].
    /// 2. What Alegre's programs leave out is as in [`Self::janner`]: restored weights, initial weights, patience of
    ///    more than five epochs, decay of weights without biases.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            members: 5,
            elites: 2,
            activation: Activation::Relu,
            holdout: 0.1,
            max_epochs: Some(200),
            ..Self::janner()
        }
    }

    /// Numbers that training adjusts, for `observed` values and `controls`: weights and biases of all members, and the
    /// bounds of log σ² they share.
    #[must_use]
    pub fn n_parameters(&self, observed: usize, controls: usize) -> usize {
        let targets = self.n_targets(observed);
        let widths = self.widths(observed + controls, targets);
        self.members * widths.windows(2).map(|w| (w[0] + 1) * w[1]).sum::<usize>() + 2 * targets
    }

    /// Predicted numbers for `observed` values.
    pub(super) fn n_targets(&self, observed: usize) -> usize {
        observed + usize::from(self.reward_head == RewardHead::Trained)
    }

    /// Widths of a network from `inputs` to means and logarithmic variances of `targets`.
    pub(super) fn widths(&self, inputs: usize, targets: usize) -> Vec<usize> {
        [&[inputs], self.hidden.as_slice(), &[2 * targets]].concat()
    }

    pub(super) fn check(&self) -> Result<(), EnsembleError> {
        let setting = |name, value: f64, wanted, holds: bool| {
            if holds && value.is_finite() { Ok(()) } else { Err(EnsembleError::Setting { name, value, wanted }) }
        };
        let count = |name, value: usize| setting(name, value as f64, "at least 1", value > 0);
        count("members", self.members)?;
        let elites = (1..=self.members).contains(&self.elites);
        setting("elites", self.elites as f64, "at least 1 and at most the members", elites)?;
        for width in &self.hidden {
            setting("hidden", *width as f64, "widths of at least 1", *width > 0)?;
        }
        setting("learning_rate", self.learning_rate, "above 0", self.learning_rate > 0.0)?;
        let layers = self.hidden.len() + 1;
        setting("weight_decay", self.weight_decay.len() as f64, "one per layer", self.weight_decay.len() == layers)?;
        for decay in &self.weight_decay {
            setting("weight_decay", *decay, "at least 0", *decay >= 0.0)?;
        }
        setting("bound_weight", self.bound_weight, "at least 0", self.bound_weight >= 0.0)?;
        count("batch_size", self.batch_size)?;
        setting("holdout", self.holdout, "above 0 and at most 0.5", self.holdout > 0.0 && self.holdout <= 0.5)?;
        count("max_holdout", self.max_holdout)?;
        setting("min_improvement", self.min_improvement, "in 0..1", (0.0..1.0).contains(&self.min_improvement))?;
        count("max_epochs", self.max_epochs.unwrap_or(1))?;
        count("max_steps", self.max_steps.unwrap_or(1))
    }
}

/// Why there can be no ensemble.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnsembleError {
    /// A setting is outside its range.
    #[error("{name} must be {wanted}, got {value}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
    /// The networks predict observations, from which a state does not follow.
    #[error(transparent)]
    Unseen(#[from] Unseen),
    /// An observation shows no state.
    #[error("an observation of `{task}` shows no state of it")]
    Unknown {
        /// Name of the task.
        task: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_as_many_as_the_papers_count() {
        let paper = EnsembleConfig::paper();
        assert_eq!(paper.n_parameters(2, 1), 613_036, "Mountain Car, Arora et al.");
        assert_eq!(paper.n_parameters(3, 1), 616_048, "Pendulum");
        assert_eq!(paper.n_parameters(4, 1), 619_060, "Inverted Pendulum");
        assert_eq!(EnsembleConfig::janner().n_parameters(4, 1), 866_680, "Inverted Pendulum, Janner et al.");
        let without = EnsembleConfig { reward_head: RewardHead::Absent, ..paper };
        assert_eq!(without.n_parameters(2, 1), 613_036 - 5 * 2 * 201 - 2);
    }

    #[test]
    fn every_setting_has_its_range_and_is_named_when_outside() {
        type Break = fn(&mut EnsembleConfig);
        let breaks: [(&str, Break); 16] = [
            ("members", |c| c.members = 0),
            ("elites", |c| c.elites = 0),
            ("elites", |c| c.elites = 8),
            ("hidden", |c| c.hidden[1] = 0),
            ("learning_rate", |c| c.learning_rate = f64::NAN),
            ("weight_decay", |c| c.weight_decay.truncate(4)),
            ("weight_decay", |c| c.weight_decay[2] = -1.0),
            ("bound_weight", |c| c.bound_weight = f64::INFINITY),
            ("batch_size", |c| c.batch_size = 0),
            ("holdout", |c| c.holdout = 0.0),
            ("holdout", |c| c.holdout = 0.51),
            ("max_holdout", |c| c.max_holdout = 0),
            ("min_improvement", |c| c.min_improvement = 1.0),
            ("min_improvement", |c| c.min_improvement = f64::NAN),
            ("max_epochs", |c| c.max_epochs = Some(0)),
            ("max_steps", |c| c.max_steps = Some(0)),
        ];
        assert_eq!(EnsembleConfig::paper().check(), Ok(()));
        for (setting, apply) in breaks {
            let mut config = EnsembleConfig::janner();
            apply(&mut config);
            assert!(matches!(config.check(), Err(EnsembleError::Setting { name, .. }) if name == setting), "{setting}");
        }
    }

    #[test]
    fn settings_survive_a_file() {
        let config = EnsembleConfig::janner();
        let text = serde_json::to_string(&config).expect("settings are plain numbers");
        assert_eq!(serde_json::from_str::<EnsembleConfig>(&text).ok(), Some(config));
    }
}
