//! Coordinates in which data have no preferred direction.

/// Whitened coordinates of states: w = L⁻¹ D⁻¹ (x − μ), with the mean μ and the standard deviations D of samples and the Cholesky factor L of their correlations.
///
/// Few samples, each near the one before, look thinner than the system is: as many samples of independent states as there are states are added to the
/// correlations, R = (N R̂ + n I) / (N + n).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whitened {
    mean: Vec<f64>,
    deviation: Vec<f64>,
    /// L, by rows (n × n).
    factor: Vec<f64>,
}

/// Smallest standard deviation as a part of the mean's magnitude, for states that stood still.
const STILL: f64 = 1e-6;

impl Whitened {
    /// Of `samples` (each n). States whose `known` deviation is told have that around 0, and are independent of all others.
    pub(crate) fn of(samples: &[Vec<f64>], known: &[Option<f64>]) -> Self {
        let (n, count) = (known.len(), samples.len().max(1) as f64);
        let mut mean = vec![0.0; n];
        let mut deviation = vec![0.0; n];
        for (i, known) in known.iter().enumerate() {
            if let Some(known) = known {
                deviation[i] = *known;
                continue;
            }
            mean[i] = samples.iter().map(|x| x[i]).sum::<f64>() / count;
            let variance = samples.iter().map(|x| (x[i] - mean[i]).powi(2)).sum::<f64>() / count;
            deviation[i] = variance.sqrt().max(STILL * (1.0 + mean[i].abs()));
        }
        let correlation = |i: usize, j: usize| {
            if known[i].is_some() || known[j].is_some() {
                return 0.0;
            }
            let products = samples.iter().map(|x| (x[i] - mean[i]) * (x[j] - mean[j]));
            products.sum::<f64>() / (deviation[i] * deviation[j] * (count + n as f64))
        };
        let mut factor = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let before: f64 = (0..j).map(|k| factor[i * n + k] * factor[j * n + k]).sum();
                factor[i * n + j] = match i == j {
                    // Not below what the samples added are worth.
                    true => (1.0 - before).max(n as f64 / (count + n as f64)).sqrt(),
                    false => (correlation(i, j) - before) / factor[j * n + j],
                };
            }
        }
        Self { mean, deviation, factor }
    }

    /// Standard deviation of each state (n).
    pub(crate) fn deviations(&self) -> &[f64] {
        &self.deviation
    }

    /// The length of `difference` (n) in whitened coordinates.
    pub(crate) fn length(&self, difference: impl Iterator<Item = f64>) -> f64 {
        let n = self.mean.len();
        let mut w = Vec::with_capacity(n);
        for (i, (difference, deviation)) in difference.zip(&self.deviation).enumerate() {
            let before: f64 = w.iter().zip(&self.factor[i * n..]).map(|(w, factor): (&f64, &f64)| w * factor).sum();
            w.push((difference / deviation - before) / self.factor[i * n + i]);
        }
        w.iter().map(|w| w * w).sum::<f64>().sqrt()
    }

    /// The distance of `x` (n) from the mean.
    pub(crate) fn distance(&self, x: &[f64]) -> f64 {
        self.length(x.iter().zip(&self.mean).map(|(x, mean)| x - mean))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_across_the_data_is_farther_than_what_lies_along_them() {
        let samples: Vec<Vec<f64>> =
            (-50..=50).map(|t| vec![f64::from(t), 300.0 + 0.02 * f64::from(t), 0.5 * f64::from(t % 2)]).collect();
        let whitened = Whitened::of(&samples, &[None, None, Some(2.0)]);
        let along = whitened.distance(&[50.0, 301.0, 0.0]);
        let across = whitened.distance(&[50.0, 299.0, 0.0]);
        assert!((1.0..2.5).contains(&along) && across > 4.0 * along, "{along} and {across}");
        assert!((whitened.distance(&[0.0, 300.0, 4.0]) - 2.0).abs() < 1e-9, "what is known is independent");
    }

    #[test]
    fn units_do_not_matter() {
        let samples: Vec<Vec<f64>> =
            (0..20).map(|t| vec![f64::from(t * t % 7), f64::from(t % 5), f64::from(t)]).collect();
        let scaled: Vec<Vec<f64>> = samples.iter().map(|x| vec![1e3 * x[0], 1e-3 * x[1] + 7.0, -x[2]]).collect();
        let none = [None; 3];
        let (plain, other) = (Whitened::of(&samples, &none), Whitened::of(&scaled, &none));
        let (a, b) = (plain.distance(&[9.0, 2.0, -4.0]), other.distance(&[9e3, 7.002, 4.0]));
        assert!((a - b).abs() < 1e-6 * a, "{a} and {b}");
    }

    #[test]
    fn states_that_stood_still_and_no_samples_give_numbers() {
        let still = Whitened::of(&vec![vec![300.0]; 5], &[None]);
        assert!(still.distance(&[300.0]) < 1e-6 && still.distance(&[301.0]).is_finite());
        assert!(Whitened::of(&[], &[None, None]).distance(&[1.0, 1.0]).is_finite());
    }
}
