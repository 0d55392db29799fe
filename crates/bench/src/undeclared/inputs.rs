//! Input signals: smooth and stepwise at once.

use std::f64::consts::TAU;

use rand::Rng as _;
use sindyna_core::Rng;

/// Sines in the smooth part.
const SINES: usize = 3;

/// Periods of these \[samples\].
const PERIODS: (f64, f64) = (10.0, 60.0);

/// Samples for which the stepwise part stays at a level.
const STAYS: (f64, f64) = (4.0, 20.0);

/// An input of `steps` samples within `range`: half of it three sines, half of it random levels held for a while.
pub(super) fn signal(range: (f64, f64), steps: usize, rng: &mut Rng) -> Vec<f64> {
    let sines: Vec<(f64, f64)> =
        (0..SINES).map(|_| (uniform(PERIODS.0, PERIODS.1, rng), uniform(0.0, TAU, rng))).collect();
    let (mut level, mut left) = (0.0, 0);
    let (middle, half) = (0.5 * (range.0 + range.1), 0.5 * (range.1 - range.0));
    let value = |t: usize| {
        if left == 0 {
            level = uniform(-1.0, 1.0, rng);
            left = uniform(STAYS.0, STAYS.1, rng) as usize;
        }
        left -= 1;
        let smooth: f64 = sines.iter().map(|(period, phase)| (TAU * t as f64 / period + phase).sin()).sum();
        middle + half * 0.5 * (smooth / SINES as f64 + level)
    };
    (0..steps).map(value).collect()
}

/// A uniform draw.
pub(super) fn uniform(low: f64, high: f64, rng: &mut Rng) -> f64 {
    low + (high - low) * (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
