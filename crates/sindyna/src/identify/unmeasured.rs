//! Logs of positions alone: rates that were not measured, found with the equations.

use ndarray::{Array2, Axis, concatenate};
use sindyna_core::{Certainty, Channel, Dataset, FitError, Kind, Spec};
use sindyna_sindy::{EquationReport, Identified, Identifier, LONGEST_CHAIN, Recording, Watch};

use crate::logs::{Log, Note, Samples};

/// Which states have a rate that was not measured.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Unmeasured {
    /// Those whose equations leave a doubt, if the data speak for it.
    #[default]
    Auto,
    /// None.
    None,
    /// These, as (name of the rate, state).
    Given(Vec<(String, String)>),
}

/// Equations in which rates that were not measured are states.
#[derive(Clone)]
pub(super) struct Rates {
    pub(super) found: Identified,
    pub(super) identifier: Identifier,
    /// The log with these rates as columns, as the equations and the states that were measured tell them.
    pub(super) log: Log,
}

/// Of which samples of a log rates are to explain what is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Of {
    /// Of the first ones: one rate of each state, which all samples are to confirm.
    Part,
    /// Of all: what these rates do not explain those of the rates may.
    All,
}

/// What speaks for rates that were not measured.
#[derive(Clone, Copy)]
pub(super) struct Choice<'a> {
    /// What was found without them.
    pub(super) first: Option<&'a Identified>,
    pub(super) asked: &'a Unmeasured,
    /// Those, as (name of the rate, state), that leave nothing to explain in a part of the log.
    pub(super) seen: &'a [(String, String)],
}

/// Part of the effort of the search before.
const LESS: f64 = 0.6;

/// Who may end a search, and who is told what is tried.
type Following<'a> = (&'a Watch<'a>, &'a dyn Fn(&str));

/// Equations of the system of `log` with rates that were not measured, found in `kept` of it, if `choice` says so or they are better than what was found
/// without. `identifier` makes one for a system.
///
/// # Errors
/// [`FitError::Interrupted`] if whoever watches said so; any other error only where rates were given.
pub(super) fn with_rates<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    choice: Choice<'_>,
    identifier: impl Fn(&Spec) -> Result<Identifier, E>,
    following: Following<'_>,
) -> Result<Option<Rates>, E> {
    let best = with_rates_of(log, kept, choice, identifier, following, Of::All)?;
    let Some(Enlarged { found, identifier, spec, rates }) = best else { return Ok(None) };
    let filled = identifier.filled(&found.model, &hidden(&log.data, log.times.as_deref(), &log.spec, &rates))?;
    let data = Recording::dataset(&filled, &spec)?;
    let spec = with_scales(spec, &filled, &rates);
    let mut notes = log.notes.clone();
    for (rate, of) in rates {
        let of = spec.state[of].name.clone();
        let given = matches!(choice.asked, Unmeasured::Given(_));
        notes.push(Note::Unmeasured { rate, of, given });
    }
    let log = Log { spec, data, notes, ..log.clone() };
    Ok(Some(Rates { found, identifier, log }))
}

/// Equations alone, of a system in which rates that were not measured are states.
pub(super) struct Enlarged {
    pub(super) found: Identified,
    pub(super) identifier: Identifier,
    spec: Spec,
    /// These rates, as (name, number of the state).
    pub(super) rates: Vec<(String, usize)>,
}

/// The same equations alone.
pub(super) fn with_rates_of<E: From<FitError>>(
    log: &Log,
    kept: &Samples,
    Choice { first, asked, seen }: Choice<'_>,
    identifier: impl Fn(&Spec) -> Result<Identifier, E>,
    (watch, say): Following<'_>,
    samples: Of,
) -> Result<Option<Enlarged>, E> {
    let mut rates = match (asked, first) {
        (Unmeasured::Given(pairs), _) => given(pairs, &log.spec)?,
        (Unmeasured::Auto, _) if !seen.is_empty() => given(seen, &log.spec)?,
        (Unmeasured::Auto, Some(first)) => suggested(first, &log.spec, samples),
        _ => Vec::new(),
    };
    let mut best: Option<Enlarged> = None;
    while !rates.is_empty() {
        let before = best.as_ref().map(|best| &best.found).or(first);
        let spec = enlarged(&log.spec, &rates);
        let names: Vec<&str> = rates.iter().map(|r| r.0.as_str()).collect();
        say(&format!("trying {} as unmeasured", names.join(" and ")));
        let identifier = identifier(&spec)?;
        // Where the states as measured were searched first there is less left.
        let searches = usize::from(first.is_some()) + usize::from(best.is_some());
        let identifier = identifier.with_less_effort(LESS.powi(searches as i32));
        let recordings = hidden(&kept.data, kept.times.as_deref(), &log.spec, &rates);
        let found = match identifier.identify_recordings_watched(&recordings, watch) {
            Err(FitError::Interrupted) => return Err(FitError::Interrupted.into()),
            Err(_) if first.is_some() => break,
            found => found?,
        };
        if before.is_some_and(|before| !is_better(&found, before)) {
            break;
        }
        let goes_on = *asked == Unmeasured::Auto && samples == Of::All;
        let more = if goes_on { suggested(&found, &spec, samples) } else { Vec::new() };
        best = Some(Enlarged { found, identifier, spec, rates: rates.clone() });
        if more.is_empty() {
            break;
        }
        rates.extend(more);
    }
    Ok(best)
}

