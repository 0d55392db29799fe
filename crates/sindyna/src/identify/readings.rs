//! How a log may be read besides as it says: inputs that act earlier or later, or change between rows, and steps of a simulator.

use sindyna_core::{Certainty, FitError, Spec};
use sindyna_sindy::{Disturbances, Identified};

use super::ahead::{clearly_least, missed};
use super::as_pieces::least_missed;
use super::as_read::{as_read, is_disturbed, is_explained, is_spoilt};
use super::asked::{Asked, Delay};
use super::reading::Reading;
use super::unmeasured::{Choice, Order, Unmeasured, added, is_better, lone, with_rates_of};
use crate::logs::{Log, Samples};

/// What a part of a log speaks for.
pub(super) struct Chosen {
    pub(super) reading: Reading,
    /// Rates that were not measured, as (name, state), with which equations leave nothing to explain.
    pub(super) rates: Vec<(String, String)>,
    /// Whether equations of pieces speak for it, and it leaves more than noise of a part too.
    pub(super) disturbed: bool,
}

/// What is tried of every log with inputs, besides longer delays.
const TRIED: [Reading; 5] = [
    Reading { rows: -1.0, ..Reading::GIVEN },
    Reading { linear: true, ..Reading::GIVEN },
    Reading { rows: 1.0, ..Reading::GIVEN },
    Reading { rows: 2.0, ..Reading::GIVEN },
    Reading { simulated: true, ..Reading::GIVEN },
];

/// Steps by which they are told apart, or four times as many where these are too few, and the part of the usual effort for each.
pub(super) const STEPS: usize = 300;
const EFFORT: f64 = 0.1;

/// Steps after these that are predicted, at most.
const AHEAD: usize = 900;

/// Difference of scores at odds of twenty to one.
pub(super) const TOLD_APART: f64 = 6.0;

/// Rows of the longest delay that is always tried.
const NEAR: f64 = 2.0;

/// Readings of `log` besides that as it stands, in groups: longer delays, near those after which states follow inputs most; what is tried of every log with
/// inputs, and other delays near those.
fn tried(log: &Log) -> [Vec<Reading>; 2] {
    if log.spec.control_dim() == 0 {
        return [Vec::new(), Vec::new()];
    }
    let (mut far, mut near) = (Vec::new(), TRIED.to_vec());
    for rows in log.delays().into_iter().flat_map(|rows| [rows, rows - 1.0, rows + 1.0]) {
        let is_known = |reading: &Reading| !reading.linear && (reading.rows - rows).abs() < 0.5;
        if ![&[Reading::GIVEN], &far[..], &near].concat().iter().any(is_known) {
            let group = if rows > NEAR { &mut far } else { &mut near };
            group.push(Reading { rows, ..Reading::GIVEN });
        }
    }
    [far, near]
}

/// Steps at the beginning and the end of a trajectory that are not used, since delays of some `readings` need them.
fn margins(readings: &[Reading]) -> (usize, usize) {
    let most = |sign: f64| readings.iter().map(|reading| sign * reading.rows).fold(0.0, f64::max).ceil() as usize;
    (most(1.0), most(-1.0))
}

/// The reading of `log` for which the samples `kept` of it speak, of those that were left open: the best of what is tried on a part of them, with rates that were not
/// measured as was asked, or as `first`, found in all of them, leaves open. `None` if there is no other, or a part tells nothing.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn told_apart<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    first: Option<&Identified>,
    asked: &Asked<'_, E>,
) -> Result<Option<Chosen>, E> {
    let rates = match first {
        Some(first) => lone(first, &log.spec, asked.unmeasured),
        None => asked.unmeasured.clone(),
    };
    let is_open = |reading: &Reading| {
        let late = asked.delay == Delay::Auto || reading.rows == 0.0;
        let linear = asked.intersample.is_none() || !reading.linear;
        let steps = kept.times.is_none() && matches!(rates, Unmeasured::Given(_)) && asked.delay == Delay::Auto;
        late && linear && (!reading.simulated || steps)
    };
    let groups = tried(log).map(|group| group.into_iter().filter(is_open).collect::<Vec<Reading>>());
    let others = groups.concat();
    if others.is_empty() {
        return Ok(None);
    }
    (asked.say)(
        "no term explains the residuals: trying other readings of the log (delays of the inputs, first-order hold)",
    );
    if let Some(first) = first.filter(|first| is_disturbed(first)) {
        let held: Vec<Reading> = others.into_iter().filter(|reading| !reading.simulated).collect();
        let best = least_missed(log, kept, first, (&held, margins(&held)), asked)?;
        let Some(reading) = best else { return Ok(None) };
        // Inputs that act when equations have them act may leave noise alone.
        let margins = margins(&[reading]);
        let trial = Trial { log, kept, rates: &rates, asked, margins, disturbances: Disturbances::None };
        let explained = trial.of(reading, STEPS)?.is_some_and(|tried| tried.explained);
        return Ok(Some(Chosen { reading, rates: Vec::new(), disturbed: !explained }));
    }
    let disturbances = Disturbances::Possible;
    let trial = Trial { log, kept, rates: &rates, asked, margins: margins(&others), disturbances };
    // As in all samples, the log as it stands must leave what no term explains: few samples may not show it.
    let mut steps = STEPS;
    let mut given = trial.of(Reading::GIVEN, steps)?;
    while steps < kept.data.n_steps() && given.as_ref().is_some_and(|given| !given.spoilt) {
        steps *= 4;
        given = trial.of(Reading::GIVEN, steps)?;
    }
    let mut all: Vec<Tried> = given.into_iter().collect();
    for group in groups {
        // What leaves nothing to explain is compared with what is much like it, and with nothing else.
        if all.iter().any(|tried| !tried.spoilt) {
            break;
        }
        for reading in group {
            all.extend(trial.of(reading, steps)?);
        }
    }
    let seen = |best: &Tried| if best.spoilt { Vec::new() } else { best.rates.clone() };
    Ok(best_of(&all, others.len() + 1).map(|best| Chosen {
        reading: best.reading,
        rates: seen(best),
        disturbed: false,
    }))
}

