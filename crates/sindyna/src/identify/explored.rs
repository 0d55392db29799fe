//! Readings of a log tried in the order in which equations found so far speak for them.

use std::cell::RefCell;

use sindyna_core::{FitError, InterSample};

use super::gradual::{between_rows, lagged, refined, searched, started};
use super::lag::forgotten;
use super::reading::Reading;
use super::trial::{Structure, TOLD_APART, Trial, Tried};

/// Readings that are tried, at most.
const MOST: usize = 5;

/// Times as many steps tell a delay of a part of a row, or a lag, that was tried.
const MORE: usize = 5;

/// What may be tried.
pub(super) struct Open {
    pub(super) readings: Vec<Reading>,
    /// Whether delays of parts of rows may be, and lags.
    pub(super) parts: bool,
    pub(super) lags: bool,
}

/// What was tried with the least score per step: lags are tried on fewer of them.
fn least(all: &[Tried]) -> Option<&Tried> {
    let per_step = |tried: &Tried| tried.score / tried.steps().max(1) as f64;
    all.iter().min_by(|a, b| per_step(a).total_cmp(&per_step(b)))
}

/// How readings are explored.
pub(super) struct Explorer<'a, E> {
    /// How whole readings are searched, in so many steps.
    trial: &'a Trial<'a, E>,
    steps: usize,
    /// The same behind the steps in which a lag forgets.
    behind: Trial<'a, E>,
    /// Equations found in the whole log as it stands.
    first: Option<Structure<'a>>,
    open: Open,
    /// What leaves noise alone without any of these readings, and by how much less than it others must miss, per number of steps.
    otherwise: Option<&'a Tried>,
    bars: Memo<usize, f64>,
    /// What equations miss with readings, and which that change gradually they miss least with, as far as somebody asked.
    misfits: Memo<(Asking, Reading), f64>,
    gradual: Memo<(Asking, Reading, bool), (Reading, f64)>,
}

/// Values that were computed, beside what they depend on.
type Memo<K, V> = RefCell<Vec<(K, V)>>;

/// Which equations are asked: those found with one reading, or in the whole log as it stands; and in how many steps.
type Asking = (Option<Reading>, usize);

/// Equations that may speak for readings.
struct Speaker<'a> {
    of: Structure<'a>,
    asking: Asking,
    /// Whether they may for such as change gradually.
    gradually: bool,
}

/// The value of `known` for `key`; if it has none, that of `of`, which is kept.
fn once<K: PartialEq + Copy, V: Copy, E>(
    known: &Memo<K, V>,
    key: K,
    of: impl FnOnce() -> Result<V, E>,
) -> Result<V, E> {
    let before = known.borrow().iter().find(|(asked, _)| *asked == key).map(|(_, value)| *value);
    if let Some(value) = before {
        return Ok(value);
    }
    let value = of()?;
    known.borrow_mut().push((key, value));
    Ok(value)
}

impl<'a, E: From<FitError>> Explorer<'a, E> {
    /// That of the readings in `open` with so many steps as `trial` takes them; `first` are equations that were found in the whole log as it stands.
    pub(super) fn new(trial: &'a Trial<'a, E>, steps: usize, first: Option<Structure<'a>>, open: Open) -> Self {
        let (before, after) = trial.margins;
        let latest = open.readings.iter().map(|reading| reading.rows).fold(1.0, f64::max);
        let more = if open.lags { forgotten(&trial.kept.data, latest * trial.log.spec.dt) } else { 0 };
        let behind = Trial { margins: (before + more, after), ..*trial };
        Self {
            trial,
            steps,
            behind,
            first,
            open,
            otherwise: None,
            bars: RefCell::default(),
            misfits: RefCell::default(),
            gradual: RefCell::default(),
        }
    }

    /// The same, of readings with which equations miss less than what was found `otherwise` is worth with its terms, if that leaves noise alone.
    pub(super) fn less_than(self, otherwise: Option<&'a Tried>) -> Self {
        Self { otherwise: otherwise.filter(|tried| tried.explained), ..self }
    }