/// `choice`, or where that is open and `first` leaves what no term explains of states whose rates were not measured, these rates.
pub(super) fn lone(first: &Identified, spec: &Spec, choice: &Unmeasured) -> Unmeasured {
    let is_rate = |i: usize| matches!(spec.state[i].kind, Kind::RateOf(_));
    let rates: Vec<(String, usize)> =
        suggested(first, spec, Of::Part).into_iter().filter(|(_, of)| !is_rate(*of)).collect();
    if *choice != Unmeasured::Auto || rates.is_empty() {
        return choice.clone();
    }
    Unmeasured::Given(rates.into_iter().map(|(rate, of)| (rate, spec.state[of].name.clone())).collect())
}

/// The rates `pairs`, and those of them of which the equations `found` with them leave what no term explains; `None` if there are none of these.
pub(super) fn longer(
    found: &Identified,
    spec: &Spec,
    pairs: &[(String, String)],
) -> Result<Option<Vec<(String, String)>>, FitError> {
    let (spec, _) = with_rates_in(spec, pairs)?;
    let more = suggested(found, &spec, Of::Part);
    let named = more.iter().map(|(rate, of)| (rate.clone(), spec.state[*of].name.clone()));
    Ok((!more.is_empty()).then(|| pairs.iter().cloned().chain(named).collect()))
}

/// The rates of the states whose equations leave what a state that was not measured may explain, in chains that are not too long.
fn suggested(found: &Identified, spec: &Spec, samples: Of) -> Vec<(String, usize)> {
    let has_rate = |i: usize| spec.state.iter().any(|s| s.kind == Kind::RateOf(i));
    let shown = |i: usize| spec.observation.iter().any(|o| o.name == spec.state[i].name);
    let length = |i: usize| {
        let before = |&i: &usize| if let Kind::RateOf(of) = spec.state[i].kind { Some(of) } else { None };
        std::iter::successors(Some(i), before).take(LONGEST_CHAIN + 1).count()
    };
    // That a search of all samples was not finished is no reason for rates of rates; that of a part seldom is.
    let longest = if samples == Of::Part || found.report.search_complete { LONGEST_CHAIN } else { 2 };
    let spoilt = |i: usize| found.report.equations.get(i).is_some_and(EquationReport::is_spoilt);
    let open = |i: &usize| !has_rate(*i) && shown(*i) && length(*i) < longest && spoilt(*i);
    let mut names: Vec<String> = spec.state.iter().chain(&spec.control).map(|c| c.name.clone()).collect();
    let mut rates = Vec::new();
    // States of which nothing but themselves was measured before rates that were.
    let shortest = (0..spec.state_dim()).filter(open).map(length).min();
    for i in (0..spec.state_dim()).filter(open).filter(|&i| Some(length(i)) == shortest) {
        let name = &spec.state[i].name;
        let mut rate = name.strip_suffix("_dot").map_or_else(|| format!("{name}_dot"), |stem| format!("{stem}_ddot"));
        while names.contains(&rate) {
            rate += "_";
        }
        names.push(rate.clone());
        rates.push((rate, i));
    }
    rates
}

