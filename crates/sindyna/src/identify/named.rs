//! Angles by name: what a part of a log tells of them before all of it is searched.

use sindyna_core::{Certainty, FitError};
use sindyna_sindy::Noise;

use super::as_read::as_read;
use super::asked::Asked;
use super::unmeasured::Unmeasured;
use crate::logs::Log;

/// Steps that tell, and the part of the usual effort that finds what explains them to rounding.
const STEPS: usize = 300;
const EFFORT: f64 = 0.02;

/// `log` with the states that may be angles as angles, if equations explain a part of it up to rounding errors so, and none do as it stands; `log` otherwise.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn with_angles_that_explain<E: From<FitError>>(log: Log, asked: &Asked<'_, E>) -> Result<Log, E> {
    let Some(turned) = log.turned().filter(|_| !matches!(asked.unmeasured, Unmeasured::Given(_))) else {
        return Ok(log);
    };
    let explains = |log: &Log| -> Result<bool, E> {
        let part = (asked.kept)(log)?.first(STEPS);
        let identifier = (asked.identifier)(&log.spec)?.with_effort(EFFORT);
        match as_read(&identifier, &part, asked.watch) {
            Err(FitError::Interrupted) => Err(FitError::Interrupted.into()),
            found => Ok(found.is_ok_and(|f| f.report.noise == Noise::Rounding && f.certainty() > Certainty::Doubted)),
        }
    };
    Ok(if !explains(&log)? && explains(&turned)? { turned } else { log })
}
