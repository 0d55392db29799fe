//! The entropy weight, and how it is steered.

use serde::{Deserialize, Serialize};

use crate::{SacConfig, adam::ScalarAdam};

/// α, adjusted so that the policy's entropy follows its target.
///
/// Descends -log α · mean(log π + H̄) in log α. That is the published objective with log α for α, as the reference
/// implementations have it: same sign, same fixed point, a step that does not shrink with α.
///
/// # References
/// Haarnoja et al. (2018), arXiv:1812.05905, equation 18.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Temperature {
    pub(crate) log_value: f64,
    pub(crate) target_entropy: f64,
    pub(crate) adam: ScalarAdam,
    log_most: f64,
}

impl Temperature {
    /// The temperature `config` describes; an entropy it does not name is `default_entropy`.
    pub(crate) fn new(config: &SacConfig, default_entropy: f64) -> Self {
        Self {
            log_value: config.initial_temperature.ln(),
            target_entropy: config.target_entropy.unwrap_or(default_entropy),
            adam: ScalarAdam::new(config.learning_rate),
            log_most: f64::INFINITY,
        }
    }

    /// The same, but never above `most`.
    pub(crate) fn at_most(self, most: f64) -> Self {
        Self { log_most: most.ln(), ..self }
    }

    /// The entropy weight α.
    pub(crate) fn value(&self) -> f64 {
        self.log_value.exp()
    }

    /// One step on the batch mean of log π; returns the loss before it.
    pub(crate) fn step(&mut self, mean_log_prob: f64) -> f64 {
        let excess = mean_log_prob + self.target_entropy;
        let loss = -self.log_value * excess;
        self.adam.step(&mut self.log_value, -excess);
        self.log_value = self.log_value.min(self.log_most);
        loss
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn temperature(initial_temperature: f64, target_entropy: f64, learning_rate: f64) -> Temperature {
        Temperature::new(&SacConfig { initial_temperature, learning_rate, ..SacConfig::default() }, target_entropy)
    }

    #[test]
    fn too_much_certainty_raises_the_temperature_and_the_target_holds_it() {
        let mut t = temperature(0.5, -1.0, 1e-2);
        t.step(1.0);
        assert_eq!(t.value(), 0.5_f64.ln().exp(), "entropy -1 is the target");
        t.step(2.0);
        assert!(t.value() > 0.5, "entropy -2 is below the target");
        let mut t = temperature(0.5, -1.0, 1e-2);
        t.step(0.0);
        assert!(t.value() < 0.5);
    }

    #[test]
    fn its_gradient_is_that_of_the_loss() {
        let (h, mean_log_prob) = (1e-6, 0.7);
        let loss = |log_value: f64| -log_value * (mean_log_prob - 2.0);
        let mut t = temperature(1.3, -2.0, 1e-3);
        let log_value = t.log_value;
        assert!((t.step(mean_log_prob) - loss(log_value)).abs() < 1e-15);
        // After the first step Adam's mean is a tenth of the gradient.
        let slope = (loss(log_value + h) - loss(log_value - h)) / (2.0 * h);
        assert!((t.adam.mean / 0.1 - slope).abs() < 1e-8);
    }
}
