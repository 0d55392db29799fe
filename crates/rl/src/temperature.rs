//! The entropy weight, and how it is steered.

use crate::adam::ScalarAdam;

/// α, adjusted so that the policy's entropy follows its target.
///
/// Descends -log α · mean(log π + H̄) in log α. That is the published objective with log α for α, as the reference
/// implementations have it: same sign, same fixed point, a step that does not shrink with α.
///
/// # References
/// Haarnoja et al. (2018), arXiv:1812.05905, equation 18.
#[derive(Debug, Clone)]
pub(crate) struct Temperature {
    pub(crate) log_value: f64,
    pub(crate) target_entropy: f64,
    pub(crate) adam: ScalarAdam,
}

impl Temperature {
    pub(crate) fn new(initial: f64, target_entropy: f64, learning_rate: f64) -> Self {
        Self { log_value: initial.ln(), target_entropy, adam: ScalarAdam::new(learning_rate) }
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
        loss
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_much_certainty_raises_the_temperature_and_the_target_holds_it() {
        let mut t = Temperature::new(0.5, -1.0, 1e-2);
        t.step(1.0);
        assert_eq!(t.value(), 0.5_f64.ln().exp(), "entropy -1 is the target");
        t.step(2.0);
        assert!(t.value() > 0.5, "entropy -2 is below the target");
        let mut t = Temperature::new(0.5, -1.0, 1e-2);
        t.step(0.0);
        assert!(t.value() < 0.5);
    }

    #[test]
    fn its_gradient_is_that_of_the_loss() {
        let (h, mean_log_prob) = (1e-6, 0.7);
        let loss = |log_value: f64| -log_value * (mean_log_prob - 2.0);
        let mut t = Temperature::new(1.3, -2.0, 1e-3);
        let log_value = t.log_value;
        assert!((t.step(mean_log_prob) - loss(log_value)).abs() < 1e-15);
        // After the first step Adam's mean is a tenth of the gradient.
        let slope = (loss(log_value + h) - loss(log_value - h)) / (2.0 * h);
        assert!((t.adam.mean / 0.1 - slope).abs() < 1e-8);
    }
}
