//! Predictions of samples that the equations were not fitted to.

use ndarray::{Array2, s};
use serde::{Deserialize, Serialize};
use sindyna_sindy::{AnalysisError, Model, Recording};

/// How well a model predicts samples that it was not fitted to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// The logs they are of; none for the last rows of those that the equations were found in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub logs: Vec<String>,
    /// Steps that were predicted.
    pub steps: usize,
    /// Why there are no more predictions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// One for each horizon.
    pub predictions: Vec<FreeRun>,
}

/// How well windows of one length are predicted under the inputs that were recorded. Windows begin every fifth of their length; each begins at the end of the path
/// of the model that is nearest to the samples of a tenth of its length before it, where the noise of these is known, else at its first sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FreeRun {
    /// Steps of a window; `null` for all of a trajectory.
    pub horizon: Option<usize>,
    /// Its length, where that was asked for \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// How many windows there are.
    #[serde(default)]
    pub windows: usize,
    /// In how many of them the prediction leaves the finite numbers.
    #[serde(default)]
    pub diverged: usize,
    /// Where the first of these begins: number of the trajectory from 1, and time since its start \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_diverged: Option<(usize, f64)>,
    /// Per state that was measured: 100 (1 − NRMSE) over all windows, `null` where the state never changes or a prediction diverges.
    pub fit_percent: Vec<(String, Option<f64>)>,
    /// Per state that was measured: RMSE over all windows, `null` where a prediction diverges.
    #[serde(default)]
    pub rmse: Vec<(String, Option<f64>)>,
    /// Per state that was measured: median of the RMSE of each window, of which those that diverge are the largest; `null` where it is one of them.
    #[serde(default)]
    pub median_rmse: Vec<(String, Option<f64>)>,
}

/// How far ahead predictions are made.
#[derive(Debug, Clone, Copy)]
enum Ahead {
    Steps(usize),
    /// \[s\]
    Seconds(f64),
    /// To the end.
    All,
}

/// What is predicted.
const HORIZONS: [Ahead; 5] = [Ahead::Steps(1), Ahead::Steps(10), Ahead::Seconds(0.5), Ahead::Seconds(1.0), Ahead::All];

impl Ahead {
    /// Steps of `recordings` ahead: `None` for all of them, an error for none that are fewer.
    fn steps(self, recordings: &[Recording]) -> Option<Option<usize>> {
        let longest = recordings.iter().map(Recording::steps).max().unwrap_or(0);
        let steps = match self {
            Self::All => return Some(None),
            Self::Steps(steps) => steps,
            Self::Seconds(seconds) => (seconds / usual_step(recordings)).round() as usize,
        };
        // One step is asked for as such.
        let least = if matches!(self, Self::Seconds(_)) { 2 } else { 1 };
        (least..longest.max(2)).contains(&steps).then_some(Some(steps))
    }
}

/// The median step \[s\].
fn usual_step(recordings: &[Recording]) -> f64 {
    let mut steps: Vec<f64> = recordings.iter().flat_map(|r| r.times.windows(2).map(|t| t[1] - t[0])).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY)
}

impl HeldOut {
    /// How well `model` predicts `recordings` that it was not fitted to, whose samples have errors of the sizes `noise` (n; none if not known); of states that
    /// were `unmeasured` there is nothing to compare with.
    #[must_use]
    pub fn of(model: &Model, recordings: &[Recording], unmeasured: &[String], noise: &[f64]) -> Self {
        let asked = HORIZONS.iter().filter_map(|ahead| Some((ahead, ahead.steps(recordings)?)));
        let of = |(ahead, steps): (&Ahead, Option<usize>)| {
            let seconds = if let Ahead::Seconds(seconds) = ahead { Some(*seconds) } else { None };
            Ok::<_, AnalysisError>(FreeRun { seconds, ..FreeRun::of(model, (recordings, noise), steps, unmeasured)? })
        };
        let (predictions, failed): (Vec<_>, Vec<_>) = asked.map(of).partition(Result::is_ok);
        Self {
            logs: Vec::new(),
            steps: recordings.iter().map(|r| r.controls.nrows()).sum(),
            predictions: predictions.into_iter().flatten().collect(),
            failed: failed.into_iter().filter_map(Result::err).map(|e| e.to_string()).next(),
        }
    }

