//! The time stamps of a log, in seconds: their column and unit, rows that are there twice, gaps.

use crate::clock::Gaps;
use crate::columns::refuse_unit;
use crate::recording::{Digits, Recording, Source, place};
use crate::time::{unit_in_header, unit_in_values};
use crate::{Clock, LogError, LogOptions, Note, TIME, TimeUnit, UnitBy, clock, states};

/// Part of a sampling interval that was given by which time stamps may differ from it; what their jitter explains comes on top.
const OTHER: f64 = 1e-3;

/// What time stamps tell: trajectories with times in seconds, parted at gaps, and to how many seconds the stamps were rounded.
pub(crate) struct Moments {
    pub(crate) recordings: Vec<Recording>,
    pub(crate) rounding: f64,
    pub(crate) gaps: Gaps,
}

/// What the time stamps of `recordings` tell; these are untouched where stamps are not looked at. What was decided is added to `notes`; states number `folded` are angles.
///
/// # Errors
/// [`LogError`] if there are no stamps and some are needed, they do not run forward, or they contradict the interval that was given.
pub(crate) fn told(
    mut recordings: Vec<Recording>,
    sources: &[Source<'_>],
    digits: &Digits,
    options: &LogOptions,
    folded: &[usize],
    notes: &mut Vec<Note>,
) -> Result<Moments, LogError> {
    let without = sources.iter().find(|s| s.columns.time.is_none());
    match (options.clock, without) {
        (Clock::Given(dt), without) => {
            if without.is_none() {
                let (unit, _) = unit(&recordings, sources, digits, options, folded)?;
                let (mean, slack) = clock::mean_step(&recordings);
                let (stamps, slack) = (mean * unit.seconds(), slack * unit.seconds());
                if stamps > 0.0 && (stamps - dt).abs() > OTHER * dt + slack {
                    return Err(LogError::OtherInterval { dt, stamps, column: sources[0].time_name().to_owned() });
                }
                notes.push(Note::TimeIgnored { dt });
            }
            return Ok(Moments { recordings, rounding: 0.0, gaps: Gaps::default() });
        }
        (Clock::Stamps, Some(source)) => return Err(LogError::NoTime { path: source.path().to_owned() }),
        (Clock::Resampled(_), Some(_)) => return Err(LogError::NoTimeToResample),
        (Clock::Stamps | Clock::Resampled(_), None) => {}
    }
    notes.extend(clock::forward(&mut recordings, sources)?);
    let (unit, by) = unit(&recordings, sources, digits, options, folded)?;
    let column = sources[0].time_name().to_owned();
    if column != TIME || unit != TimeUnit::Seconds || matches!(by, UnitBy::Epoch | UnitBy::Date) {
        notes.push(Note::Time { column, unit, by });
    }
    let seconds: Vec<Recording> = recordings.iter().map(|r| r.with_times_scaled(unit.seconds())).collect();
    let (parts, gaps) = clock::without_gaps(&seconds, options.gap);
    notes.extend(gaps.note(|gap| place(sources, gap.table, gap.line)));
    let digit = if digits.dates { TimeUnit::Seconds } else { unit }.seconds();
    let rounding = 10_f64.powi(-i32::try_from(digits.time_decimals).unwrap_or(i32::MAX)) * digit;
    Ok(Moments { recordings: parts, rounding, gaps })
}

/// The unit of the stamps, and what tells it.
fn unit(
    recordings: &[Recording],
    sources: &[Source<'_>],
    digits: &Digits,
    options: &LogOptions,
    folded: &[usize],
) -> Result<(TimeUnit, UnitBy), LogError> {
    if digits.dates {
        return Ok((TimeUnit::Nanoseconds, UnitBy::Date));
    }
    let header = sources[0].columns.time.map(|column| &sources[0].table.columns()[column]);
    if let Some(column) = header {
        let told = unit_in_header(column);
        if told.is_none() && !column.unit.is_empty() {
            return Err(refuse_unit(sources[0].table, column, "s, ms, us, ns, min or h"));
        }
        if let Some(unit) = told {
            return Ok((unit, UnitBy::Header));
        }
    }
    // Changes of states over gaps and turns say nothing of their rates.
    let (mut parts, _) = clock::without_gaps(recordings, None);
    states::unwrap(&mut parts, folded, &options.states);
    unit_in_values(&parts, digits.origin).map_err(|step| LogError::TimeUnit {
        path: sources[0].path().to_owned(),
        column: sources[0].time_name().to_owned(),
        step,
    })
}
