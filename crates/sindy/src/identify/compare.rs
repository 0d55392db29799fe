//! How well a model predicts recordings.

use ndarray::{Array2, s};

use super::Recording;
use crate::Model;
use crate::model::AnalysisError;

impl Model {
    /// The fit of each state (n), 1 − ‖x − x̂‖/‖x − mean x‖ over all samples but the first of each recording: 1 is perfect, 0 no better
    /// than the mean. Predictions x̂ are made `horizon` steps ahead; from the first sample of each recording without a horizon.
    /// NaN for a state that does not move.
    ///
    /// # Errors
    /// [`AnalysisError`] if the recordings do not fit the model, or it diverges.
    pub fn compare(&self, recordings: &[Recording], horizon: Option<usize>) -> Result<Vec<f64>, AnalysisError> {
        let n = self.states().len();
        let (mut missed, mut moved, mut sums, mut count) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], 0.0);
        let mut predictions: Vec<Array2<f64>> = Vec::new();
        for r in recordings {
            let steps = r.steps();
            let dt: Vec<f64> = r.times[..=steps].windows(2).map(|t| t[1] - t[0]).collect();
            predictions.push(self.predict(r.states.slice(s![..=steps, ..]), r.inputs(0, steps), &dt, horizon)?);
            for x in r.states.rows().into_iter().take(steps + 1).skip(1) {
                sums.iter_mut().zip(x).for_each(|(sum, v)| *sum += v);
                count += 1.0;
            }
        }
        for (r, predicted) in recordings.iter().zip(&predictions) {
            for (x, p) in r.states.rows().into_iter().zip(predicted.rows()).skip(1) {
                for i in 0..n {
                    missed[i] += (x[i] - p[i]).powi(2);
                    moved[i] += (x[i] - sums[i] / count).powi(2);
                }
            }
        }
        Ok(missed.iter().zip(&moved).map(|(a, b)| 1.0 - (a / b).sqrt()).collect())
    }
}