/// The given pairs (rate, state). A rate that is a state of `spec` was measured in a way that is not to be believed.
fn given(pairs: &[(String, String)], spec: &Spec) -> Result<Vec<(String, usize)>, FitError> {
    let failed = |reason: String| FitError::Regression { reason };
    let mut rates: Vec<(String, usize)> = Vec::new();
    for (rate, of) in pairs {
        let shown = spec.state.iter().filter(|s| spec.observation.iter().any(|o| o.name == s.name));
        let taken = spec.control.iter().chain(&spec.observation).chain(&spec.state);
        let is_state = shown.clone().any(|s| s.name == *rate);
        if !is_state && taken.map(|c| &c.name).chain(rates.iter().map(|r| &r.0)).any(|name| name == rate) {
            return Err(failed(format!("`{rate}` is a column of the log, but no state")));
        }
        let names = spec.state.iter().map(|s| &s.name);
        let more = rates.iter().map(|r| &r.0).filter(|name| spec.state.iter().all(|s| s.name != **name));
        let state = names.chain(more).position(|name| name == of);
        let state = state.ok_or_else(|| failed(format!("no state named `{of}`, of which `{rate}` is the rate")))?;
        let has_other = spec.state.iter().any(|s| s.kind == Kind::RateOf(state) && s.name != *rate);
        if has_other || rates.iter().any(|r| r.1 == state) {
            return Err(failed(format!("`{of}` already has a rate; `{rate}` cannot be another one")));
        }
        if spec.state.get(state).is_some_and(|s| s.name == *rate) {
            return Err(failed(format!("`{rate}` cannot be its own rate")));
        }
        rates.push((rate.clone(), state));
    }
    if rates.len() >= spec.state_dim() && rates.iter().all(|(rate, _)| spec.state.iter().any(|s| s.name == *rate)) {
        return Err(failed("no state was measured".into()));
    }
    Ok(rates)
}

/// `spec` with a state for each of the rates `pairs`, and these by number.
pub(super) fn with_rates_in(spec: &Spec, pairs: &[(String, String)]) -> Result<(Spec, Vec<(String, usize)>), FitError> {
    let rates = if pairs.is_empty() { Vec::new() } else { given(pairs, spec)? };
    Ok((enlarged(spec, &rates), rates))
}

/// `spec` with a state for every rate.
fn enlarged(spec: &Spec, rates: &[(String, usize)]) -> Spec {
    let mut spec = spec.clone();
    for (name, of) in rates {
        let is_there = |channel: &&mut Channel| channel.name == *name;
        let unit = &spec.state[*of].unit;
        let unit = if unit.is_empty() { String::new() } else { format!("{unit}/s") };
        let channel = Channel::new(name, &unit, Kind::RateOf(*of), 1.0);
        for channels in [&mut spec.state, &mut spec.observation] {
            match channels.iter_mut().find(is_there) {
                Some(there) => there.kind = Kind::RateOf(*of),
                None => channels.push(channel.clone()),
            }
        }
    }
    spec
}

/// `spec` whose `rates` reach as far as they do in `recordings`.
fn with_scales(mut spec: Spec, recordings: &[Recording], rates: &[(String, usize)]) -> Spec {
    for (name, _) in rates {
        let Some(o) = spec.observation.iter().position(|o| o.name == *name) else { continue };
        let values = recordings.iter().flat_map(|r| r.states.column(o).to_vec());
        let reach = values.fold(0.0, |m: f64, v| m.max(v.abs())).max(f64::MIN_POSITIVE);
        // Where noise is declared, scales of observations are its deviations; a rate that was not measured has no sensor.
        spec.observation[o].prior.scale = if spec.noise > 0.0 { 0.0 } else { reach };
        spec.state.iter_mut().filter(|s| s.name == *name).for_each(|s| s.prior.scale = reach);
    }
    spec
}

/// The trajectories of `data`, the samples of a system `spec`, of which `rates` were not measured: in more columns, unless they are states of it.
pub(super) fn hidden(
    data: &Dataset,
    times: Option<&[Vec<f64>]>,
    spec: &Spec,
    rates: &[(String, usize)],
) -> Vec<Recording> {
    let columns: Vec<Option<usize>> =
        rates.iter().map(|(rate, _)| spec.observation.iter().position(|o| o.name == *rate)).collect();
    let count = columns.iter().filter(|column| column.is_none()).count();
    let recording = |(at, rollout): (usize, sindyna_core::Rollout<'_>)| {
        let rows = rollout.observations.nrows();
        let mut states = concatenate![Axis(1), rollout.observations, Array2::from_elem((rows, count), f64::NAN)];
        columns.iter().flatten().for_each(|&column| states.column_mut(column).fill(f64::NAN));
        let even =
            Recording::even(data.dt(), states, Some(rollout.controls.to_owned())).with_intersample(data.intersample());
        match times.and_then(|all| all.get(at)) {
            Some(times) => Recording { times: times.clone(), ..even },
            None => even,
        }
    };
    data.rollouts().enumerate().map(recording).collect()
}

/// Whether `found`, with rates that were not measured, is better than `first` without: by the score where both have one, as both speak of the same samples.
pub(super) fn is_better(found: &Identified, first: &Identified) -> bool {
    match (found.report.score, first.report.score) {
        (Some(found), Some(first)) => found < first,
        _ => found.certainty() > first.certainty() || first.certainty() == Certainty::Doubted,
    }
}
