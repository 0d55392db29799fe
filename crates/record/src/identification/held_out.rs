//! Predictions of samples that the equations were not fitted to.

use serde::{Deserialize, Serialize};
use sindyna_sindy::{AnalysisError, Model, Recording};

/// How well a model predicts samples that it was not fitted to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Steps that were predicted.
    pub steps: usize,
    /// Why there are no more predictions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// One for each horizon.
    pub predictions: Vec<FreeRun>,
}

/// 100 (1 − NRMSE) of each state, predicted so many steps ahead; from the first sample where there is no number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FreeRun {
    /// Steps ahead; `null` for a free run from the first sample.
    pub horizon: Option<usize>,
    /// Per state that was measured: 100 (1 − NRMSE), `null` where the state never changes.
    pub fit_percent: Vec<(String, Option<f64>)>,
}

/// Steps ahead that are predicted; `None` is all the way from the first.
const HORIZONS: [Option<usize>; 3] = [Some(1), Some(10), None];

impl HeldOut {
    /// How well `model` predicts `recordings` that it was not fitted to; of states that were `unmeasured` there is nothing to compare with.
    #[must_use]
    pub fn of(model: &Model, recordings: &[Recording], unmeasured: &[String]) -> Self {
        let of = |horizon: &Option<usize>| {
            let fit = model.compare(recordings, *horizon)?;
            let percent = fit.iter().map(|f| Some(100.0 * f).filter(|f| f.is_finite()));
            let all = model.states().iter().cloned().zip(percent);
            let fit_percent = all.filter(|(state, _)| !unmeasured.contains(state)).collect();
            Ok::<_, AnalysisError>(FreeRun { horizon: *horizon, fit_percent })
        };
        let (predictions, failed): (Vec<_>, Vec<_>) = HORIZONS.iter().map(of).partition(Result::is_ok);
        Self {
            steps: recordings.iter().map(|r| r.controls.nrows()).sum(),
            predictions: predictions.into_iter().flatten().collect(),
            failed: failed.into_iter().filter_map(Result::err).map(|e| e.to_string()).next(),
        }
    }
}
