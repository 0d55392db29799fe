//! How well a model predicts the samples it was fitted to, in the measures of system identification.

use serde::{Deserialize, Serialize};

use super::{PredictionRow, PredictionTable};

/// Predictions of one state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StateQuality {
    /// The state with its unit.
    pub state: String,
    /// Each sample from the one before it.
    pub one_step: Quality,
    /// From the first sample of each trajectory; `null` where the model cannot be simulated so far.
    pub free_run: Option<Quality>,
}

/// Predictions ŷ beside samples y.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Samples that were predicted.
    pub samples: usize,
    /// Root of the mean of (y − ŷ)².
    pub rmse: f64,
    /// 1 − ‖y − ŷ‖² / ‖y − mean y‖²; `null` where y never changes.
    pub r2: Option<f64>,
    /// 100 (1 − ‖y − ŷ‖ / ‖y − mean y‖), the NRMSE as a goodness of fit; `null` where y never changes.
    pub fit_percent: Option<f64>,
}

impl Quality {
    /// Of `pairs` of a sample and its prediction; `None` without any, or where a number is not finite.
    #[must_use]
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let count = pairs.len() as f64;
        let mean = pairs.iter().map(|(y, _)| y).sum::<f64>() / count;
        let missed: f64 = pairs.iter().map(|(y, predicted)| (y - predicted).powi(2)).sum();
        let spread: f64 = pairs.iter().map(|(y, _)| (y - mean).powi(2)).sum();
        let ratio = Some(missed / spread).filter(|ratio| ratio.is_finite() && spread > 0.0);
        (!pairs.is_empty() && missed.is_finite()).then(|| Self {
            samples: pairs.len(),
            rmse: (missed / count).sqrt(),
            r2: ratio.map(|ratio| 1.0 - ratio),
            fit_percent: ratio.map(|ratio| 100.0 * (1.0 - ratio.sqrt())),
        })
    }
}

impl PredictionTable {
    /// How well each state is predicted, those left out that are `unmeasured`.
    #[must_use]
    pub fn quality(&self, unmeasured: &[String]) -> Vec<StateQuality> {
        let of = |i: usize, predicted: fn(&PredictionRow) -> &[f64], from: usize| {
            let rows = self.rows.iter().filter(|row| row.sample >= from);
            let pairs = rows.filter_map(|row| Some((*row.states.get(i)?, *predicted(row).get(i)?)));
            Quality::of(&pairs.collect::<Vec<_>>())
        };
        let quality = |(i, state): (usize, &String)| {
            // The first sample of a trajectory is where its free run begins, and no prediction.
            let one_step = of(i, |row| &row.one_step, 1)?;
            Some(StateQuality { state: state.clone(), one_step, free_run: of(i, |row| &row.free_run, 1) })
        };
        let measured = |(_, state): &(usize, &String)| {
            let name = state.rsplit_once(" [").map_or(state.as_str(), |(name, _)| name);
            !unmeasured.iter().any(|unmeasured| unmeasured == name)
        };
        self.states.iter().enumerate().filter(measured).filter_map(quality).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_are_those_of_their_definitions() {
        // Errors 1, −1, 1, −1 about y = 0, 10, 20, 30 with mean 15 and ‖y − 15‖² = 500.
        let pairs = [(0.0, -1.0), (10.0, 11.0), (20.0, 19.0), (30.0, 31.0)];
        let found = Quality::of(&pairs).expect("there are samples");
        assert_eq!((found.samples, found.rmse), (4, 1.0));
        assert!((found.r2.expect("y changes") - (1.0 - 4.0 / 500.0)).abs() < 1e-15);
        let fit = 100.0 * (1.0 - (4.0_f64 / 500.0).sqrt());
        assert!((found.fit_percent.expect("y changes") - fit).abs() < 1e-12);
    }

    #[test]
    fn a_perfect_prediction_has_100_percent_and_the_mean_has_none() {
        let of = |predicted: [f64; 3]| {
            let pairs: Vec<(f64, f64)> = [1.0, 2.0, 6.0].into_iter().zip(predicted).collect();
            let found = Quality::of(&pairs).expect("there are samples");
            (found.r2, found.fit_percent)
        };
        assert_eq!(of([1.0, 2.0, 6.0]), (Some(1.0), Some(100.0)));
        assert_eq!(of([3.0; 3]), (Some(0.0), Some(0.0)));
        let constant = Quality::of(&[(2.0, 1.0), (2.0, 1.0)]).expect("there are samples");
        assert_eq!((constant.rmse, constant.r2, constant.fit_percent), (1.0, None, None));
        assert_eq!((Quality::of(&[]), Quality::of(&[(f64::NAN, 0.0)])), (None, None));
    }

    #[test]
    fn the_first_sample_of_a_trajectory_is_no_prediction_and_unmeasured_states_are_left_out() {
        let row = |sample: usize, y: f64, one: f64, free: f64| PredictionRow {
            sample,
            states: vec![y, 0.0],
            one_step: if sample == 0 { Vec::new() } else { vec![one, 0.0] },
            free_run: vec![free, 0.0],
            ..PredictionRow::default()
        };
        let rows = vec![row(0, 0.0, 0.0, 0.0), row(1, 1.0, 1.5, 1.5), row(2, 2.0, 2.5, 3.0)];
        let table = PredictionTable { states: vec!["x [m]".into(), "v [m/s]".into()], inputs: Vec::new(), rows };
        let found = table.quality(&["v".into()]);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].state.as_str(), found[0].one_step.samples, found[0].one_step.rmse), ("x [m]", 2, 0.5));
        let free = found[0].free_run.expect("there is one");
        assert!((free.rmse - (0.625_f64).sqrt()).abs() < 1e-15);
        assert_eq!(table.quality(&[]).len(), 2);
    }
}
