//! What can be set about SAC, and what cannot.

use serde::{Deserialize, Serialize};

/// Settings of [`Sac`](crate::Sac) and [`SacDiscrete`](crate::SacDiscrete). The defaults are Stable-Baselines3's, but for
/// smaller networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SacConfig {
    /// Widths of the hidden layers of actor and critics.
    pub hidden: Vec<usize>,
    /// Adam's step size for actor, critics and temperature.
    pub learning_rate: f64,
    /// Discount γ of the reward one step later.
    pub discount: f64,
    /// Share of the critics that enters their targets in every update (τ).
    pub polyak: f64,
    /// Transitions per update, for those who draw the batches.
    pub batch_size: usize,
    /// Entropy weight before the first update (α). For numbered actions it never rises above ten times this.
    pub initial_temperature: f64,
    /// Entropy the temperature steers to \[nat\]. `None` is minus the number of action values for real actions (the
    /// density is that of the action in -1..1), and 0.7 log n for n numbered actions.
    pub target_entropy: Option<f64>,
    /// Factor on every reward before it is learned from.
    pub reward_scale: f64,
    /// Share of the actor's weights that enters their average in every update. The policy that is handed over has averaged weights, which change less from
    /// update to update; with 1 it is the actor itself.
    ///
    /// # References
    /// Polyak, Juditsky (1992), SIAM J. Control Optim. 30, "Acceleration of stochastic approximation by averaging".
    pub averaging: f64,
}

impl Default for SacConfig {
    fn default() -> Self {
        Self {
            hidden: vec![64, 64],
            learning_rate: 3e-4,
            discount: 0.99,
            polyak: 0.005,
            batch_size: 256,
            initial_temperature: 1.0,
            target_entropy: None,
            reward_scale: 1.0,
            averaging: 1.0,
        }
    }
}

impl SacConfig {
    /// Settings for learning inside a model: samples are as many and as clean as one likes, so that critics may follow their targets
    /// fast, and the policy's weights are averaged.
    #[must_use]
    pub fn in_model() -> Self {
        Self {
            learning_rate: 2e-3,
            polyak: 0.04,
            batch_size: 128,
            initial_temperature: 0.1,
            reward_scale: 0.1,
            averaging: 0.01,
            ..Self::default()
        }
    }

    pub(crate) fn check(&self) -> Result<(), SacError> {
        let setting = |name, value: f64, wanted, holds: bool| {
            if holds && value.is_finite() { Ok(()) } else { Err(SacError::Setting { name, value, wanted }) }
        };
        if let Some(width) = self.hidden.iter().find(|w| **w == 0) {
            return Err(SacError::Setting { name: "hidden", value: *width as f64, wanted: "widths of at least 1" });
        }
        setting("learning_rate", self.learning_rate, "above 0", self.learning_rate > 0.0)?;
        setting("discount", self.discount, "in 0..=1", (0.0..=1.0).contains(&self.discount))?;
        setting("polyak", self.polyak, "above 0 and at most 1", self.polyak > 0.0 && self.polyak <= 1.0)?;
        setting("batch_size", self.batch_size as f64, "at least 1", self.batch_size > 0)?;
        setting("initial_temperature", self.initial_temperature, "above 0", self.initial_temperature > 0.0)?;
        setting("target_entropy", self.target_entropy.unwrap_or(0.0), "finite", true)?;
        setting("reward_scale", self.reward_scale, "above 0", self.reward_scale > 0.0)?;
        setting("averaging", self.averaging, "above 0 and at most 1", self.averaging > 0.0 && self.averaging <= 1.0)
    }
}

/// Why no agent can be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SacError {
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
    /// The ends of the action range are of different numbers, or none.
    #[error("the action range has {low} lower and {high} upper ends; both must be the same number, at least 1")]
    ActionEnds {
        /// Number of lower ends.
        low: usize,
        /// Number of upper ends.
        high: usize,
    },
    /// An action value has no finite range.
    #[error("action value {index} ranges from {low} to {high}; both ends must be finite, the lower one smaller")]
    ActionRange {
        /// Which action value.
        index: usize,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// Centres and scales are of different numbers, or none.
    #[error("the scaling has {center} centres and {scale} scales; both must be the same number, at least 1")]
    ScalingWidth {
        /// Number of centres.
        center: usize,
        /// Number of scales.
        scale: usize,
    },
    /// An observed value cannot be scaled.
    #[error("observed value {index} has centre {center} and scale {scale}; both must be finite, the scale above 0")]
    Scaling {
        /// Which observed value.
        index: usize,
        /// Its centre.
        center: f64,
        /// Its scale.
        scale: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_has_its_range_and_is_named_when_outside() {
        type Break = fn(&mut SacConfig);
        let breaks: [(&str, Break); 12] = [
            ("hidden", |c| c.hidden = vec![64, 0]),
            ("learning_rate", |c| c.learning_rate = 0.0),
            ("learning_rate", |c| c.learning_rate = f64::INFINITY),
            ("discount", |c| c.discount = 1.01),
            ("discount", |c| c.discount = f64::NAN),
            ("polyak", |c| c.polyak = 0.0),
            ("polyak", |c| c.polyak = f64::NAN),
            ("batch_size", |c| c.batch_size = 0),
            ("initial_temperature", |c| c.initial_temperature = -1.0),
            ("target_entropy", |c| c.target_entropy = Some(f64::NAN)),
            ("reward_scale", |c| c.reward_scale = 0.0),
            ("reward_scale", |c| c.reward_scale = f64::INFINITY),
        ];
        assert_eq!(SacConfig::default().check(), Ok(()));
        for (setting, apply) in breaks {
            let mut config = SacConfig::default();
            apply(&mut config);
            assert!(matches!(config.check(), Err(SacError::Setting { name, .. }) if name == setting), "{setting}");
        }
    }

    #[test]
    fn settings_survive_a_file_and_unknown_ones_are_refused() {
        let config = SacConfig { target_entropy: Some(-0.5), ..SacConfig::default() };
        let text = serde_json::to_string(&config).expect("settings are plain numbers");
        assert_eq!(serde_json::from_str::<SacConfig>(&text).ok(), Some(config));
        assert_eq!(serde_json::from_str::<SacConfig>("{}").ok(), Some(SacConfig::default()));
        assert!(serde_json::from_str::<SacConfig>(r#"{"learning_rat": 1}"#).is_err());
    }
}
