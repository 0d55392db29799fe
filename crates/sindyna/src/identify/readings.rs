//! How a log may be read besides as it says: inputs that act earlier or later, or change between rows, and steps of a simulator.

use sindyna_core::{FitError, InterSample, Spec};
use sindyna_sindy::Identified;

use super::ahead::{clearly_least, missed};
use super::as_read::{as_read, is_spoilt};
use super::asked::{Asked, Delay};
use super::delay::shifted;
use super::unmeasured::{Order, Unmeasured, is_better, lone, with_rates_of};
use crate::logs::{Log, Samples};

/// How a log may be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    /// Rows by which inputs act later.
    pub(super) rows: f64,
    /// Whether they are linear between rows.
    pub(super) linear: bool,
    /// Whether the samples are those of a simulator.
    pub(super) simulated: bool,
}

/// What is tried of every log.
const TRIED: [Reading; 6] = [
    Reading { rows: 0.0, linear: false, simulated: false },
    Reading { rows: -1.0, linear: false, simulated: false },
    Reading { rows: 0.0, linear: true, simulated: false },
    Reading { rows: 1.0, linear: false, simulated: false },
    Reading { rows: 2.0, linear: false, simulated: false },
    Reading { rows: 0.0, linear: false, simulated: true },
];

/// Steps by which they are told apart, or four times as many where these are too few, and the part of the usual effort for each.
const STEPS: usize = 300;
const EFFORT: f64 = 0.1;

/// Steps after these that are predicted, at most.
const AHEAD: usize = 900;

/// Difference of scores at odds of twenty to one.
const TOLD_APART: f64 = 6.0;

/// Rows of the longest delay that is always tried.
const NEAR: f64 = 2.0;

/// Readings of `log`, in groups: as it stands; longer delays, near those after which states follow inputs most; what is tried of every log, and other delays near those.
fn tried(log: &Log) -> [Vec<Reading>; 3] {
    let (mut far, mut near) = (Vec::new(), TRIED[1..].to_vec());
    for rows in log.delays().into_iter().flat_map(|rows| [rows, rows - 1.0, rows + 1.0]) {
        let is_known = |reading: &Reading| !reading.linear && (reading.rows - rows).abs() < 0.5;
        if ![&TRIED[..], &far, &near].concat().iter().any(is_known) {
            let group = if rows > NEAR { &mut far } else { &mut near };
            group.push(Reading { rows, linear: false, simulated: false });
        }
    }
    [vec![TRIED[0]], far, near]
}

/// Steps at the beginning and the end of a trajectory that are not used, since delays of some `readings` need them.
fn margins(readings: &[Reading]) -> (usize, usize) {
    let most = |sign: f64| readings.iter().map(|reading| sign * reading.rows).fold(0.0, f64::max).ceil() as usize;
    (most(1.0), most(-1.0))
}

/// Whether a delay of the inputs of `log` can be told from the samples `kept` of it: there are inputs, and samples at even times.
pub(super) fn fits(log: &Log, kept: &Samples) -> bool {
    kept.times.is_none() && log.spec.control_dim() > 0
}

/// The reading of `log` for which the samples `kept` of it speak, of those that were left open: the best of what is tried on a part of them, with rates that were not measured as was asked, or as `first`, found in all of them, leaves open. `None` where a part tells nothing.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so.
pub(super) fn told_apart<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    first: Option<&Identified>,
    asked: &Asked<'_, E>,
) -> Result<Option<Reading>, E> {
    (asked.say)(
        "no term explains the residuals: trying other delays of the inputs, first-order hold, and steps of a simulator",
    );
    let rates = match first {
        Some(first) => lone(first, &log.spec, asked.unmeasured),
        None => asked.unmeasured.clone(),
    };
    let is_open = |reading: &Reading| {
        let late = asked.delay == Delay::Auto || reading.rows == 0.0;
        let linear = asked.intersample.is_none() || !reading.linear;
        late && linear && (!reading.simulated || matches!(rates, Unmeasured::Given(_)) && asked.delay == Delay::Auto)
    };
    let groups = tried(log).map(|group| group.into_iter().filter(is_open).collect::<Vec<Reading>>());
    let readings = groups.concat();
    let trial = Trial { log, kept, rates: &rates, asked, margins: margins(&readings) };
    let available = kept.data.n_steps();
    let mut steps = STEPS;
    let mut all: Vec<Tried> = Vec::new();
    for group in groups {
        for reading in group {
            let mut tried = trial.of(reading, steps)?;
            // As in all samples, the log as it stands must leave what no term explains: few samples may not show it.
            while reading == TRIED[0] && steps < available && tried.as_ref().is_some_and(|tried| !tried.spoilt) {
                steps *= 4;
                tried = trial.of(reading, steps)?;
            }
            all.extend(tried);
        }
        // What leaves nothing to explain is compared with what is much like it, and with nothing else.
        if all.iter().any(|tried| !tried.spoilt) {
            break;
        }
    }
    Ok(best_of(&all, readings.len()))
}

