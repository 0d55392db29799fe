//! The state behind noisy measurements.

use ndarray::{Array1, Array2};

use super::plant::{Plant, unused};

/// Smallest standard deviation of a measurement, in scales of its state: an error far below what matters.
const FLOOR: f64 = 1e-6;

/// Steps over which the squares of the innovations are averaged.
const STEPS: f64 = 100.0;

/// An extended Kalman filter, all of whose states are measured.
///
/// Prediction: x ← F(x, u), P ← A P Aᵀ with A = ∂F/∂x. Update by each state yᵢ = xᵢ + vᵢ, v of variance rᵢ: x ← x + P·ᵢ (yᵢ − xᵢ) / (Pᵢᵢ + rᵢ). Before it,
/// Pᵢᵢ is at least what the mean square of the innovations is more than rᵢ: where the model is wrong, measurements count for more.
///
/// # References
/// Myers and Tapley (1976), IEEE Transactions on Automatic Control 21(4): noise of the process by matching covariances.
#[derive(Debug, Clone)]
pub(crate) struct Filter {
    variances: Array1<f64>,
    /// P; none before the first measurement.
    covariance: Option<Array2<f64>>,
    /// Mean square of the innovations of each state, in variances of its measurements.
    seen: Array1<f64>,
}

impl Filter {
    /// A filter for measurements with errors of the standard `deviations` (n); `None` if there are no errors.
    pub(crate) fn new(plant: &Plant, deviations: &[f64]) -> Option<Self> {
        let noisy = deviations.len() == plant.scales.len() && deviations.iter().any(|deviation| *deviation > 0.0);
        let variance = |(deviation, scale): (&f64, &f64)| deviation.max(FLOOR * scale).powi(2);
        let variances = deviations.iter().zip(&plant.scales).map(variance).collect();
        let seen = Array1::ones(deviations.len());
        noisy.then_some(Self { variances, covariance: None, seen })
    }

    /// Moves `x` from the predicted to the most likely state after the `measured` one.
    pub(crate) fn update(&mut self, measured: &[f64], x: &mut [f64]) {
        let Some(p) = &mut self.covariance else {
            x.copy_from_slice(measured);
            self.covariance = Some(Array2::from_diag(&self.variances));
            return;
        };
        for i in 0..x.len() {
            self.seen[i] += ((measured[i] - x[i]).powi(2) / self.variances[i] - self.seen[i]) / STEPS;
            p[[i, i]] = p[[i, i]].max((self.seen[i] - 1.0) * self.variances[i]);
        }
        for i in 0..x.len() {
            let gain = &p.column(i) / (p[[i, i]] + self.variances[i]);
            let innovation = measured[i] - x[i];
            x.iter_mut().zip(&gain).for_each(|(x, gain)| *x += gain * innovation);
            let row = p.row(i).to_owned();
            for (mut of, gain) in p.rows_mut().into_iter().zip(&gain) {
                of.scaled_add(-gain, &row);
            }
        }
    }

    /// Moves `x` to the state that a step under `u` leads to; forgets all before where the model diverges.
    pub(crate) fn predict(&mut self, plant: &Plant, x: &mut Vec<f64>, u: &[f64]) {
        let (mut rng, mut next) = (unused(), vec![0.0; x.len()]);
        let moved = plant.dynamics().step(x, u, &mut rng, &mut next).and_then(|()| plant.linearize(x, u, &mut rng));
        self.covariance = moved.ok().and_then(|(a, _)| Some(a.dot(self.covariance.as_ref()?).dot(&a.t())));
        if self.covariance.is_some() {
            *x = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand_distr::{Distribution as _, StandardNormal};
    use sindyna_core::Seed;

    use super::*;

    /// Errors (RMS of the angle and of the rate) of the estimates and of the measurements along 400 steps of a pendulum that is pushed, after the first 50.
    fn errors(of_model: f64) -> ([f64; 2], [f64; 2]) {
        let system = sindyna_envs::find("pendulum").expect("it is registered");
        let plant = Plant::new(system.dynamics(), system.task());
        let noise = [0.05, 0.4];
        let mut filter = Filter::new(&plant, &noise).expect("there is noise");
        let (mut rng, mut drawn) = (Seed::new(3).numpy(), Seed::new(4).numpy());
        let (mut truth, mut next, mut x) = (vec![2.0, 0.0], vec![0.0; 2], vec![0.0; 2]);
        let (mut estimated, mut raw) = ([0.0; 2], [0.0; 2]);
        for t in 0..400 {
            let mut normal = || -> f64 { StandardNormal.sample(&mut drawn) };
            let measured = [truth[0] + noise[0] * normal(), truth[1] + noise[1] * normal()];
            filter.update(&measured, &mut x);
            if t >= 50 {
                for i in 0..2 {
                    estimated[i] += (x[i] - truth[i]).powi(2) / 350.0;
                    raw[i] += (measured[i] - truth[i]).powi(2) / 350.0;
                }
            }
            let u = [(f64::from(t) / 7.0).sin()];
            filter.predict(&plant, &mut x, &u);
            plant.step(&truth, &[u[0] + of_model], &mut rng, &mut next).expect("it stays finite");
            std::mem::swap(&mut truth, &mut next);
        }
        (estimated.map(f64::sqrt), raw.map(f64::sqrt))
    }

    #[test]
    fn estimates_are_nearer_than_measurements() {
        let (estimated, raw) = errors(0.0);
        assert!((0..2).all(|i| estimated[i] < 0.35 * raw[i]), "{estimated:?} {raw:?}");
    }

    #[test]
    fn a_wrong_model_does_not_cut_measurements_off() {
        // A push that the model does not know: 0.5 of the limit of 2.
        let (estimated, raw) = errors(0.5);
        assert!((0..2).all(|i| estimated[i] < raw[i]), "{estimated:?} {raw:?}");
    }

    #[test]
    fn exact_measurements_need_no_filter() {
        let system = sindyna_envs::find("pendulum").expect("it is registered");
        let plant = Plant::new(system.dynamics(), Arc::clone(&system.task()));
        assert!(Filter::new(&plant, &[0.0, 0.0]).is_none() && Filter::new(&plant, &[]).is_none());
    }
}