    /// What readings must miss less than in so many steps to be tried: what those equations that need none of them miss, and what their terms cost.
    fn bar(&self, steps: usize) -> Result<f64, E> {
        let Some(tried) = self.otherwise else { return Ok(f64::INFINITY) };
        once(&self.bars, steps, || {
            let of = Structure { model: &tried.found.model, rates: &tried.rates };
            let price = tried.score - self.trial.misfit(of, tried.reading, self.steps)?;
            Ok(self.behind.misfit(of, tried.reading, steps)? + price.max(0.0))
        })
    }

    /// Adds to `all` what is found with one reading after the other, as long as equations found so far speak for another one: fitted again they miss less of the log that is read so than as it was read yet.
    pub(super) fn explore(
        &mut self,
        all: &mut Vec<Tried>,
        search: &impl Fn(&Trial<'_, E>, Reading) -> Result<Option<Tried>, E>,
    ) -> Result<(), E> {
        let mut is_searched = false;
        for _ in 0..MOST {
            let next = match self.most_promising(all)? {
                Some(next) => next,
                None => {
                    let lagged = least(all).filter(|best| best.reading.lag > 0.0 && !best.explained && !is_searched);
                    let Some(from) = lagged.map(|lagged| lagged.reading) else { break };
                    is_searched = true;
                    // Wrong terms make up for a wrong lag, and keep it: others are searched with terms of their own.
                    all.extend(self.near_lag(from, search)?);
                    continue;
                }
            };
            self.open.readings.retain(|reading| *reading != next);
            let trial = if next.lag > 0.0 { &self.behind } else { self.trial };
            (trial.asked.say)(&format!("trying {next}"));
            all.extend(search(trial, next)?);
        }
        Ok(())
    }

    /// Whether the equations found in the whole log speak for another reading than that as it stands.
    pub(super) fn is_promising(&self) -> Result<bool, E> {
        Ok(self.most_promising(&[])?.is_some())
    }

    /// The lag, of those tried in `all`, that explains everything, unless what explains it without one does so too on the same steps.
    pub(super) fn lagged(
        &self,
        all: &[Tried],
        search: &impl Fn(&Trial<'_, E>, Reading) -> Result<Option<Tried>, E>,
    ) -> Result<Option<Tried>, E> {
        let explain = |lags: bool| {
            let explains = |tried: &&Tried| tried.explained && (tried.reading.lag > 0.0) == lags;
            all.iter().filter(explains).min_by(|a, b| a.score.total_cmp(&b.score))
        };
        let Some(lagged) = explain(true) else { return Ok(None) };
        let again = explain(false).map(|other| search(&self.behind, other.reading)).transpose()?.flatten();
        let is_as_good = |other: &Tried| {
            let is_likely = other.score < lagged.score + TOLD_APART;
            other.explained && (other.astray() < lagged.astray() || (other.astray() == lagged.astray() && is_likely))
        };
        Ok(if again.as_ref().is_some_and(is_as_good) { None } else { Some(lagged.clone()) })
    }

    /// The reading of `best`, as its equations tell it from all steps.
    pub(super) fn refined(&self, best: &Tried) -> Result<Reading, E> {
        let of = Structure { model: &best.found.model, rates: &best.rates };
        if best.reading.is_gradual() { refined(&self.behind, of, best.reading) } else { Ok(best.reading) }
    }

    /// The reading for which equations speak most, of those that were not tried; `None` if they speak for none.
    fn most_promising(&self, all: &[Tried]) -> Result<Option<Reading>, E> {
        if all.is_empty() && self.first.is_none() {
            // Nothing is found of the log as it stands.
            return Ok(self.open.readings.first().copied());
        }
        for speaker in self.speakers(all) {
            let promises = self.promises(&speaker, all)?;
            let most = promises.into_iter().filter(|of| of.1 > TOLD_APART).max_by(|a, b| a.1.total_cmp(&b.1));
            match most.map(|most| most.0) {
                // What was delivered before matters where little else is left.
                Some(reading) if all.iter().any(|tried| tried.reading.lag > 0.0) && reading.lag > 0.0 => {
                    return started(self.trial, speaker.asking.1, speaker.of, reading).map(Some);
                }
                Some(reading) => return Ok(Some(reading)),
                None => {}
            }
        }
        Ok(None)
    }

    /// Equations that may speak for readings: the best ones, and unless these explain all those found in the whole log as it stands, and the last ones.
    fn speakers<'b>(&self, all: &'b [Tried]) -> Vec<Speaker<'b>>
    where
        'a: 'b,
    {
        let of = |tried: &'b Tried| {
            let steps = if tried.reading.is_gradual() { MORE * self.steps } else { self.steps };
            let open = tried.spoilt || tried.astray() > 0 || tried.reading.is_gradual();
            let of = Structure { model: &tried.found.model, rates: &tried.rates };
            Speaker { of, asking: (Some(tried.reading), steps), gradually: open }
        };
        let best = least(all);
        if let Some(explained) = best.filter(|best| best.explained) {
            return vec![of(explained)];
        }
        let first = self.first.map(|of| Speaker { of, asking: (None, self.steps), gradually: true });
        let last = all.last().filter(|last| best.is_some_and(|best| best.reading != last.reading));
        let is_given = best.is_none_or(|best| best.reading == Reading::GIVEN);
        let best = best.map(of);
        let (one, other) = if is_given { (first, best) } else { (best, first) };
        one.into_iter().chain(other).chain(last.map(of)).collect()
    }

