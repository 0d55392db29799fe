//! Inputs that act through a first-order lag: what an actuator delivers follows what it is told.

use sindyna_core::number::significant;
use sindyna_core::{Dataset, FitError, InterSample};

use super::delay::shifted;
use crate::logs::{Log, Note, Samples};

/// Time constants after which nothing is left of what an actuator delivered before: e⁻³⁶ is the rounding of one.
const FORGOTTEN: f64 = 36.0;

/// Part of the first inputs behind a lag that had settled.
pub(super) const SETTLED: f64 = 1.0;

/// Part of the steps that may be left out until then, at most.
const SPENT: f64 = 0.25;

/// `log` with inputs as they are behind a lag with the time constant `tau` \[s\], v' = (u − v)/τ, and a note of it. What they were before a trajectory is not known: they begin with the part `settled` of the first ones, and
/// its first steps are not used.
///
/// # Errors
/// [`FitError::Regression`] if inputs are not held, or nothing is left of the log.
pub(super) fn lagged(log: &Log, (tau, settled): (f64, f64)) -> Result<Log, FitError> {
    if !log.data.intersample().is_held() {
        let reason = "a lag requires inputs that are held, after a delay of whole rows";
        return Err(FitError::Regression { reason: reason.into() });
    }
    let longest = log.data.rollouts().map(|rollout| rollout.controls.nrows()).max().unwrap_or(0) as f64 * log.data.dt();
    if tau > longest {
        let reason = format!(
            "the time constant of the lag is {} s, longer than the longest trajectory, {} s",
            significant(tau, 6),
            significant(longest, 6)
        );
        return Err(FitError::Regression { reason });
    }
    let delivered = delivered(&log.data, log.times.as_deref(), (tau, settled))?;
    let first = forgotten(&log.data, tau);
    let Samples { data, times, .. } = shifted(&delivered, log.times.as_deref(), 0.0, (first, 0), usize::MAX)?;
    if data.n_steps() == 0 {
        return Err(FitError::Regression { reason: "no trajectory is longer than the lag of the inputs".into() });
    }
    let mut notes = log.notes.clone();
    notes.push(Note::Lagged { seconds: tau, deviation: None });
    Ok(Log { data, times, derivatives: None, notes, ..log.clone() })
}

/// `data`, sampled at `times`, with inputs behind a lag of `tau` \[s\], which begin each trajectory with the part `settled` of the first ones.
///
/// # Errors
/// [`FitError::Regression`] for values that are not finite.
pub(super) fn delivered(
    data: &Dataset,
    times: Option<&[Vec<f64>]>,
    (tau, settled): (f64, f64),
) -> Result<Dataset, FitError> {
    let failed = |e: sindyna_core::DatasetError| FitError::Regression { reason: e.to_string() };
    let (m, k) = (data.observation_dim(), data.control_dim());
    let mut all = Dataset::new(m, k, k, data.dt()).with_intersample(InterSample::Lag(tau));
    for (number, rollout) in data.rollouts().enumerate() {
        let times = times.and_then(|all| all.get(number));
        all.begin(&rollout.observations.row(0).to_vec()).map_err(failed)?;
        let mut v = rollout
            .controls
            .rows()
            .into_iter()
            .next()
            .map_or_else(Vec::new, |u| u.iter().map(|u| settled * u).collect());
        for (t, u) in rollout.controls.rows().into_iter().enumerate() {
            all.push(&v, &v, 0.0, &rollout.observations.row(t + 1).to_vec()).map_err(failed)?;
            let interval = times.map_or(data.dt(), |times| times[t + 1] - times[t]);
            let left = (-interval / tau).exp();
            v.iter_mut().zip(u).for_each(|(v, u)| *v = u + (*v - u) * left);
        }
    }
    Ok(all)
}

/// Steps after the beginning of each trajectory of `data` until a lag of `tau` \[s\] has forgotten what was before it, or as many of them as may be left out.
pub(super) fn forgotten(data: &Dataset, tau: f64) -> usize {
    let most = SPENT * data.n_steps() as f64 / data.n_rollouts().max(1) as f64;
    (FORGOTTEN * tau / data.dt()).ceil().min(most) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_behind_a_lag_approach_what_they_are_told() {
        let mut data = Dataset::new(1, 1, 1, 0.1);
        data.begin(&[0.0]).expect("begun");
        for t in 0..6 {
            let u = [f64::from(u8::from(t >= 2))];
            data.push(&u, &u, 0.0, &[f64::from(t)]).expect("pushed");
        }
        let of = |times: Option<&[Vec<f64>]>| {
            let delivered = delivered(&data, times, (0.1, SETTLED)).expect("finite");
            assert_eq!(delivered.intersample(), InterSample::Lag(0.1));
            delivered.rollouts().next().expect("one").controls.column(0).to_vec()
        };
        let after = |t: f64| 1.0 - f64::exp(-t);
        let near = |got: Vec<f64>, expected: [f64; 6]| {
            assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{got:?} {expected:?}");
        };
        near(of(None), [0.0, 0.0, 0.0, after(1.0), after(2.0), after(3.0)]);
        let times = vec![vec![0.0, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7]];
        near(of(Some(&times)), [0.0, 0.0, 0.0, after(1.0), after(3.0), after(4.0)]);
        assert_eq!((forgotten(&data, 0.001), forgotten(&data, 0.1)), (1, 1), "a quarter of six at most");
    }
}
