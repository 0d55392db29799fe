//! How the noise of a channel depends on its value.

use ndarray::Array2;

use super::{Segment, measures};

/// Shares of the variance that are proportional to the square of the value, among which the likeliest is taken.
const SHARES: [f64; 6] = [0.0, 0.5, 0.8, 0.95, 0.99, 1.0];

/// Difference of −2 ln L above which noise that depends on the value is believed: odds of twenty to one.
const BELIEVED: f64 = 6.0;

/// Smallest relative standard deviation of a sample: what is proportional to a value that vanishes does not vanish with it.
const LEAST: f64 = 0.02;

/// `segments` whose samples have the relative standard deviations that are likeliest, and the share of each state's variance (n) that grows
/// with the square of its value; 0 where the noise is the same everywhere. `path` are the states without noise (T + 1, n each).
///
/// # References
/// Davidian, Carroll (1987), J. Am. Stat. Assoc. 82(400): variance functions by pseudo-likelihood of residuals.
pub(crate) fn with_variances(segments: &[Segment], path: &[Array2<f64>]) -> (Vec<Segment>, Vec<f64>) {
    let n = path.first().map_or(0, Array2::ncols);
    let mut weighted = segments.to_vec();
    let shares = (0..n).map(|i| {
        let share = if measures(segments, i) { likeliest(segments, path, i) } else { 0.0 };
        if share > 0.0 {
            let mean = mean_square(path, i);
            for (segment, x) in weighted.iter_mut().zip(path) {
                let relative = segment.relative.get_or_insert_with(|| Array2::ones(x.dim()));
                let of_value = x.column(i).mapv(|v| relative_deviation(share, v, mean));
                relative.column_mut(i).assign(&of_value);
            }
        }
        share
    });
    let shares = shares.collect();
    (weighted, shares)
}

/// √(1 − share + share x²/mean x²).
fn relative_deviation(share: f64, x: f64, mean_square: f64) -> f64 {
    (1.0 - share + share * x * x / mean_square).sqrt().max(LEAST)
}

fn mean_square(path: &[Array2<f64>], i: usize) -> f64 {
    let squares: Vec<f64> = path.iter().flat_map(|x| x.column(i).mapv(|v| v * v).to_vec()).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).max(f64::MIN_POSITIVE)
}

fn likeliest(segments: &[Segment], path: &[Array2<f64>], i: usize) -> f64 {
    let mean = mean_square(path, i);
    let samples = || {
        let of = |(s, x): (&Segment, &Array2<f64>)| {
            s.x.column(i).iter().zip(x.column(i)).map(|(y, x)| (y - x, *x)).collect::<Vec<_>>()
        };
        segments.iter().zip(path).flat_map(of)
    };
    let minus_two_log = |share: f64| {
        let (mut squares, mut logs, mut count) = (0.0, 0.0, 0.0);
        for (e, x) in samples() {
            let w = relative_deviation(share, x, mean);
            squares += (e / w).powi(2);
            logs += 2.0 * w.ln();
            count += 1.0;
        }
        count * (squares / f64::max(count, 1.0)).max(f64::MIN_POSITIVE).ln() + logs
    };
    let same = minus_two_log(SHARES[0]);
    let best = SHARES.iter().map(|&s| (minus_two_log(s), s)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(value, _)| *value < same - BELIEVED).map_or(0.0, |(_, share)| share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Smoother;
    use rand::RngExt as _;
    use sindyna_core::Seed;

    #[test]
    fn noise_that_grows_with_the_value_is_told_from_noise_that_does_not() {
        let mut right = 0;
        for seed in 0..20 {
            let mut rng = Seed::new(seed).stream("noise", 0);
            let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
            let x = Array2::from_shape_fn((300, 2), |(t, i)| {
                let value = 1.2 + f64::sin(0.05 * t as f64);
                if i == 0 { value * (1.0 + 0.05 * normal()) } else { value + 0.05 * normal() }
            });
            let segment = Segment {
                x,
                u: Array2::zeros((299, 0)),
                dt: vec![0.1; 299],
                relative: None,
                ramp: None,
                of_inputs: Vec::new(),
                corrections: None,
            };
            let floor = [1e-12; 2];
            let signals =
                Smoother::new(std::slice::from_ref(&segment), &[None, None], &floor, &|| true).signals(&floor);
            let (_, shares) = with_variances(&[segment], &signals.x);
            right += usize::from(shares[0] >= 0.8 && shares[1] == 0.0);
        }
        assert!(right >= 18, "{right} of 20");
    }
}
