//! The Gaussian that a network's outputs stand for, how likely it makes the targets, and the gradients of that.

use crate::{real, simd::vectorized};

/// log σ² before training lies between these, in the networks' units.
const FIRST_BOUNDS: (f32, f32) = (-10.0, 0.5);

/// The learned bounds of log σ² before training: the upper ones of all q targets, then the lower ones.
pub(super) fn first_bounds(targets: usize) -> Vec<f32> {
    let (low, high) = FIRST_BOUNDS;
    (0..2 * targets).map(|i| if i < targets { high } else { low }).collect()
}

/// log σ² between its bounds, and its slopes.
#[derive(Clone, Copy)]
struct Bounded {
    log_var: f64,
    d_raw: f64,
    d_high: f64,
    d_low: f64,
}

/// v = high - softplus(high - raw); log σ² = low + softplus(v - low).
#[inline(always)]
fn bound(raw: f64, low: f64, high: f64) -> Bounded {
    let (above, below_high) = softplus(high - raw);
    let (over_low, above_low) = softplus(high - above - low);
    Bounded {
        log_var: low + over_low,
        d_raw: below_high * above_low,
        d_high: (1.0 - below_high) * above_low,
        d_low: 1.0 - above_low,
    }
}

/// log(1 + eˣ) and its slope 1/(1 + e⁻ˣ).
#[inline(always)]
fn softplus(x: f64) -> (f64, f64) {
    let e = real::exp(-x.abs());
    let inverse = 1.0 / (1.0 + e);
    let positive = if x > 0.0 { x } else { 0.0 };
    (positive + real::ln(1.0 + e), if x > 0.0 { inverse } else { e * inverse })
}

/// σ of one target, in the networks' unit, from a network's output and the bounds.
pub(super) fn deviation(raw: f32, low: f32, high: f32) -> f64 {
    real::exp(0.5 * bound(f64::from(raw), f64::from(low), f64::from(high)).log_var)
}

/// Negative log-likelihood of rows of targets, and its gradients. Memory is kept from call to call.
///
/// A row of outputs is (μ₁…μ_q, raw₁…raw_q). The loss is the mean over rows and targets of (μ - y)²/σ² + log σ², twice
/// the negative log-likelihood but for a constant.
///
/// # References
/// Chua et al. (2018), arXiv:1805.12114, §4 and appendix A.1 (the bounds).
#[derive(Debug, Default)]
pub(super) struct Likelihood {
    /// ∂loss/∂outputs (rows, 2q).
    pub(super) d_outputs: Vec<f32>,
    error: Vec<f64>,
    raw: Vec<f64>,
    loss: Vec<f64>,
    d_mean: Vec<f64>,
    d_raw: Vec<f64>,
    d_high: Vec<f64>,
    d_low: Vec<f64>,
}

impl Likelihood {
    /// The loss of `outputs` (rows, 2q) for `targets` (rows, q) under `bounds` (2q, upper ones first). Adds its gradient
    /// by the bounds to `d_bounds` (2q), and leaves that by the outputs in [`Self::d_outputs`].
    pub(super) fn of(&mut self, outputs: &[f32], targets: &[f32], bounds: &[f32], d_bounds: &mut [f64]) -> f64 {
        let q = bounds.len() / 2;
        let rows = targets.len() / q;
        self.d_outputs.resize(outputs.len(), 0.0);
        let mut sum = 0.0;
        for j in 0..q {
            self.take_column(outputs, targets, q, j);
            self.run(f64::from(bounds[q + j]), f64::from(bounds[j]), 1.0 / (rows * q) as f64);
            sum += self.loss.iter().sum::<f64>();
            d_bounds[j] += self.d_high.iter().sum::<f64>();
            d_bounds[q + j] += self.d_low.iter().sum::<f64>();
            for (d, (mean, raw)) in self.d_outputs.chunks_exact_mut(2 * q).zip(self.d_mean.iter().zip(&self.d_raw)) {
                d[j] = *mean as f32;
                d[q + j] = *raw as f32;
            }
        }
        sum
    }

    /// The errors and unbounded log σ² of target `j`.
    fn take_column(&mut self, outputs: &[f32], targets: &[f32], q: usize, j: usize) {
        self.error.clear();
        self.raw.clear();
        for (outputs, targets) in outputs.chunks_exact(2 * q).zip(targets.chunks_exact(q)) {
            self.error.push(f64::from(outputs[j]) - f64::from(targets[j]));
            self.raw.push(f64::from(outputs[q + j]));
        }
    }

    /// Losses and slopes of a column, each row's counting `share`.
    fn run(&mut self, low: f64, high: f64, share: f64) {
        let n = self.error.len();
        for values in [&mut self.loss, &mut self.d_mean, &mut self.d_raw, &mut self.d_high, &mut self.d_low] {
            values.resize(n, 0.0);
        }
        let (error, raw) = (&self.error[..n], &self.raw[..n]);
        let (loss, d_mean) = (&mut self.loss[..n], &mut self.d_mean[..n]);
        let (d_raw, d_high, d_low) = (&mut self.d_raw[..n], &mut self.d_high[..n], &mut self.d_low[..n]);
        vectorized(
            #[inline(always)]
            || {
                for i in 0..n {
                    let bounded = bound(raw[i], low, high);
                    let precision = real::exp(-bounded.log_var);
                    let surprise = error[i] * error[i] * precision;
                    let d_log_var = share * (1.0 - surprise);
                    loss[i] = share * (surprise + bounded.log_var);
                    d_mean[i] = share * 2.0 * error[i] * precision;
                    d_raw[i] = d_log_var * bounded.d_raw;
                    d_high[i] = d_log_var * bounded.d_high;
                    d_low[i] = d_log_var * bounded.d_low;
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_stay_between_their_bounds() {
        let (low, high) = (-10.0_f32, 0.5_f32);
        let ends = |raw| 2.0 * deviation(raw, low, high).ln();
        for raw in [-1e6, -20.0, -3.0, 0.0, 4.0, 1e6] {
            assert!((-10.0..=0.501).contains(&ends(raw)), "{raw}: {}", ends(raw));
        }
        // In the middle the bounds hardly show.
        assert!((ends(-5.0) + 5.0).abs() < 0.02);
    }

    #[test]
    fn the_loss_of_one_row_is_that_of_the_formula() {
        let mut likelihood = Likelihood::default();
        let loss = likelihood.of(&[1.0, -2.0], &[0.5], &first_bounds(1), &mut [0.0; 2]);
        let softplus = |x: f64| x.exp().ln_1p();
        let log_var = -10.0 + softplus(0.5 - softplus(2.5) + 10.0);
        assert!((loss - (0.25 * (-log_var).exp() + log_var)).abs() < 1e-12, "{loss}");
    }
}
