//! How well a model predicts data that it was not fitted to.

use std::ops::Range;

use sindyna_core::{Dataset, Dynamics, Inverse, Rng};

/// Steps ahead that are predicted.
const HORIZON: usize = 10;

/// Multiple of the errors on its own data up to which a model's errors on new data are no surprise.
const TOLERATED: f64 = 1.5;

/// Whether `model`, fitted to the rollouts of `data` before number `new`, predicts the later ones much worse than its own. Where there is
/// nothing to compare, it does.
pub(crate) fn is_surprised(model: &dyn Dynamics, inverse: &Inverse, data: &Dataset, new: usize, rng: &mut Rng) -> bool {
    let own = error(model, inverse, data, 0..new, rng);
    let later = error(model, inverse, data, new..data.n_rollouts(), rng);
    match (own, later) {
        (Some(own), Some(later)) => later > TOLERATED * own,
        _ => true,
    }
}

/// RMS error of the states predicted [`HORIZON`] steps ahead, from every sample of the `rollouts` that has so many after it or at least one, as a part of
/// their standard deviations over all data. `None` without such samples; infinite where the model diverges.
fn error(
    model: &dyn Dynamics,
    inverse: &Inverse,
    data: &Dataset,
    rollouts: Range<usize>,
    rng: &mut Rng,
) -> Option<f64> {
    let n = inverse.n_states();
    let states = |r: &sindyna_core::Rollout<'_>| {
        let mut x = vec![0.0; n];
        let mut rows = Vec::with_capacity(r.observations.nrows());
        for o in r.observations.rows() {
            let near = x.clone();
            inverse.state(&o.to_vec(), &near, &mut x);
            rows.push(x.clone());
        }
        rows
    };
    let all: Vec<Vec<f64>> = data.rollouts().flat_map(|r| states(&r)).collect();
    let spread = |i: usize| {
        let count = all.len().max(1) as f64;
        let mean = all.iter().map(|x| x[i]).sum::<f64>() / count;
        (all.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>() / count).sqrt()
    };
    let spreads: Vec<f64> = (0..n).map(spread).collect();
    let (mut sum, mut count) = (0.0, 0.0);
    let (mut x, mut next) = (vec![0.0; n], vec![0.0; n]);
    for rollout in data.rollouts().skip(rollouts.start).take(rollouts.len()) {
        let measured = states(&rollout);
        let steps = rollout.rewards.len();
        for first in 0..=steps.saturating_sub(HORIZON) {
            let last = steps.min(first + HORIZON);
            if last == first {
                continue;
            }
            x.clone_from(&measured[first]);
            for t in first..last {
                if model.step(&x, &rollout.controls.row(t).to_vec(), rng, &mut next).is_err() {
                    return Some(f64::INFINITY);
                }
                std::mem::swap(&mut x, &mut next);
            }
            let errors = x.iter().zip(&measured[last]).zip(&spreads);
            sum += errors.filter(|(_, s)| **s > 0.0).map(|((a, b), s)| ((a - b) / s).powi(2)).sum::<f64>();
            count += n as f64;
        }
    }
    (count > 0.0).then(|| (sum / count).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Diverged, Seed};

    /// x' = x + gain u.
    struct Push(f64);

    impl Dynamics for Push {
        fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
            next[0] = x[0] + self.0 * u[0];
            Diverged::check(next)
        }
    }

    /// One rollout of 20 steps for every gain, its steps by a little more than that.
    fn data(gains: &[f64]) -> Dataset {
        let mut data = Dataset::new(1, 1, 1, 0.1);
        for gain in gains {
            let mut x = 0.0;
            data.begin(&[x]).expect("finite");
            for t in 0..20 {
                let u = f64::from(t % 3) - 1.0;
                x += (gain + 0.01) * u;
                data.push(&[u], &[u], 0.0, &[x]).expect("finite");
            }
        }
        data
    }

    fn surprised(gains: &[f64]) -> bool {
        let spec = crate::one_state::spec();
        let inverse = Inverse::of(&spec).expect("all is shown");
        is_surprised(&Push(1.0), &inverse, &data(gains), 1, &mut Seed::new(0).numpy())
    }

    #[test]
    fn data_of_the_same_system_are_no_surprise_and_others_are() {
        assert!(!surprised(&[1.0, 1.0]));
        assert!(surprised(&[1.0, 1.2]));
        assert!(surprised(&[1.0]), "nothing new was seen");
    }
}
