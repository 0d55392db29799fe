//! How a log may be read besides as it says: inputs that act earlier or later, or change between rows, and steps of a simulator.

use sindyna_core::{FitError, InterSample};
use sindyna_sindy::{Disturbances, Identified};

use super::ahead::clearly_least;
use super::as_pieces::least_missed;
use super::as_read::{is_disturbed, is_explained};
use super::asked::{Asked, Delay, Lag};
use super::between::is_set;
use super::explored::{Explorer, Open};
use super::reading::Reading;
use super::trial::{STEPS, Structure, TOLD_APART, Trial, Tried};
use super::unmeasured::{Unmeasured, lone};
use crate::logs::{Log, Samples};

/// What a part of a log speaks for.
pub(super) struct Chosen {
    pub(super) reading: Reading,
    /// Rates that were not measured, as (name, state), with which equations leave nothing to explain.
    pub(super) rates: Vec<(String, String)>,
    /// States that are angles, though neither names nor units say so.
    pub(super) angles: Vec<String>,
    /// Whether equations of pieces speak for it, and it leaves more than noise of a part too.
    pub(super) disturbed: bool,
}

/// Steps with which equations of the whole log speak for other readings, at most.
const ALL_STEPS: usize = 1200;

/// What is tried of every log with inputs, besides longer delays.
const TRIED: [Reading; 6] = [
    Reading { rows: -1.0, ..Reading::GIVEN },
    Reading { between: InterSample::Foh, ..Reading::GIVEN },
    Reading { between: InterSample::Bl, ..Reading::GIVEN },
    Reading { rows: 1.0, ..Reading::GIVEN },
    Reading { rows: 2.0, ..Reading::GIVEN },
    Reading { simulated: true, ..Reading::GIVEN },
];

