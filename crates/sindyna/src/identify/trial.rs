//! What is found in the first samples of a log that is read in one way.

use sindyna_core::{Certainty, FitError, Spec};
use sindyna_sindy::{Disturbances, Identified, Identifier, Model, Recording, Refitted};

use super::ahead::missed;
use super::as_read::{as_read, is_explained, is_spoilt, recordings_of};
use super::asked::Asked;
use super::reading::Reading;
use super::turnable::{angles_of, told, turning};
use super::unmeasured::{Choice, Enlarged, Of, Unmeasured, hidden, is_better, longer, with_rates_in, with_rates_of};
use crate::logs::{Log, Samples};

/// Part of the usual effort for each reading.
pub(super) const EFFORT: f64 = 0.1;

/// Steps by which readings are told apart, or four times as many where these are too few.
pub(super) const STEPS: usize = 300;

/// Difference of scores at odds of twenty to one.
pub(super) const TOLD_APART: f64 = 6.0;

/// Steps after those used that are predicted, at most.
const AHEAD: usize = 900;

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
        let first = match self.asked.unmeasured {
            Unmeasured::Given(_) => None,
            _ => self.without_rates(reading, steps)?,
        };
        match first {
            Some(first) if !first.spoilt => Ok(Some(first)),
            first => self.with_rates(reading, steps, first),
        }
    }

    /// The same with rates that were not measured only where they were given: what explains the log without more states comes first.
    pub(super) fn first(&self, reading: Reading, steps: usize) -> Result<Option<Tried>, E> {
        match self.asked.unmeasured {
            Unmeasured::Given(_) => self.of(reading, steps),
            _ => self.without_rates(reading, steps),
        }
    }

    /// What is found without rates that were not measured.
    pub(super) fn without_rates(&self, reading: Reading, steps: usize) -> Result<Option<Tried>, E> {
        let shifted = reading.samples(self.kept, self.margins, steps + AHEAD)?;
        let identifier = self.identifier(reading, &self.log.spec)?;
        let found = as_read(&identifier, &shifted.first(steps), self.asked.watch).ok();
        if !self.asked.watch.go_on() {
            return Err(FitError::Interrupted.into());
        }
        let of = &self.log.spec;
        Ok(found.and_then(|found| tried(reading, found, (of, Vec::new()), (&identifier, &shifted, steps))))
    }

    /// What is found with rates that were not measured, where that is better than the `first`, found without them.
    pub(super) fn with_rates(&self, reading: Reading, steps: usize, first: Option<Tried>) -> Result<Option<Tried>, E> {
        let Self { log, kept, rates, asked, margins, .. } = *self;
        let shifted = reading.samples(kept, margins, steps + AHEAD)?;
        // Rates that the whole log speaks for are taken without asking.
        let found = first.as_ref().map(|first| &first.found);
        let before = found.filter(|_| !matches!(rates, Unmeasured::Given(_)));
        let choice = Choice { first: before, asked: rates, seen: &[] };
        let of = |spec: &Spec| self.identifier(reading, spec);
        let with = with_rates_of(log, &shifted.first(steps), choice, of, (asked.watch, &|_| {}), Of::Part);
        if !asked.watch.go_on() {
            return Err(FitError::Interrupted.into());
        }
        let better = with.ok().flatten().filter(|with| found.is_none_or(|first| is_better(&with.found, first)));
        Ok(match better {
            Some(Enlarged { found, identifier, rates, .. }) => {
                tried(reading, found, (&log.spec, rates), (&identifier, &shifted, steps))
            }
            None => first,
        })
    }

    /// What is found with the rates of `before`, and those of them of which that leaves what no term explains; `None` if nothing is, or it is no better.
    pub(super) fn with_rates_of_rates(&self, before: &Tried, steps: usize) -> Result<Option<Tried>, E> {
        let Some(rates) = longer(&before.found, &self.log.spec, &before.rates)? else { return Ok(None) };
        let rates = Unmeasured::Given(rates);
        let longer = Trial { rates: &rates, ..*self }.with_rates(before.reading, steps, None)?;
        Ok(longer.filter(|longer| is_better(&longer.found, &before.found)))
    }

    /// What is found with the rates of `before` and states as angles that could be, where that explains so many steps and they told apart from those without; and which.
    pub(super) fn with_angles(&self, before: &Tried, steps: usize) -> Result<Option<(Tried, Vec<String>)>, E> {
        let (spec, _) = with_rates_in(&self.log.spec, &before.rates)?;
        for names in turning(self.log, &spec, &before.found) {
            (self.asked.say)(&told(&names));
            let log = self.log.with_angles(&names, false);
            let rates = Unmeasured::Given(before.rates.clone());
            let trial = Trial { log: &log, rates: &rates, ..*self };
            let turned = match before.rates[..] {
                [] => trial.without_rates(before.reading, steps)?,
                _ => trial.with_rates(before.reading, steps, None)?,
            };
            let is_better = |turned: &Tried| turned.explained && turned.score + TOLD_APART < before.score;
            if let Some(found) = turned.filter(is_better) {
                let names = angles_of(names, &spec, &found.found.model);
                return Ok((!names.is_empty()).then_some((found, names)));
            }
        }
        Ok(None)
    }

    /// How far so many steps with `reading` miss the equations `of`, whose coefficients are fitted to them, as −2 ln L; infinite if they do not follow these.
    pub(super) fn misfit(&self, of: Structure<'_>, reading: Reading, steps: usize) -> Result<f64, E> {
        let (identifier, recordings) = self.recordings(of, reading, steps)?;
        let misfit = identifier.misfit(of.model, &recordings, self.asked.watch)?;
        if self.asked.watch.go_on() { Ok(misfit.unwrap_or(f64::INFINITY)) } else { Err(FitError::Interrupted.into()) }
    }

    /// The equations `of` with coefficients fitted to so many steps with `reading`; `None` if they do not follow these.
    pub(super) fn refitted(&self, of: Structure<'_>, reading: Reading, steps: usize) -> Result<Option<Refitted>, E> {
        let (identifier, recordings) = self.recordings(of, reading, steps)?;
        let again = identifier.refitted(of.model, &recordings, self.asked.watch)?;
        if self.asked.watch.go_on() { Ok(again) } else { Err(FitError::Interrupted.into()) }
    }

    /// So many steps with `reading` as equations `of` such rates are fitted to them.
    fn recordings(&self, of: Structure<'_>, reading: Reading, steps: usize) -> Result<(Identifier, Vec<Recording>), E> {
        let samples = reading.samples(self.kept, self.margins, steps)?;
        let (spec, rates) = with_rates_in(&self.log.spec, of.rates)?;
        let recordings = match &rates[..] {
            [] => recordings_of(&samples),
            rates => hidden(&samples.data, samples.times.as_deref(), &self.log.spec, rates),
        };
        Ok(((self.asked.identifier)(&spec)?.with_simulators(reading.simulated), recordings))
    }

    fn identifier(&self, reading: Reading, spec: &Spec) -> Result<Identifier, E> {
        let identifier = (self.asked.identifier)(spec)?.with_effort(EFFORT).with_disturbances(self.disturbances);
        Ok(identifier.with_simulators(reading.simulated))
    }
}