    /// The same of `logs`.
    #[must_use]
    pub fn with_logs(self, logs: Vec<String>) -> Self {
        Self { logs, ..self }
    }
}

impl FreeRun {
    fn of(
        model: &Model,
        (recordings, noise): (&[Recording], &[f64]),
        horizon: Option<usize>,
        unmeasured: &[String],
    ) -> Result<Self, AnalysisError> {
        let n = model.states().len();
        let (mut errors, mut samples): (Vec<Option<Array2<f64>>>, Vec<Array2<f64>>) = (Vec::new(), Vec::new());
        let mut first_diverged = None;
        for (number, recording) in recordings.iter().enumerate() {
            let steps = recording.steps();
            let length = horizon.unwrap_or(steps).min(steps);
            let before = if horizon.is_some() && noise.len() == n { (length / 10).min(steps - length) } else { 0 };
            let starts = (before..=steps - length).step_by((length / 5).max(1));
            for from in starts.filter(|_| length > 0) {
                let to = from + length;
                let dt: Vec<f64> = recording.times[from..=to].windows(2).map(|t| t[1] - t[0]).collect();
                let first = from - before;
                let earlier: Vec<f64> = recording.times[first..=from].windows(2).map(|t| t[1] - t[0]).collect();
                let x = recording.states.slice(s![first..=from, ..]);
                let start = model.state_after(x, recording.inputs(first, from), &earlier, noise);
                let start = start.unwrap_or_else(|| recording.states.row(from).to_vec());
                let seen = recording.states.slice(s![from + 1..=to, ..]);
                let error = match model.simulate_at(&start, recording.inputs(from, to), &dt) {
                    Ok(ahead) => Some(&ahead.slice(s![1.., ..]) - &seen),
                    Err(AnalysisError::Diverged { .. }) => {
                        first_diverged.get_or_insert((number + 1, recording.times[from] - recording.times[0]));
                        None
                    }
                    Err(other) => return Err(other),
                };
                errors.push(error);
                samples.push(seen.to_owned());
            }
        }
        let diverged = errors.iter().filter(|e| e.is_none()).count();
        let named = |of: &dyn Fn(usize) -> Option<f64>| {
            let measured = |i: &usize| !unmeasured.contains(&model.states()[*i]);
            let finite = |i: usize| (model.states()[i].clone(), of(i).filter(|v| v.is_finite()));
            (0..n).filter(measured).map(finite).collect::<Vec<_>>()
        };
        let rmse = |i: usize| (diverged == 0).then(|| rms(errors.iter().flatten().flat_map(|e| e.column(i))));
        let deviation = |i: usize| {
            let all = || samples.iter().flat_map(|x| x.column(i));
            let mean = all().sum::<f64>() / all().count().max(1) as f64;
            rms(all().map(|v| v - mean).collect::<Vec<f64>>().iter())
        };
        Ok(Self {
            horizon,
            seconds: None,
            windows: errors.len(),
            diverged,
            first_diverged,
            fit_percent: named(&|i| Some(100.0 * (1.0 - rmse(i)? / deviation(i)))),
            rmse: named(&rmse),
            median_rmse: named(&|i| {
                let of = |e: &Option<Array2<f64>>| e.as_ref().map_or(f64::INFINITY, |e| rms(e.column(i).iter()));
                let mut each: Vec<f64> = errors.iter().map(of).collect();
                each.sort_by(f64::total_cmp);
                each.get(each.len() / 2).copied()
            }),
        })
    }
}

fn rms<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}
