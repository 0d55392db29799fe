//! States that may be angles, as their names or units say.

use sindyna_core::{Certainty, FitError};
use sindyna_sindy::Disturbances;

use super::ahead::clearly_least;
use super::asked::Asked;
use super::reading::Reading;
use super::trial::{STEPS, TOLD_APART, Trial, Tried};
use super::unmeasured::Unmeasured;
use crate::logs::Log;

/// `log` with the states that may be angles as angles, if equations are adequate for a part of it so, or explain that better than others, or nothing explains it and they
/// predict the rest no worse: what names and units say counts where the data do not contradict it. `log` otherwise: who turns little may as well be on a spring.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn with_angles_by_name<E: From<FitError>>(log: Log, asked: &Asked<'_, E>) -> Result<Log, E> {
    let Some(turned) = log.turned() else { return Ok(log) };
    let kept = (asked.kept)(&log)?;
    let tried = |log: &Log| {
        let rates = if matches!(asked.unmeasured, Unmeasured::Given(_)) { asked.unmeasured } else { &Unmeasured::None };
        Trial { log, kept: &kept, rates, asked, margins: (0, 0), disturbances: Disturbances::Possible }
            .of(Reading::GIVEN, STEPS)
    };
    let Some(named) = tried(&turned)? else { return Ok(log) };
    let prefers =
        named.certainty() >= Certainty::Adequate || tried(&log)?.is_none_or(|given| is_better(&named, &given));
    Ok(if prefers { turned } else { log })
}

/// Whether angles are to be preferred.
fn is_better(named: &Tried, given: &Tried) -> bool {
    match (named.explained, given.explained) {
        (true, true) => named.score + TOLD_APART < given.score,
        (false, false) => clearly_least(&[&given.missed, &named.missed]) != Some(0),
        (named, _) => named,
    }
}