/// Readings of `log` besides that as it stands: what is tried of every log with inputs, delays near those after which states follow inputs most, and all delays with inputs that are linear between rows.
fn tried(log: &Log) -> Vec<Reading> {
    if log.spec.control_dim() == 0 {
        return Vec::new();
    }
    let mut tried = TRIED.to_vec();
    for rows in log.delays().into_iter().flat_map(|rows| [rows, rows - 1.0, rows + 1.0]) {
        let is_known = |reading: &Reading| reading.between.is_held() && (reading.rows - rows).abs() < 0.5;
        if !is_known(&Reading::GIVEN) && !tried.iter().any(is_known) {
            tried.push(Reading { rows, ..Reading::GIVEN });
        }
    }
    let late: Vec<Reading> = tried.iter().filter(|reading| reading.rows > 0.0).copied().collect();
    for between in [InterSample::Foh, InterSample::Bl] {
        tried.extend(late.iter().map(|reading| Reading { between, ..*reading }));
    }
    tried
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
    (first, given): (Option<&Identified>, Option<&Identified>),
    asked: &Asked<'_, E>,
) -> Result<Option<Chosen>, E> {
    let rates = match first {
        Some(first) => lone(first, &log.spec, asked.unmeasured),
        None => asked.unmeasured.clone(),
    };
    let is_set = is_set(kept);
    let is_open = |reading: &Reading| {
        let late = asked.delay == Delay::Auto || reading.rows == 0.0;
        let is_even = kept.times.is_none() || reading.between != InterSample::Bl;
        let linear = reading.between.is_held() || (asked.intersample.is_none() && !is_set && is_even);
        let steps = kept.times.is_none() && matches!(rates, Unmeasured::Given(_)) && asked.delay == Delay::Auto;
        late && linear && (!reading.simulated || steps)
    };
    let others: Vec<Reading> = tried(log).into_iter().filter(is_open).collect();
    let lags = asked.lag == Lag::Auto && log.spec.control_dim() > 0 && kept.data.intersample().is_held();
    if others.is_empty() && !lags {
        return Ok(None);
    }
    let parts = asked.delay == Delay::Auto && kept.times.is_none();
    let with_parts = |(before, after)| if parts { (before + 1, after + 1) } else { (before, after) };
    let disturbed = first.filter(|first| is_disturbed(first));
    let others: Vec<Reading> = others.into_iter().filter(|reading| disturbed.is_none() || !reading.simulated).collect();
    let disturbances = if disturbed.is_some() { Disturbances::None } else { Disturbances::Possible };
    let trial = Trial { log, kept, rates: &rates, asked, margins: with_parts(margins(&others)), disturbances };
    // Equations of pieces follow no more than these.
    let pairs = if let Unmeasured::Given(pairs) = asked.unmeasured { &pairs[..] } else { &[] };
    let as_given = given.map(|found| Structure { model: &found.model, rates: pairs });
    let as_read = first.filter(|first| !is_disturbed(first));
    let structure = as_given.or(as_read.map(|found| Structure { model: &found.model, rates: &[] }));
    // What acts gradually late is seldom told in long logs of machines, and equations with friction are slow to follow.
    let gradually = disturbed.is_none() || kept.data.n_steps() <= ALL_STEPS;
    let open = || Open { readings: others.clone(), parts: parts && gradually, lags: lags && gradually };
    // Equations that leave noise alone, in a search that was not finished, may have terms that make up for another reading: it would leave less of them.
    let explained = given.or(first.filter(|first| is_explained(first)));
    if explained.is_some() && !Explorer::new(&trial, ALL_STEPS, structure, open()).is_promising()? {
        return Ok(None);
    }
    let why = if explained.is_some() {
        "another reading may leave less to explain"
    } else {
        "no term explains the residuals"
    };
    (asked.say)(&format!("{why}: trying other readings of the log (delays and lags of the inputs, first-order hold)"));
    // As in all samples, the log as it stands must leave what no term explains: few samples may not show it.
    let (steps, given) = until_spoilt(kept, |steps| trial.first(Reading::GIVEN, steps))?;
    let mut all: Vec<Tried> = given.into_iter().collect();
    let search = |trial: &Trial<'_, E>, reading: Reading| trial.first(reading, steps);
    // Rates that were not measured explain what inputs that act otherwise do only by more terms; what these do not explain better is not looked for.
    let are_open = disturbed.is_none() && !matches!(asked.unmeasured, Unmeasured::Given(_));
    let with = if are_open { trial.with_rates(Reading::GIVEN, steps, all.first().cloned())? } else { None };
    let with_rates = with.as_ref().filter(|tried| !tried.rates.is_empty());
    let spoilt = with_rates.filter(|tried| tried.spoilt);
    // Beside measured rates those of rates make up for inputs that act late, and angles help them to.
    let of_positions = with_rates.filter(|_| matches!(rates, Unmeasured::Given(_)));
    let as_it_stands = of_positions.or(all.first()).filter(|tried| tried.spoilt);
    if let Some((turned, angles)) = as_it_stands.map(|tried| trial.with_angles(tried, steps)).transpose()?.flatten() {
        return Ok(Some(Chosen { reading: Reading::GIVEN, rates: turned.rates, angles, disturbed: false }));
    }
    let longer = spoilt.map(|tried| trial.with_rates_of_rates(tried, steps)).transpose()?.flatten();
    let otherwise = longer.as_ref().or(with_rates);
    let mut explorer = Explorer::new(&trial, steps, structure, open()).less_than(otherwise);
    explorer.explore(&mut all, &search)?;
    if let Some(lagged) = explorer.lagged(&all, &search)? {
        let reading = explorer.refined(&lagged)?;
        return Ok(Some(Chosen { reading, rates: Vec::new(), angles: Vec::new(), disturbed: false }));
    }
    // Those of other samples are not compared.
    all.retain(|tried| tried.reading.lag == 0.0);
    if let Some(first) = disturbed {
        // As it stands nothing explains it.
        if let Some(tried) = all.iter().rev().find(|tried| tried.reading != Reading::GIVEN && tried.explained) {
            return Ok(Some(Chosen {
                reading: tried.reading,
                rates: Vec::new(),
                angles: Vec::new(),
                disturbed: false,
            }));
        }
        // Pieces do not tell how inputs change between rows, once these are late.
        let told: Vec<Reading> = others.iter().filter(|of| of.between.is_held() || of.rows == 0.0).copied().collect();
        let best = least_missed(log, kept, first, (&told, margins(&told)), asked)?;
        return Ok(best.map(|reading| Chosen { reading, rates: Vec::new(), angles: Vec::new(), disturbed: true }));
    }
    if are_open {
        let search = |trial: &Trial<'_, E>, reading: Reading| {
            let without = all.iter().find(|tried| tried.reading == reading).cloned();
            trial.with_rates(reading, steps, without)
        };
        let mut with = Vec::from_iter(with.clone());
        // Where all that was found without them leaves more than noise, with other readings too.
        if all.iter().all(|tried| tried.spoilt) {
            let mut explorer = Explorer::new(&trial, steps, None, open()).less_than(longer.as_ref());
            explorer.explore(&mut with, &search)?;
            if let Some(lagged) = explorer.lagged(&with, &search)? {
                let reading = explorer.refined(&lagged)?;
                return Ok(Some(Chosen { reading, rates: lagged.rates, angles: Vec::new(), disturbed: false }));
            }
        }
        with.retain(|tried| !tried.rates.is_empty() && tried.reading.lag == 0.0);
        all.extend(with);
        all.extend(longer.clone());
    }
    // Whatever a longer search may find.
    let seen = |best: &Tried| if best.explained { best.rates.clone() } else { Vec::new() };
    let Some(best) = best_of(&all, others.len() + 1) else { return Ok(None) };
    Ok(Some(Chosen { reading: explorer.refined(best)?, rates: seen(best), angles: Vec::new(), disturbed: false }))
}

/// What is found in so many of the first steps of `kept` that it leaves more than noise, or in all.
fn until_spoilt<E>(
    kept: &Samples,
    of: impl Fn(usize) -> Result<Option<Tried>, E>,
) -> Result<(usize, Option<Tried>), E> {
    let mut steps = STEPS;
    let mut found = of(steps)?;
    while steps < kept.data.n_steps() && found.as_ref().is_some_and(Tried::is_settled) {
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