/// How readings are tried on the first samples of a log.
struct Trial<'a, E> {
    log: &'a Log,
    kept: &'a Samples,
    rates: &'a Unmeasured,
    asked: &'a Asked<'a, E>,
    /// Steps at the beginning and the end of a trajectory that are not used.
    margins: (usize, usize),
}

impl<E: From<FitError>> Trial<'_, E> {
    /// What is found with `reading` in so many steps; `None` if nothing is.
    fn of(&self, reading: Reading, steps: usize) -> Result<Option<Tried>, E> {
        let Self { log, kept, rates, asked, margins } = *self;
        let data = shifted(&kept.data, reading.rows, margins, steps + AHEAD)?;
        let data = if reading.linear { data.with_intersample(InterSample::Foh) } else { data };
        let samples = Samples { data: data.first(steps), times: None };
        let of =
            |spec: &Spec| Ok::<_, E>((asked.identifier)(spec)?.with_effort(EFFORT).with_simulators(reading.simulated));
        let plain = of(&log.spec)?;
        let first = match asked.unmeasured {
            Unmeasured::Given(_) => None,
            _ => as_read(&plain, &samples, asked.watch).ok(),
        };
        let (found, identifier) = match first {
            Some(first) if !is_spoilt(&first) => (first, plain),
            first => {
                // Rates that the whole log speaks for are taken without asking.
                let before = first.as_ref().filter(|_| !matches!(rates, Unmeasured::Given(_)));
                let with = with_rates_of(log, &samples, (before, rates), of, (asked.watch, &|_| {}), Order::Second);
                let with = with.ok().flatten().map(|(found, identifier, _)| (found, identifier));
                let better = with.filter(|(with, _)| first.as_ref().is_none_or(|first| is_better(with, first)));
                let Some(best) = better.or_else(|| Some((first?, plain))) else { return Ok(None) };
                best
            }
        };
        if !asked.watch.go_on() {
            return Err(FitError::Interrupted.into());
        }
        let tried = |score: f64| Tried {
            reading,
            score,
            spoilt: is_spoilt(&found),
            astray: found.report.rows_astray,
            missed: missed(&found.model, &identifier, &data, steps),
        };
        Ok(found.report.score.map(tried))
    }
}

/// What was found with one reading.
struct Tried {
    reading: Reading,
    score: f64,
    /// Whether it leaves what no term explains.
    spoilt: bool,
    /// Steps left out.
    astray: usize,
    /// What its predictions of later samples miss, per window.
    missed: Vec<f64>,
}

/// The best of `count` readings, where one is told apart from those in `all`.
fn best_of(all: &[Tried], count: usize) -> Option<Reading> {
    let first = all.first()?;
    let told_apart = TOLD_APART + 2.0 * (count as f64).ln();
    // One that leaves out more steps is contradicted by them: where an input changes, and nowhere else, its delay shows.
    let mut best = first;
    let mut left_out = first.astray;
    for tried in all.iter().skip(1).filter(|tried| !tried.spoilt) {
        if tried.astray <= left_out {
            left_out = tried.astray;
            // Those tried first are the likelier ones before there are data.
            best = if tried.score + told_apart < best.score { tried } else { best };
        }
    }
    if !best.spoilt {
        return Some(best.reading);
    }
    // Of residuals that are not white the score counts each sample as if it told something of its own. What is predicted of other samples is not misled by that.
    let errors: Vec<&[f64]> = all.iter().map(|tried| &tried.missed[..]).collect();
    Some(clearly_least(&errors).map_or(first.reading, |best| all[best].reading))
}
