//! How a log may be read besides as it says: inputs that act earlier or later, or change between rows, and steps of a simulator.

use sindyna_core::FitError;
use sindyna_sindy::{Disturbances, Identified};

use super::ahead::clearly_least;
use super::as_pieces::{self, least_missed};
use super::as_read::is_disturbed;
use super::asked::{Asked, Delay, Lag};
use super::between::is_set;
use super::gradual::{between_rows, lagged, settled};
use super::reading::Reading;
use super::trial::{Trial, Tried};
use super::unmeasured::{Unmeasured, lone};
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

/// Steps by which they are told apart, or four times as many where these are too few.
pub(super) const STEPS: usize = 300;

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
    let is_set = is_set(kept);
    let is_open = |reading: &Reading| {
        let late = asked.delay == Delay::Auto || reading.rows == 0.0;
        let linear = !reading.linear || (asked.intersample.is_none() && !is_set);
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
    let is_given = matches!(asked.unmeasured, Unmeasured::Given(_));
    let parts = asked.delay == Delay::Auto && kept.times.is_none();
    let with_parts = |(before, after)| if parts { (before + 1, after + 1) } else { (before, after) };
    if let Some(first) = first.filter(|first| is_disturbed(first)) {
        let held: Vec<Reading> = others.into_iter().filter(|reading| !reading.simulated).collect();
        let best = least_missed(log, kept, first, (&held, margins(&held)), asked)?;
        let reading = best.unwrap_or(Reading::GIVEN);
        let trial = |reading| {
            let (margins, disturbances) = (with_parts(margins(&[reading])), Disturbances::None);
            Trial { log, kept, rates: &rates, asked, margins, disturbances }
        };
        let explains = |reading| {
            let trial = trial(reading);
            let (_, tried) = until_spoilt(kept, |steps| trial.first(reading, steps))?;
            Ok::<_, E>(tried.is_some_and(|tried| tried.explained))
        };
        let whole = |reading| Chosen { reading, rates: Vec::new(), disturbed: false };
        // Inputs that act when equations have them act may leave noise alone; so may those that act when states follow them, where the equations are wrong.
        // As it stands nothing does.
        if best.is_some() && explains(reading)? {
            return Ok(best.map(whole));
        }
        let delays = log.delays();
        let seen = |other: &&Reading| **other != reading && !other.linear && delays.contains(&other.rows);
        for &other in held.iter().filter(seen) {
            if explains(other)? {
                return Ok(Some(whole(other)));
            }
        }
        if parts {
            let margins = with_parts(margins(&[reading]));
            let between = as_pieces::between_rows(log, kept, first, (reading, margins), asked)?;
            let settled = if between == reading { None } else { settled(&trial(reading), STEPS, between)? };
            if let Some(settled) = settled.filter(|settled| settled.explained) {
                return Ok(Some(whole(settled.reading)));
            }
        }
        if asked.lag == Lag::Auto
            && let Some(tried) = trial(reading).first(reading, STEPS)?
            && let Some(lagged) = lagged(&trial(reading), STEPS, &tried)?
        {
            return Ok(Some(whole(lagged.reading)));
        }
        return Ok(best.map(|reading| Chosen { reading, rates: Vec::new(), disturbed: true }));
    }
    let (disturbances, margins) = (Disturbances::Possible, with_parts(margins(&others)));
    let trial = Trial { log, kept, rates: &rates, asked, margins, disturbances };
    // As in all samples, the log as it stands must leave what no term explains: few samples may not show it.
    let (steps, given) = until_spoilt(kept, |steps| trial.first(Reading::GIVEN, steps))?;
    let mut all: Vec<Tried> = given.into_iter().collect();
    for group in &groups {
        // What leaves nothing to explain is compared with what is much like it, and with nothing else.
        if all.iter().any(|tried| !tried.spoilt) {
            break;
        }
        for &reading in group {
            all.extend(trial.first(reading, steps)?);
        }
    }
    // Steps that are left out where inputs change say that they change elsewhere.
    if parts && all.iter().all(|tried| tried.spoilt || tried.astray() > 0) {
        let held = |tried: &&Tried| !tried.reading.linear && !tried.reading.simulated;
        let least = |within: f64| {
            let near = all.iter().filter(held).filter(|tried| tried.reading.rows.abs() <= within);
            near.min_by(|a, b| a.score.total_cmp(&b.score)).cloned()
        };
        // Many terms may make up for a delay that is far off.
        let (best, near) = (least(f64::INFINITY), least(NEAR));
        let is_other = near.as_ref().map(|near| near.reading) != best.as_ref().map(|best| best.reading);
        for tried in best.into_iter().chain(near.filter(|_| is_other)) {
            let between = between_rows(&trial, steps, &tried)?;
            let explains = between.as_ref().is_some_and(|between| between.explained);
            all.extend(between);
            if explains {
                break;
            }
        }
    }
    if asked.lag == Lag::Auto && all.iter().all(|tried| !tried.explained) {
        let late = |tried: &&Tried| !tried.reading.linear && !tried.reading.simulated && tried.reading.rows >= 0.0;
        let latest = all.iter().filter(late).min_by(|a, b| a.score.total_cmp(&b.score));
        if let Some(lagged) = latest.map(|tried| lagged(&trial, steps, tried)).transpose()?.flatten() {
            return Ok(Some(Chosen { reading: lagged.reading, rates: Vec::new(), disturbed: false }));
        }
    }
    if !is_given {
        let is_spoilt = all.iter().all(|tried| tried.spoilt);
        let without = |reading: Reading| all.iter().find(|tried| tried.reading == reading).cloned();
        let mut with = Vec::from_iter(trial.with_rates(Reading::GIVEN, steps, without(Reading::GIVEN))?);
        for group in groups.iter().filter(|_| is_spoilt) {
            if with.iter().any(|tried| !tried.spoilt) {
                break;
            }
            for &reading in group {
                with.extend(trial.with_rates(reading, steps, without(reading))?);
            }
        }
        all.extend(with.into_iter().filter(|tried| !tried.rates.is_empty()));
    }
    // Whatever a longer search may find.
    let seen = |best: &Tried| if best.explained { best.rates.clone() } else { Vec::new() };
    Ok(best_of(&all, others.len() + 1).map(|best| Chosen {
        reading: best.reading,
        rates: seen(best),
        disturbed: false,
    }))
}

/// What is found in so many of the first steps of `kept` that it leaves more than noise, or in all.
fn until_spoilt<E>(
    kept: &Samples,
    of: impl Fn(usize) -> Result<Option<Tried>, E>,
) -> Result<(usize, Option<Tried>), E> {
    let mut steps = STEPS;
    let mut found = of(steps)?;
    while steps < kept.data.n_steps() && found.as_ref().is_some_and(|found| !found.spoilt) {
        steps *= 4;
        found = of(steps)?;
    }
    Ok((steps, found))
}

/// The best of `count` readings, where one is told apart from those in `all`.
fn best_of(all: &[Tried], count: usize) -> Option<&Tried> {
    let first = all.first()?;
    let told_apart = TOLD_APART + 2.0 * (count as f64).ln();
    // One that leaves out more steps is contradicted by them: where an input changes, and nowhere else, its delay shows.
    let mut best = first;
    let mut left_out = first.astray();
    for tried in all.iter().skip(1).filter(|tried| tried.explained) {
        if tried.astray() <= left_out {
            left_out = tried.astray();
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
