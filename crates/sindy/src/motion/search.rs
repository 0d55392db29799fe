//! Which terms each equation has.

use sindyna_core::{Dynamics as _, Seed};

use super::choice::Choice;
use super::fitting::{ROUNDING, Terms};
use super::found::{Found, Search};
use super::stepping::{CLEAR, shown, substeps_shown};
use super::{Run, Stepping, System};
use crate::model::ModelError;
use crate::solve::{Selected, binomial};

/// Operations per size of an equation that are spent before anything is known: what explains clean data is mostly found
/// with few of them, and what does not is looked for again with all that the solver is allowed.
const ROUGHLY: u64 = 20_000;

/// Steps of a part that is looked at by itself; of fewer than two of them all are.
const PART: usize = 40;

/// Steps `first` to `last` of all runs, that one excluded.
fn runs_between(runs: &[Run], first: usize, last: usize) -> Vec<Run> {
    let mut begun = 0;
    let mut parts = Vec::new();
    for run in runs {
        let (from, to) = (first.max(begun) - begun, last.min(begun + run.len()).saturating_sub(begun));
        if from < to {
            parts.push(run.part(from, to));
        }
        begun += run.len();
    }
    parts
}

/// Where a search in continuous time begins.
const CONTINUOUS: Stepping = Stepping::Continuous { substeps: 1 };

