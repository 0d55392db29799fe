//! Whether residuals look like noise.

use ndarray::Array2;

/// Lags looked at.
const LAGS: usize = 10;

/// Samples for every lag, below which nothing can be told.
const FEWEST: f64 = 3.0;

/// Quantile of the standard normal distribution at which chance is no longer believed: one false alarm in ten thousand.
const QUANTILE: f64 = 3.72;

/// Whether the residuals in column `i` of all `residuals` are uncorrelated from sample to sample; `false` where too few of them can tell.
///
/// # References
/// Ljung, Box (1978), Biometrika 65(2).
pub(super) fn is_white(residuals: &[Array2<f64>], i: usize) -> bool {
    let columns: Vec<Vec<f64>> = residuals.iter().map(|r| r.column(i).to_vec()).collect();
    let count: f64 = columns.iter().map(|c| c.len() as f64).sum();
    let square: f64 = columns.iter().flatten().map(|v| v * v).sum();
    if square <= 0.0 {
        return true;
    }
    if count <= FEWEST * LAGS as f64 {
        return false;
    }
    let mut statistic = 0.0;
    for lag in 1..=LAGS {
        let product: f64 =
            columns.iter().map(|c| c.iter().zip(c.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>()).sum();
        let pairs: f64 = columns.iter().map(|c| c.len().saturating_sub(lag) as f64).sum();
        if pairs > 0.0 {
            // Each correlation has the variance 1/pairs.
            statistic += (product / square * count / pairs).powi(2) * pairs;
        }
    }
    statistic < by_chance(LAGS)
}

/// What a sum of `k` squares of standard normal numbers exceeds once in ten thousand times.
///
/// # References
/// Wilson, Hilferty (1931), PNAS 17(12).
pub(super) fn by_chance(k: usize) -> f64 {
    let k = k as f64;
    let spread = 2.0 / (9.0 * k);
    k * (1.0 - spread + QUANTILE * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt as _;
    use sindyna_core::Seed;

    #[test]
    fn noise_is_white_and_a_slow_wave_under_it_is_not() {
        let mut rng = Seed::new(1).stream("noise", 0);
        let mut alarms = 0;
        for _ in 0..200 {
            let noise = Array2::from_shape_fn((300, 1), |_| rng.random::<f64>() - 0.5);
            alarms += usize::from(!is_white(std::slice::from_ref(&noise), 0));
            let wave = Array2::from_shape_fn((300, 1), |(t, _)| 0.4 * (0.1 * t as f64).sin());
            assert!(!is_white(&[noise + wave], 0));
        }
        assert!(alarms <= 2, "{alarms} false alarms of 200");
    }
}
