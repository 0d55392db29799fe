//! What a log may be besides what it says: inputs that act earlier or later, rates that were not measured, steps of a simulator.

use sindyna_core::{FitError, Spec};
use sindyna_sindy::{EquationReport, Identified, Identifier, Watch};

use super::delay::{Delay, delayed, fits, told_apart};
use super::recordings;
use super::unmeasured::{Rates, Unmeasured, lone, with_rates};
use crate::logs::{Log, Samples};

/// What is asked about a log, and who is told.
pub(crate) struct Asked<'a, E> {
    pub(crate) unmeasured: &'a Unmeasured,
    pub(crate) delay: Delay,
    /// The part of a log that equations are found in.
    pub(crate) kept: &'a (dyn Fn(&Log) -> Result<Samples, E> + Sync),
    /// Makes an identifier for a system.
    pub(crate) identifier: &'a (dyn Fn(&Spec) -> Result<Identifier, E> + Sync),
    pub(crate) watch: &'a Watch<'a>,
    /// Is told what is tried.
    pub(crate) say: &'a (dyn Fn(&str) + Sync),
}

/// What was found in a log.
pub(crate) struct Looked {
    pub(crate) found: Identified,
    pub(crate) identifier: Identifier,
    /// The log as it was read in the end.
    pub(crate) log: Log,
}

/// Whether equations leave what none of their terms explains.
pub(super) fn is_spoilt(found: &Identified) -> bool {
    found.report.equations.iter().any(EquationReport::is_spoilt)
}

/// Equations of the system of `log`: as it was read, and where these leave what no term explains as it may be read too.
///
/// # Errors
/// [`FitError`] if no equations are found in the log as it was read, or as was asked.
pub(crate) fn looked<E: From<FitError>>(log: Log, asked: &Asked<'_, E>) -> Result<Looked, E> {
    let log = match asked.delay {
        Delay::Rows(rows) if rows != 0.0 => delayed(&log, rows)?,
        _ => log,
    };
    let kept = (asked.kept)(&log)?;
    let identifier = (asked.identifier)(&log.spec)?;
    let first = match asked.unmeasured {
        Unmeasured::Given(_) => None,
        _ => Some(as_read(&identifier, &kept, asked.watch)?),
    };
    // A search that was not finished says nothing of how the log is to be read, unless only positions were measured.
    let tells = |first: &Identified| {
        let has_lone = matches!(lone(first, &log.spec, asked.unmeasured), Unmeasured::Given(_));
        is_spoilt(first) && (first.report.search_complete || has_lone)
    };
    if let Some(found) = first.as_ref().filter(|first| !tells(first)) {
        return Ok(Looked { found: found.clone(), identifier, log });
    }
    // Steps of a simulator look like inputs that act earlier or later: they are told apart together.
    let chosen = match asked.delay {
        Delay::Auto if fits(&log, &kept) => told_apart(&log, &kept, first.as_ref(), asked)?,
        _ => None,
    };
    let (log, kept, first) = match chosen.map_or(0.0, |(rows, _)| rows) {
        0.0 => (log, kept, first),
        rows => {
            let log = delayed(&log, rows)?;
            let kept = (asked.kept)(&log)?;
            let first = first.map(|_| as_read(&identifier, &kept, asked.watch)).transpose()?;
            (log, kept, first)
        }
    };
    let simulated = chosen.is_none_or(|(_, simulated)| simulated);
    let of = |spec: &Spec| Ok::<_, E>((asked.identifier)(spec)?.with_simulators(simulated));
    let rates = with_rates(&log, &kept, (first.as_ref(), asked.unmeasured), of, (asked.watch, asked.say))?;
    match (rates, first) {
        (Some(Rates { found, identifier, log }), _) => Ok(Looked { found, identifier, log }),
        (None, Some(found)) => Ok(Looked { found, identifier, log }),
        (None, None) => Err(FitError::Regression { reason: "no rate was named".into() }.into()),
    }
}

/// Equations found in `kept` as it was read.
pub(super) fn as_read(identifier: &Identifier, kept: &Samples, watch: &Watch<'_>) -> Result<Identified, FitError> {
    match &kept.times {
        None => identifier.identify_watched(&kept.data, watch),
        Some(times) => identifier.identify_recordings_watched(&recordings(&kept.data, times), watch),
    }
}