    /// How much less than with the best reading in `all` equations miss with others that were not tried.
    fn promises(&self, speaker: &Speaker<'_>, all: &[Tried]) -> Result<Vec<(Reading, f64)>, E> {
        let Speaker { of, asking, gradually } = *speaker;
        let steps = asking.1;
        let misfit = |reading: Reading| {
            let misfit = once(&self.misfits, (asking, reading), || self.behind.misfit(of, reading, steps))?;
            Ok::<_, E>((reading, misfit))
        };
        let given = std::iter::once(Reading::GIVEN).chain(all.iter().map(|tried| tried.reading));
        let known = given.map(misfit).collect::<Result<Vec<_>, E>>()?;
        let mut others = self.open.readings.iter().copied().map(misfit).collect::<Result<Vec<_>, E>>()?;
        let most = |a: &&(Reading, f64), b: &&(Reading, f64)| a.1.total_cmp(&b.1);
        let best_of = |between: InterSample| {
            let acts = |of: &&(Reading, f64)| {
                of.0.between == between && !of.0.simulated && of.0.rows >= 0.0 && of.1.is_finite()
            };
            known.iter().chain(&others).filter(acts).min_by(most).map(|from| from.0).filter(|_| gradually)
        };
        let late = [InterSample::Zoh, InterSample::Foh, InterSample::Bl].map(best_of);
        let held = late[0].filter(|_| self.open.lags);
        for from in late.into_iter().flatten().filter(|from| self.open.parts && from.lag == 0.0) {
            let near = || between_rows(&self.behind, steps, of, from);
            let (reading, misfit) = once(&self.gradual, (asking, from, false), near)?;
            // A part of a row is one parameter more than a whole delay.
            let price = if reading.is_gradual() { (steps as f64).ln() } else { 0.0 };
            others.push((reading, misfit + price));
        }
        if let Some(from) = held {
            let near = || lagged(&self.behind, steps, of, from);
            others.push(once(&self.gradual, (asking, from, true), near)?);
        }
        // What was tried may not have kept what was promised.
        let best = least(all).map_or(Reading::GIVEN, |best| best.reading);
        let known = known.iter().find(|of| of.0 == best).map_or(f64::INFINITY, |of| of.1);
        let bar = self.bar(steps)?;
        let is_new = |of: &(Reading, f64)| of.1 < bar && all.iter().all(|tried| tried.reading != of.0);
        Ok(others.into_iter().filter(is_new).map(|(reading, misfit)| (reading, known - misfit)).collect())
    }

    /// What is found with lags near that of `from`, until one explains all.
    fn near_lag(
        &self,
        from: Reading,
        search: &impl Fn(&Trial<'_, E>, Reading) -> Result<Option<Tried>, E>,
    ) -> Result<Option<Tried>, E> {
        let mut explained: Option<Tried> = None;
        searched(&self.behind, self.steps, from, |lag| {
            if explained.is_some() {
                // What explains all ends the search.
                return Ok(f64::INFINITY);
            }
            let other = search(&self.behind, Reading { lag, ..from })?;
            let score = other.as_ref().map_or(f64::INFINITY, |other| other.score);
            explained = other.filter(|other| other.explained);
            Ok(score)
        })?;
        Ok(explained)
    }
}
