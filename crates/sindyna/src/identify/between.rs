//! Inputs that are linear, or smooth, between samples.

use ndarray::{Array2, ArrayView2};
use sindyna_core::{Dataset, FitError, InterSample};

use crate::logs::{Log, Note, Samples};

/// `log` with inputs that are so between samples, not held, and a note of it; `given` if that was said.
///
/// # Errors
/// [`FitError::Regression`] for smooth inputs where samples are not even.
pub(super) fn between(log: &Log, intersample: InterSample, given: bool) -> Result<Log, FitError> {
    if log.times.is_some() && intersample == InterSample::Bl {
        let reason = "inputs that are smooth between samples require evenly spaced samples: resample the log first";
        return Err(FitError::Regression { reason: reason.into() });
    }
    let mut notes = log.notes.clone();
    notes.push(Note::InterSample { intersample, given });
    Ok(Log { data: read(&log.data, intersample)?, notes, ..log.clone() })
}

/// `data` with inputs that are so between samples.
///
/// # Errors
/// [`FitError::Regression`] for values that are not finite.
pub(super) fn read(data: &Dataset, intersample: InterSample) -> Result<Dataset, FitError> {
    if intersample != InterSample::Bl {
        return Ok(data.clone().with_intersample(intersample));
    }
    let failed = |e: sindyna_core::DatasetError| FitError::Regression { reason: e.to_string() };
    let (m, k) = (data.observation_dim(), data.control_dim());
    let mut all = Dataset::new(m, k, k, data.dt()).with_intersample(intersample);
    for rollout in data.rollouts() {
        all.begin(&rollout.observations.row(0).to_vec()).map_err(failed)?;
        for (u, next) in
            smooth(rollout.controls).rows().into_iter().zip(rollout.observations.rows().into_iter().skip(1))
        {
            all.push(&u.to_vec(), &u.to_vec(), 0.0, &next.to_vec()).map_err(failed)?;
        }
    }
    Ok(all)
}

/// The inputs v = u − (u₊ − 2 u + u₋)/12 (T, k): (v + v₊)/2 is the mean over a step of the cubic through u₋, u, u₊ and that after it, (u + u₊)/2 − (u₊₊ − u₊ − u + u₋)/24.
fn smooth(u: ArrayView2<'_, f64>) -> Array2<f64> {
    let last = u.nrows().saturating_sub(1);
    let bent = |t: usize, j: usize| {
        // At either end it bends as beside it.
        let t = t.clamp(1, last.max(2) - 1);
        u[[t + 1, j]] - 2.0 * u[[t, j]] + u[[t - 1, j]]
    };
    Array2::from_shape_fn(u.dim(), |(t, j)| if last < 2 { u[[t, j]] } else { u[[t, j]] - bent(t, j) / 12.0 })
}

/// Whether every input that changes stays the same before and after most of its changes: it was set from row to row, and no straight line leads from one setting to the next.
pub(super) fn is_set(samples: &Samples) -> bool {
    let count = |j: usize| {
        let (mut changes, mut alone) = (0, 0);
        for rollout in samples.data.rollouts() {
            let u = rollout.controls.column(j);
            let differs = |t: usize| u[t].to_bits() != u[t - 1].to_bits();
            for t in (2..u.len().saturating_sub(1)).filter(|&t| differs(t)) {
                changes += 1;
                alone += usize::from(!differs(t - 1) && !differs(t + 1));
            }
        }
        (changes, alone)
    };
    let all: Vec<(usize, usize)> =
        (0..samples.data.control_dim()).map(count).filter(|(changes, _)| *changes > 0).collect();
    !all.is_empty() && all.iter().all(|(changes, alone)| 2 * alone > *changes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::Dataset;

    #[test]
    fn smooth_inputs_have_the_means_of_their_curves() {
        let of = |t: f64| (0.4 * t).sin() + 0.1 * t * t;
        let v = smooth(Array2::from_shape_fn((30, 1), |(t, _)| of(t as f64)).view());
        for t in 1..28 {
            let mean = (0..1000).map(|i| of(t as f64 + (f64::from(i) + 0.5) / 1000.0) / 1000.0).sum::<f64>();
            assert!((0.5 * (v[[t, 0]] + v[[t + 1, 0]]) - mean).abs() < 1e-3, "{t}");
            assert!((0.5 * (of(t as f64) + of(t as f64 + 1.0)) - mean).abs() > 2e-3, "{t}");
        }
        let short = Array2::from_shape_fn((2, 1), |(t, _)| t as f64);
        assert_eq!(smooth(short.view()), short);
    }

    #[test]
    fn inputs_that_stay_are_set() {
        let of = |u: &dyn Fn(usize) -> f64| {
            let mut data = Dataset::new(1, 1, 1, 1.0);
            data.begin(&[0.0]).expect("a start");
            (0..100).for_each(|t| data.push(&[u(t)], &[u(t)], 0.0, &[0.0]).expect("a step"));
            is_set(&Samples { data, times: None, derivatives: None })
        };
        assert!(of(&|t| (t / 7) as f64), "steps");
        assert!(!of(&|t| (0.1 * t as f64).sin()), "a sine");
        assert!(!of(&|t| (t / 2) as f64 * 0.1 + (t % 2) as f64 * 0.05), "a ramp");
        assert!(!of(&|_| 1.0), "nothing");
    }
}
