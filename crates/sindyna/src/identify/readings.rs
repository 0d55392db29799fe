//! How a log may be read besides as it says: inputs that act earlier or later, or change between rows, and steps of a simulator.

use sindyna_core::{FitError, InterSample, Spec};
use sindyna_sindy::Identified;

use super::ahead::{clearly_least, missed};
use super::as_read::{as_read, is_spoilt};
use super::asked::{Asked, Delay};
use super::delay::shifted;
use super::unmeasured::{Order, Unmeasured, lone, with_rates_of};
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

/// Steps by which they are told apart, at most, and the part of the usual effort for each.
const STEPS: usize = 300;
const EFFORT: f64 = 0.1;

/// Steps after these that are predicted, at most.
const AHEAD: usize = 900;

/// Difference of scores at odds of twenty to one.
const TOLD_APART: f64 = 6.0;

/// Readings of `log`: those that are always tried, and delays near those after which states follow inputs most.
fn tried(log: &Log) -> Vec<Reading> {
    let mut all = TRIED.to_vec();
    for rows in log.delays().into_iter().flat_map(|rows| [rows, rows - 1.0, rows + 1.0]) {
        if !all.iter().any(|reading| !reading.linear && (reading.rows - rows).abs() < 0.5) {
            all.push(Reading { rows, linear: false, simulated: false });
        }
    }
    all
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
    let mut all: Vec<Tried> = Vec::new();
    let readings: Vec<Reading> = tried(log).into_iter().filter(is_open).collect();
    let margins = margins(&readings);
    for &reading in &readings {
        let data = shifted(&kept.data, reading.rows, margins, STEPS + AHEAD)?;
        let data = if reading.linear { data.with_intersample(InterSample::Foh) } else { data };
        let samples = Samples { data: data.first(STEPS), times: None };
        let of =
            |spec: &Spec| Ok::<_, E>((asked.identifier)(spec)?.with_effort(EFFORT).with_simulators(reading.simulated));
        // Of a state whose rate was not measured nothing is found without it.
        let plain = of(&log.spec)?;
        let first = match &rates {
            Unmeasured::Given(_) => None,
            _ => as_read(&plain, &samples, asked.watch).ok(),
        };
        let choice = (first.as_ref(), &rates);
        let with = with_rates_of(log, &samples, choice, of, (asked.watch, &|_| {}), Order::Second);
        if !asked.watch.go_on() {
            return Err(FitError::Interrupted.into());
        }
        let with = with.ok().flatten().map(|(found, identifier, _)| (found, identifier));
        let Some((found, identifier)) = with.or_else(|| Some((first?, plain))) else { continue };
        let Some(score) = found.report.score else { continue };
        let tried = Tried {
            reading,
            score,
            spoilt: is_spoilt(&found),
            astray: found.report.rows_astray,
            missed: missed(&found.model, &identifier, &data, STEPS),
        };
        let settled = all.is_empty() && !tried.spoilt;
        all.push(tried);
        if settled {
            break;
        }
    }
    Ok(best_of(&all, readings.len()))
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