/// What was `found` with `reading` and such `rates` of the system `of` in the first `steps` of `shifted`; `None` if it has no score.
fn tried(
    reading: Reading,
    found: Identified,
    (of, rates): (&Spec, Vec<(String, usize)>),
    (identifier, shifted, steps): (&Identifier, &Samples, usize),
) -> Option<Tried> {
    Some(Tried {
        reading,
        score: found.report.score?,
        spoilt: is_spoilt(&found),
        explained: is_explained(&found),
        missed: missed((&found.model, identifier), (shifted, steps), (of, &rates)),
        rates: rates.into_iter().map(|(rate, of)| (rate, identifier.spec().state[of].name.clone())).collect(),
        found,
    })
}

/// Equations whose coefficients are free.
#[derive(Clone, Copy)]
pub(super) struct Structure<'a> {
    pub(super) model: &'a Model,
    /// Rates that were not measured, as (name, state).
    pub(super) rates: &'a [(String, String)],
}

/// What was found with one reading.
#[derive(Clone)]
pub(super) struct Tried {
    pub(super) reading: Reading,
    /// Rates that were not measured, as (name, state).
    pub(super) rates: Vec<(String, String)>,
    pub(super) score: f64,
    /// Whether it leaves what no term explains, or the search ended early.
    pub(super) spoilt: bool,
    /// Whether it leaves noise alone, whatever a longer search may find.
    pub(super) explained: bool,
    pub(super) found: Identified,
    /// What its predictions of later samples miss, per window.
    pub(super) missed: Vec<f64>,
}

impl Tried {
    /// How far its equations are to be believed.
    pub(super) fn certainty(&self) -> Certainty {
        self.found.certainty()
    }

    /// Whether it leaves nothing that another reading may explain.
    pub(super) fn is_settled(&self) -> bool {
        !self.spoilt && self.astray() == 0
    }

    /// Steps of which its score tells.
    pub(super) fn steps(&self) -> usize {
        self.found.report.rows + self.astray()
    }

    /// Steps left out.
    pub(super) fn astray(&self) -> usize {
        self.found.report.rows_astray
    }
}