/// How readings are tried on the first samples of a log.
pub(super) struct Trial<'a, E> {
    pub(super) log: &'a Log,
    pub(super) kept: &'a Samples,
    pub(super) rates: &'a Unmeasured,
    pub(super) asked: &'a Asked<'a, E>,
    /// Steps at the beginning and the end of a trajectory that are not used.
    pub(super) margins: (usize, usize),
    pub(super) disturbances: Disturbances,
}

impl<E: From<FitError>> Trial<'_, E> {
    /// What is found with `reading` in so many steps; `None` if nothing is.
    pub(super) fn of(&self, reading: Reading, steps: usize) -> Result<Option<Tried>, E> {
        let Self { log, kept, rates, asked, margins, disturbances } = *self;
        let shifted = reading.samples(kept, margins, steps + AHEAD)?;
        let samples = shifted.first(steps);
        let of = |spec: &Spec| {
            let identifier = (asked.identifier)(spec)?;
            let identifier = identifier.with_effort(EFFORT).with_disturbances(disturbances);
            Ok::<_, E>(identifier.with_simulators(reading.simulated))
        };
        let plain = of(&log.spec)?;
        let first = match asked.unmeasured {
            Unmeasured::Given(_) => None,
            _ => as_read(&plain, &samples, asked.watch).ok(),
        };
        let (found, identifier, rates) = match first {
            Some(first) if !is_spoilt(&first) => (first, plain, Vec::new()),
            first => {
                // Rates that the whole log speaks for are taken without asking.
                let before = first.as_ref().filter(|_| !matches!(rates, Unmeasured::Given(_)));
                let choice = Choice { first: before, asked: rates, seen: &[] };
                let with = with_rates_of(log, &samples, choice, of, (asked.watch, &|_| {}), Order::Second);
                if !asked.watch.go_on() {
                    return Err(FitError::Interrupted.into());
                }
                let with = with.ok().flatten().map(|(found, identifier, spec)| (found, identifier, added(log, &spec)));
                let better = with.filter(|(with, ..)| first.as_ref().is_none_or(|first| is_better(with, first)));
                let Some(best) = better.or_else(|| Some((first?, plain, Vec::new()))) else { return Ok(None) };
                best
            }
        };
        let tried = |score: f64| Tried {
            reading,
            rates: rates.clone(),
            score,
            spoilt: is_spoilt(&found),
            explained: is_explained(&found),
            certainty: found.certainty(),
            astray: found.report.rows_astray,
            missed: missed(&found.model, &identifier, &shifted, steps),
        };
        Ok(found.report.score.map(tried))
    }
}

/// What was found with one reading.
pub(super) struct Tried {
    reading: Reading,
    /// Rates that were not measured, as (name, state).
    rates: Vec<(String, String)>,
    pub(super) score: f64,
    /// Whether it leaves what no term explains, or the search ended early.
    spoilt: bool,
    /// Whether it leaves noise alone, whatever a longer search may find.
    pub(super) explained: bool,
    /// How far its equations are to be believed.
    pub(super) certainty: Certainty,
    /// Steps left out.
    astray: usize,
    /// What its predictions of later samples miss, per window.
    pub(super) missed: Vec<f64>,
}

/// The best of `count` readings, where one is told apart from those in `all`.
fn best_of(all: &[Tried], count: usize) -> Option<&Tried> {
    let first = all.first()?;
    let told_apart = TOLD_APART + 2.0 * (count as f64).ln();
    // One that leaves out more steps is contradicted by them: where an input changes, and nowhere else, its delay shows.
    let mut best = first;
    let mut left_out = first.astray;
    for tried in all.iter().skip(1).filter(|tried| tried.explained) {
        if tried.astray <= left_out {
            left_out = tried.astray;
            // Those tried first are the likelier ones before there are data.
            best = if tried.score + told_apart < best.score { tried } else { best };
        }
    }
    if best.explained {
        return Some(best);
    }
    // Of residuals that are not white the score counts each sample as if it told something of its own. What is predicted of other samples is not misled by that.
    let errors: Vec<&[f64]> = all.iter().map(|tried| &tried.missed[..]).collect();
    Some(clearly_least(&errors).map_or(first, |best| &all[best]))
}