impl Search<'_> {
    /// Equations that explain the data, if there are some that a short search finds.
    pub(super) fn exactly(&self) -> Option<Found> {
        let solver = self.solver.within(ROUGHLY);
        Search { solver: &solver, ..*self }.once().ok().filter(Found::explains)
    }

    /// Whether there are too few steps for parts.
    pub(crate) fn is_short(&self) -> bool {
        self.runs.iter().map(Run::len).sum::<usize>() <= 2 * PART
    }

    /// Equations that explain the data, with all that the solver is allowed where the steps are so few that nothing else can tell.
    pub(crate) fn exact(&self) -> Option<Found> {
        let found = self.exactly();
        if found.is_none() && self.is_short() { self.once().ok().filter(Found::explains) } else { found }
    }

    /// Steps in which terms are looked for that all steps judge: the first ones.
    pub(super) fn few(&self) -> Vec<Run> {
        runs_between(self.runs, 0, 2 * PART)
    }

    /// Equations in continuous time, of the first tier, that explain one part of the runs to rounding and have the terms to explain another too: data with
    /// noise, and laws that no terms can say, are told by a few of them. `None` of short runs.
    pub(crate) fn of_parts(&self) -> Option<Found> {
        if self.is_short() {
            return None;
        }
        let total: usize = self.runs.iter().map(Run::len).sum();
        let parts = [0, (total - PART) / 2, total - PART].map(|first| runs_between(self.runs, first, first + PART));
        let narrow = System { terms: &self.system.terms[..self.system.core], ..*self.system };
        let found = parts.iter().enumerate().find_map(|(at, part)| {
            let found = self.of_core(&narrow, part).exactly()?;
            parts.iter().enumerate().filter(|(other, _)| *other != at).find_map(|(_, other)| {
                let both: Vec<Run> = part.iter().chain(other).cloned().collect();
                self.of_core(&narrow, &both).with_terms_of(&found, &found.fits).filter(Found::explains)
            })
        });
        found.filter(|found| found.stepping.is_continuous())
    }

    fn of_core<'a>(&'a self, narrow: &'a System<'a>, runs: &'a [Run]) -> Search<'a> {
        Search { system: narrow, runs, ..*self }
    }

    /// `found` with the terms `fits`, fitted anew to all runs.
    pub(super) fn with_terms_of(&self, found: &Found, fits: &[Selected]) -> Option<Found> {
        let start = self.fit(found.stepping, found.model.offsets(), Some(&found.model), &Terms::Same(fits)).ok()?;
        match start.stepping {
            Stepping::Continuous { .. } | Stepping::SemiImplicit { substeps: 2.. } => self.refine(start).ok(),
            _ => self.judged(start).ok(),
        }
    }

    fn once(&self) -> Result<Found, ModelError> {
        match shown(self.runs, self.system.rates, self.system.dt) {
            Some(Stepping::Continuous { .. }) => {
                let continuous = self.followed(CONTINUOUS)?;
                // Simulators may take several steps from sample to sample. Of few samples more terms explain other steps too.
                let several = substeps_shown(self.runs, self.system.rates, self.system.dt).into_iter();
                let mut found = several.filter_map(|substeps| self.followed(Stepping::SemiImplicit { substeps }).ok());
                let followed = self.positions_missed(&continuous);
                let better = |found: &Found| {
                    let gain = followed - self.positions_missed(found);
                    found.explains() && (gain > CLEAR || (gain > -CLEAR && self.is_simpler(found, &continuous)))
                };
                Ok(found.find(better).unwrap_or(continuous))
            }
            Some(stepping) => self.discrete(stepping),
            None => {
                let continuous = self.followed(CONTINUOUS)?;
                if continuous.explains() {
                    // Samples of a linear system follow from one another by Euler steps too: that says nothing.
                    return Ok(continuous);
                }
                let euler = self.discrete(Stepping::Euler)?;
                Ok(if euler.misfit < continuous.misfit { euler } else { continuous })
            }
        }
    }

    /// −2 ln L of how the states with known rates follow in one step: what the rates alone explain, linear systems leave to these to tell.
    fn positions_missed(&self, found: &Found) -> f64 {
        let steps = self.runs.iter().map(Run::len).sum::<usize>() as f64;
        let mut rng = Seed::new(0).stream("no randomness", 0);
        let mut next = vec![0.0; self.system.rates.len()];
        let mut total = 0.0;
        for (i, v) in self.system.rates.iter().enumerate().filter_map(|(i, v)| v.map(|v| (i, v))) {
            let mut squares = 0.0;
            for run in self.runs {
                for t in 0..run.len() {
                    let (x, u) = (run.x.row(t).to_vec(), run.u.row(t).to_vec());
                    if found.model.step(&x, &u, &mut rng, &mut next).is_err() {
                        return f64::INFINITY;
                    }
                    let seen = run.sigma[[t, i]].hypot(run.sigma[[t + 1, i]]).hypot(self.system.dt * run.sigma[[t, v]]);
                    squares += ((run.x[[t + 1, i]] - next[i]) / seen).powi(2);
                }
            }
            total += steps * (squares / steps).max(1.0).ln();
        }
        total
    }

    /// Equations stepped by rates at one instant: averages are values there, and do not depend on the equations.
    fn discrete(&self, stepping: Stepping) -> Result<Found, ModelError> {
        self.widening(|choices, _| {
            let found = self.fit(stepping, &self.upright(), None, &Terms::Best(choices))?;
            // Once more, with the errors that enter through the terms.
            let found = self.fit(stepping, &self.upright(), Some(&found.model), &Terms::Best(choices))?;
            Ok(self.pruned(self.judged(found)?))
        })
    }

    /// Equations followed from sample to sample: in continuous time in as many Runge–Kutta steps as there are, unless fewer are clearly better.
    fn followed(&self, stepping: Stepping) -> Result<Found, ModelError> {
        let found = self.widening(|choices, before| {
            let Some(before) = before else { return self.first(stepping, choices) };
            let fresh = self.first(stepping, choices);
            if let Ok(found) = &fresh
                && found.explains()
            {
                return fresh;
            }
            let offsets = before.model.offsets().to_vec();
            let start = self.fit(before.stepping, &offsets, Some(&before.model), &Terms::Best(choices))?;
            self.settle(self.refine(start.clone()).unwrap_or(start), choices)
        })?;
        Ok(self.followed_closely(found))
    }

    /// What is found before anything else is: with angles as they are, or with other zeros where that explains more.
    fn first(&self, stepping: Stepping, choices: &[Choice]) -> Result<Found, ModelError> {
        let start = self.fit(stepping, &self.upright(), None, &Terms::Best(choices))?;
        let refined = self.refine(start.clone()).unwrap_or_else(|_| start.clone());
        if !refined.explains() {
            // A small tilt shows in the first, rough equations; what explains everything with it needs no further search.
            if let Some(tilted) = self.tilted(&start).ok().flatten().filter(Found::explains) {
                return Ok(self.simplest(tilted));
            }
        }
        let upright = self.settle(refined, choices)?;
        if self.is_mixed(&upright)
            && !upright.explains()
            && let Some(tilted) = self.tilted(&upright).ok().flatten().filter(|t| self.is_simpler(t, &upright))
        {
            return Ok(self.simplest(tilted));
        }
        Ok(self.simplest(upright))
    }

    /// `found`, or the same without terms that are not needed, told with other zeros of angles where that is simpler.
    fn simplest(&self, found: Found) -> Found {
        let found = match self.reduced(&found) {
            Ok(reduced) if self.is_simpler(&reduced, &found) => reduced,
            _ => found,
        };
        let found = match self.untangled(&found) {
            Ok(Some(untangled)) if self.is_simpler(&untangled, &found) => untangled,
            _ => found,
        };
        self.pruned(found)
    }

    /// The best of the terms of `found`. A rough search may find more than are needed.
    fn reduced(&self, found: &Found) -> Result<Found, ModelError> {
        let offsets = found.model.offsets();
        let fewer = self.fit(found.stepping, offsets, Some(&found.model), &Terms::Of(&found.fits))?;
        if fewer.model.fitted().len() < found.model.fitted().len() { self.refine(fewer) } else { Ok(fewer) }
    }

    /// Whether `found` explains more equations than `other`, or as many with fewer coefficients.
    fn is_simpler(&self, found: &Found, other: &Found) -> bool {
        let unexplained = |found: &Found| found.fits.iter().filter(|f| !f.reached_floor).count();
        let cost = |found: &Found| (unexplained(found), found.model.fitted().len());
        cost(found) < cost(other)
    }

    pub(super) fn upright(&self) -> Vec<f64> {
        vec![0.0; self.system.rates.len()]
    }

    /// N ln σ² + k ln N + 2 ln C(F, k), over all equations: the extended BIC.
    pub(super) fn score(&self, found: &Found) -> f64 {
        let rows: usize = self.runs.iter().map(Run::len).sum();
        let score = |f: &Selected| {
            let wide = f.support.iter().any(|&j| j >= self.system.core);
            let n_terms = if wide { self.system.terms.len() } else { self.system.core };
            let (n, k) = (rows as f64, f.support.len());
            let variance = f.residual.max(2.0 * ROUNDING).powi(2);
            n * variance.ln() + k as f64 * n.ln() + 2.0 * binomial(n_terms, k).ln()
        };
        let tilts = found.model.offsets().iter().filter(|v| **v != 0.0).count();
        let fitted = found.fits.iter().zip(self.system.rates).filter(|(_, r)| r.is_none());
        fitted.map(|(f, _)| score(f)).sum::<f64>() + tilts as f64 * (rows as f64).ln()
    }
}
