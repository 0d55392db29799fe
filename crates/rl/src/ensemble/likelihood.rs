//! The Gaussian that a network's outputs stand for, how likely it makes the targets, and the gradients of that.

use sindyna_core::vectorized;

use crate::real;

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

/// Numbers of one target handled at once: in arrays of known length, which the compiler turns into vectors.
const ABREAST: usize = 64;

/// What is found about [`ABREAST`] rows of a target.
struct Slopes {
    loss: [f64; ABREAST],
    mean: [f64; ABREAST],
    raw: [f64; ABREAST],
    high: [f64; ABREAST],
    low: [f64; ABREAST],
}

/// Losses e²/σ² + log σ² and their slopes, from errors e and unbounded log σ².
fn slopes(error: &[f64; ABREAST], raw: &[f64; ABREAST], low: f64, high: f64) -> Slopes {
    vectorized(
        #[inline(always)]
        || {
            let none = [0.0; ABREAST];
            let mut slopes = Slopes { loss: none, mean: none, raw: none, high: none, low: none };
            for i in 0..ABREAST {
                let bounded = bound(raw[i], low, high);
                let precision = real::exp(-bounded.log_var);
                let surprise = error[i] * error[i] * precision;
                let d_log_var = 1.0 - surprise;
                slopes.loss[i] = surprise + bounded.log_var;
                slopes.mean[i] = 2.0 * error[i] * precision;
                slopes.raw[i] = d_log_var * bounded.d_raw;
                slopes.high[i] = d_log_var * bounded.d_high;
                slopes.low[i] = d_log_var * bounded.d_low;
            }
            slopes
        },
    )
}

/// Negative log-likelihood of rows of targets, and its gradients.
///
/// A row of `outputs` (rows, 2q) is (μ₁…μ_q, raw₁…raw_q), to which belongs one of `targets` (rows, q). The loss, which is
/// returned, is the mean over rows and targets of (μ - y)²/σ² + log σ²: twice the negative log-likelihood but for a
/// constant. `d_outputs` (rows, 2q) is overwritten with its gradient; that by the `bounds` (2q, upper ones first) is added
/// to `d_bounds` (2q).
///
/// # References
/// Chua et al. (2018), arXiv:1805.12114, §4 and appendix A.1 (the bounds).
pub(super) fn likelihood(
    outputs: &[f32],
    targets: &[f32],
    bounds: &[f32],
    d_outputs: &mut [f32],
    d_bounds: &mut [f64],
) -> f64 {
    let q = bounds.len() / 2;
    let share = 1.0 / targets.len() as f64;
    let mut sum = 0.0;
    let blocks = outputs.chunks(2 * q * ABREAST).zip(targets.chunks(q * ABREAST));
    for ((outputs, targets), d_outputs) in blocks.zip(d_outputs.chunks_mut(2 * q * ABREAST)) {
        for j in 0..q {
            // Rows that are missing in the last block stay 0 and are left out of the sums.
            let (mut error, mut raw, rows) = ([0.0; ABREAST], [0.0; ABREAST], targets.len() / q);
            for row in 0..rows {
                let output = &outputs[2 * q * row..2 * q * (row + 1)];
                error[row] = f64::from(output[j]) - f64::from(targets[q * row + j]);
                raw[row] = f64::from(output[q + j]);
            }
            let slopes = slopes(&error, &raw, f64::from(bounds[q + j]), f64::from(bounds[j]));
            sum += slopes.loss[..rows].iter().sum::<f64>();
            d_bounds[j] += share * slopes.high[..rows].iter().sum::<f64>();
            d_bounds[q + j] += share * slopes.low[..rows].iter().sum::<f64>();
            for (row, d) in d_outputs.chunks_exact_mut(2 * q).enumerate() {
                d[j] = (share * slopes.mean[row]) as f32;
                d[q + j] = (share * slopes.raw[row]) as f32;
            }
        }
    }
    share * sum
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
        let loss = likelihood(&[1.0, -2.0], &[0.5], &first_bounds(1), &mut [0.0; 2], &mut [0.0; 2]);
        let softplus = |x: f64| x.exp().ln_1p();
        let log_var = -10.0 + softplus(0.5 - softplus(2.5) + 10.0);
        assert!((loss - (0.25 * (-log_var).exp() + log_var)).abs() < 1e-12, "{loss}");
    }
}
