//! Logs with measured derivatives.

use ndarray::{Array2, Axis, concatenate, s};
use sindyna_core::{FitError, InterSample};
use sindyna_sindy::{Derived, Identified, Identifier, Model, Watch};

use super::ahead::{clearly_least, missed};
use crate::logs::Samples;

/// Equations that explain the measured derivatives of `samples` up to rounding errors; `None` if there are none, or no derivatives.
///
/// # Errors
/// [`FitError::Interrupted`] if `watch` said so.
pub(super) fn of_derivatives(
    identifier: &Identifier,
    samples: &Samples,
    watch: &Watch<'_>,
) -> Result<Option<Identified>, FitError> {
    let Some(derivatives) = &samples.derivatives else { return Ok(None) };
    // What the input was at the last sample of a trajectory is not known.
    let (n, k) = (samples.data.observation_dim(), samples.data.control_dim());
    let mut all = (Array2::zeros((0, n)), Array2::zeros((0, k)), Array2::zeros((0, n)));
    for (rollout, of) in samples.data.rollouts().zip(derivatives) {
        let steps = rollout.controls.nrows();
        all.0 = concatenate![Axis(0), all.0, rollout.observations.slice(s![..steps, ..])];
        all.1 = concatenate![Axis(0), all.1, rollout.controls];
        all.2 = concatenate![Axis(0), all.2, of.slice(s![..steps, ..])];
    }
    identifier.identify_derivatives(Derived { states: &all.0, controls: &all.1, derivatives: &all.2 }, watch)
}

/// Whether `model`, found in derivatives alone, predicts `samples` better where inputs are linear between them than where they are held.
pub(super) fn predicts_better_if_linear(model: &Model, identifier: &Identifier, samples: &Samples) -> bool {
    let held = missed((model, identifier), (samples, 0), (identifier.spec(), &[]));
    let data = samples.data.clone().with_intersample(InterSample::Foh);
    let linear = missed((model, identifier), (&Samples { data, ..samples.clone() }, 0), (identifier.spec(), &[]));
    clearly_least(&[&held, &linear]) == Some(1)
}
