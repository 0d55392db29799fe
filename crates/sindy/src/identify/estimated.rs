//! Equations of motion from data whose errors are more than rounding.

use std::cell::Cell;
use std::ops::RangeInclusive;

use sindyna_core::{Dataset, FitError, Rollout, number::significant};

use super::Identifier;
use super::NoiseChoice;
use super::in_motion::stays;
use super::models::Models;
use super::noisy::{Joined, Noisy};
use super::outliers;
use super::recording::{Recording, dataset};
use super::report::{Counts, Identified, Report};
use super::unmeasured::begun;
use crate::coordinates::Coordinates;
use crate::data::Segment;
use crate::estimate::{Doubt, Estimate, Problem, Structure, budget, still};
use crate::library::{Extent, Joints, Term, general, quotients, shaped};
use crate::mechanics::Proposal;
use crate::model::{Entry, Model};
use crate::motion::{self, Found, Stepping};
use crate::regression::{Space, model};
use crate::{CoordinateMode, Expr, LibraryChoice, Watch};

/// Magnitudes of states whose third powers, and the squares of these, are numbers.
const MAGNITUDES: RangeInclusive<f64> = 1e-45..=1e45;

impl Identifier {
    /// The candidate terms when the data have noise: all at once, judged by one score.
    fn general_terms(&self, tiers: Vec<Term>, segments: &[Segment]) -> Vec<Term> {
        if self.library != LibraryChoice::Auto {
            return tiers;
        }
        let inputs = self.inputs();
        let mut terms = general(&inputs, &self.rates(), &self.extents(segments));
        let same = self.unchanging(segments);
        terms.retain(|t| !same.iter().any(|&i| t.expr.has(i) || t.rate == Some(i)));
        // Terms of the user's own, and those of declared rates.
        let missing =
            |t: &Term| self.own_terms.contains(&t.name) || (t.rate.is_none() && matches!(t.expr, Expr::Variable(_)));
        for term in tiers.into_iter().filter(missing) {
            if !terms.iter().any(|t| t.rate == term.rate && t.expr == term.expr) {
                terms.push(term);
            }
        }
        terms
    }

    /// Candidate terms with parameters inside, where the library is the identifier's own.
    fn terms_with_parameters(&self, segments: &[Segment]) -> Vec<Term> {
        if self.library != LibraryChoice::Auto {
            return Vec::new();
        }
        let same = self.unchanging(segments);
        let mut terms = shaped(&self.inputs(), &self.extents(segments));
        terms.retain(|t| !same.iter().any(|&i| t.expr.has(i)));
        terms
    }

    /// Quotients by one variable, where the library is the identifier's own.
    fn quotients(&self, segments: &[Segment]) -> Vec<Term> {
        if self.library != LibraryChoice::Auto {
            return Vec::new();
        }
        let same = self.unchanging(segments);
        let mut terms = quotients(&self.inputs(), &self.rates(), &self.extents(segments));
        terms.retain(|t| !same.iter().any(|&i| t.expr.has(i)));
        terms
    }

    /// The states and inputs that have one value in `segments`, as far as noise shows.
    fn unchanging(&self, segments: &[Segment]) -> Vec<usize> {
        let at_rest = still(segments, &self.rates()).in_all;
        let same = |i: &usize| at_rest.contains(i) || stays(self.values(*i, segments).into_iter());
        (0..self.spec.state_dim() + self.spec.control_dim()).filter(same).collect()
    }

    /// The values in `segments` of state `i`, or of input `i` − n.
    fn values(&self, i: usize, segments: &[Segment]) -> Vec<f64> {
        let n = self.spec.state_dim();
        let of = |s: &Segment| if i < n { s.x.column(i).to_vec() } else { s.u.column(i - n).to_vec() };
        segments.iter().flat_map(of).collect()
    }

    /// What the values of states and inputs (n + k) are in `segments`.
    fn extents(&self, segments: &[Segment]) -> Vec<Extent> {
        let n = self.spec.state_dim() + self.spec.control_dim();
        (0..n).map(|i| Extent::of(&self.values(i, segments))).collect()
    }

    /// Identifies the equations behind recordings that may be sampled unevenly; their noise is estimated.
    ///
    /// Recordings sampled as the spec declares are what [`Self::identify`] takes.
    ///
    /// # Errors
    /// [`FitError`] if the recordings do not have the spec's shape, their times do not increase, or they are too few.
    pub fn identify_recordings(&self, recordings: &[Recording]) -> Result<Identified, FitError> {
        self.identify_recordings_watched(recordings, &Watch::default())
    }

    /// The same, followed by `watch`, which may end it.
    ///
    /// # Errors
    /// As [`Self::identify_recordings`]; [`FitError::Interrupted`] if `watch` did.
    pub fn identify_recordings_watched(
        &self,
        recordings: &[Recording],
        watch: &Watch<'_>,
    ) -> Result<Identified, FitError> {
        recordings.iter().try_for_each(|r| r.check(&self.spec))?;
        let unmeasured = self.unmeasured(recordings)?;
        let held = recordings.iter().all(|r| r.intersample.is_held());
        if unmeasured.is_empty() && held && recordings.iter().all(|r| r.is_even(self.spec.dt)) {
            return self.identify_watched(&dataset(&self.spec, recordings)?, watch);
        }
        let failed = |reason: String| FitError::Regression { reason };
        let solver = self.motion_solver().ok_or_else(|| {
            failed(
                "samples at uneven times, inputs that are not held, and states that were not measured, need the target `motion` with best subsets in recognised coordinates".into(),
            )
        })?;
        let tiers = self.with_rates_of_motion(self.tiers().map_err(|e| failed(e.to_string()))?).terms;
        let coordinates = Coordinates::new(&self.spec, CoordinateMode::Recognised)
            .map_err(|state| failed(format!("no observation shows the state `{state}`")))?;
        let of_inputs = motion::written(&self.spec);
        let segment = |r: &Recording| Segment { of_inputs: of_inputs.clone(), ..r.known(&coordinates) };
        let segments: Vec<Segment> = recordings.iter().map(segment).filter(|s| s.len() > 0).collect();
        let rows: usize = segments.iter().map(Segment::len).sum();
        let needed = self.needed_rows();
        if rows < needed {
            let unknowns = format!("{} equations", self.spec.state_dim());
            return Err(FitError::TooFewRows { got: rows, needed, unknowns });
        }
        let floor = self.smallest_errors(&coordinates, recordings);
        let segments = if unmeasured.is_empty() { segments } else { begun(segments, &self.rates(), &floor) };
        let space = self.motion_space().map_err(failed)?;
        let counts = Counts { rows, at_limit: 0, astray: 0 };
        let noisy = Noisy {
            segments: &segments,
            floor: &floor,
            stepping: Stepping::Continuous { substeps: 1 },
            simulators: &[],
            counts,
            space: &space,
            solver,
            watch,
        };
        let found = match self.joined(&noisy)? {
            Joined::Adequate(found) => Some(*found),
            Joined::Proposed(proposed) => self.estimated((tiers, None), &proposed, &noisy)?,
        };
        if !watch.go_on() {
            return Err(FitError::Interrupted);
        }
        found.ok_or_else(|| failed("no equations reproduce the data".into()))
    }

    /// Equations from even data whose inputs change between samples.
    pub(super) fn under_changing_inputs(&self, data: &Dataset, watch: &Watch<'_>) -> Result<Identified, FitError> {
        self.check(data)?;
        let of = |rollout: Rollout<'_>| {
            Recording::even(data.dt(), rollout.observations.to_owned(), Some(rollout.controls.to_owned()))
                .with_intersample(data.intersample())
        };
        self.identify_recordings_watched(&data.rollouts().map(of).collect::<Vec<_>>(), watch)
    }

    /// Refuses states whose powers are beyond all numbers.
    fn check_magnitudes(&self, segments: &[Segment]) -> Result<(), FitError> {
        for (i, channel) in self.spec.state.iter().enumerate() {
            let largest = segments.iter().flat_map(|s| s.x.column(i).to_vec()).fold(0.0, |m: f64, v| m.max(v.abs()));
            let shortest = segments.iter().flat_map(|s| s.dt.iter().copied()).fold(f64::INFINITY, f64::min);
            if largest > 0.0 && !(MAGNITUDES.contains(&largest) && MAGNITUDES.contains(&(largest / shortest))) {
                let [low, high, largest, shortest] =
                    [*MAGNITUDES.start(), *MAGNITUDES.end(), largest, shortest].map(|v| significant(v, 3));
                let name = &channel.name;
                let reason = format!(
                    "the state `{name}` reaches {largest} in steps of {shortest} s; it and its rate must be between {low} and {high}"
                );
                return Err(FitError::Regression { reason });
            }
        }
        Ok(())
    }

    /// The equations that explain parts of the data, with terms `tiers`, in `terms`; those among `tiers` alone are added.
    fn structure(&self, found: &Found, tiers: &[Term], terms: &mut Vec<Term>) -> Structure {
        let mut place = |j: usize| {
            let known = terms.iter().position(|t| t.rate == tiers[j].rate && t.expr == tiers[j].expr);
            known.unwrap_or_else(|| {
                terms.push(tiers[j].clone());
                terms.len() - 1
            })
        };
        let rows = found.fits.iter().zip(self.rates()).map(|(fit, rate)| {
            let own = fit.support.iter().zip(&fit.coefficients).filter(|_| rate.is_none());
            own.map(|(j, c)| (place(*j), *c)).collect()
        });
        structured(rows.collect())
    }

    /// The equations of a `model` that parts of the data were fitted to, of the terms that are among `terms`.
    pub(super) fn structure_of(&self, model: &Model, terms: &[Term]) -> Option<Structure> {
        let rates = self.rates();
        if model.states().len() != rates.len() || model.offsets().iter().any(|offset| *offset != 0.0) {
            return None;
        }
        let place = |entry: &Entry| {
            let expr = &model.terms()[entry.term];
            Some((terms.iter().position(|t| t.rate == entry.rate && t.expr == *expr)?, entry.coefficient))
        };
        let row = |(i, declared): (usize, &Option<usize>)| {
            let entries = model.coefficients(i).iter().filter(|entry| declared.is_none() && entry.coefficient != 0.0);
            entries.filter_map(place).collect()
        };
        Some(structured(rates.iter().enumerate().map(row).collect()))
    }

    /// What all equations are looked for in, before there are terms.
    fn problem<'a>(&self, noisy: &Noisy<'a>, rates: &'a [Option<usize>], spent: &'a Cell<u64>) -> Problem<'a> {
        let Noisy { segments, floor, simulators, solver, watch, .. } = *noisy;
        let whole = budget(self.effort, segments);
        Problem {
            terms: &[],
            n_plain: 0,
            most_complex: u32::MAX,
            of_parts: None,
            instead: None,
            mechanics: &[],
            rates,
            n_controls: self.spec.control_dim(),
            constraints: &[],
            segments,
            floor,
            noise: &[],
            alone: &[],
            simulators,
            solver,
            whole,
            budget: whole,
            again: false,
            // Simulators hold their inputs.
            discrete: self.simulators && segments.iter().all(|s| s.ramp.is_none()),
            spent,
            watch,
        }
    }

    /// Equations of several joints that one Lagrangian ties together, if nothing speaks against them, or what Lagrangians propose.
    pub(super) fn joined(&self, noisy: &Noisy<'_>) -> Result<Joined, FitError> {
        let (rates, spent) = (self.rates(), Cell::new(0));
        let at_rest = still(noisy.segments, &rates).in_each;
        let joints = Joints::new(&self.inputs(), &rates, &at_rest).filter(|_| self.constraints.is_empty());
        let Some(joints) = joints else { return Ok(Joined::Proposed(Vec::new())) };
        self.check_magnitudes(noisy.segments)?;
        let problem = self.problem(noisy, &rates, &spent);
        Ok(match self.of_joints(&joints, &problem, (noisy.stepping, noisy.space)) {
            Ok(found) => Joined::Adequate(Box::new(self.told(found, Vec::new(), noisy)?)),
            Err(proposed) => Joined::Proposed(proposed),
        })
    }

    /// Equations with the best score, with noise estimated, but not below the smallest errors that are believed; `of_parts` explain parts of the data to rounding, and Lagrangians have
    /// `proposed` others. Equations are stepped as the states with declared rates show, or as one of the simulators does it. `None` if no equations follow the data.
    pub(super) fn estimated(
        &self,
        (tiers, of_parts): (Vec<Term>, Option<Found>),
        proposed: &[Proposal],
        noisy: &Noisy<'_>,
    ) -> Result<Option<Identified>, FitError> {
        let Noisy { segments, stepping, space, .. } = *noisy;
        self.check_magnitudes(segments)?;
        let mut terms = self.general_terms(tiers.clone(), segments);
        let of_parts = of_parts
            .map(|found| self.structure(&found, &tiers, &mut terms))
            .or_else(|| self.previous.as_ref().and_then(|model| self.structure_of(model, &terms)));
        let constraints = self.constrained(&mut terms).map_err(|e| FitError::Regression { reason: e.to_string() })?;
        let (rates, spent) = (self.rates(), Cell::new(0));
        let mechanics = Joints::new(&self.inputs(), &rates, &still(segments, &rates).in_each)
            .map_or_else(Vec::new, |joints| self.structures(&joints, proposed, &mut terms));
        let n_plain = terms.len();
        terms.extend(self.terms_with_parameters(segments));
        let quotients =
            self.quotients(segments).into_iter().filter(|t| !terms[..n_plain].iter().any(|o| o.expr == t.expr));
        terms.extend(quotients.collect::<Vec<_>>());
        let problem = Problem {
            terms: &terms,
            n_plain,
            of_parts: of_parts.as_ref(),
            mechanics: &mechanics,
            constraints: &constraints,
            ..self.problem(noisy, &rates, &spent)
        };
        let (found, notes) = self.estimated_or_in_pieces(&problem, stepping, space);
        found.map(|found| self.told(found, notes, noisy)).transpose()
    }

    /// What was `found`, with `notes` of it.
    fn told(&self, mut found: Estimate, notes: Vec<String>, noisy: &Noisy<'_>) -> Result<Identified, FitError> {
        let Noisy { segments, floor, ref counts, space, .. } = *noisy;
        if self.noise == NoiseChoice::Rounding && !found.leaves_nothing {
            for (fit, doubt) in found.fits.iter_mut().zip(&mut found.doubts) {
                fit.reached_floor = false;
                *doubt = doubt.or(Some(Doubt::AboveRounding));
            }
        }
        // Noise that is declared is no rounding, however little it leaves.
        found.rounding = found.rounding.filter(|_| self.spec.noise <= 0.0);
        let dt = self.spec.dt;
        let model = written(&found, space, dt).map_err(|reason| FitError::Regression { reason })?;
        let counts = Counts { rows: counts.rows - found.astray, astray: found.astray, ..*counts };
        let mut report = Report::estimated(&self.names(), counts, &found, dt);
        report.warnings.extend(notes);
        if found.astray > 0 {
            report.warnings.extend(outliers::told(&self.names(), &model, segments, floor));
        }
        let models = Some(Models::new(found.posterior, space.clone(), found.stepping, dt, &model));
        Ok(Identified { model, report, models })
    }
}

/// The structure of equations whose terms and coefficients are `rows`.
pub(super) fn structured(mut rows: Vec<Vec<(usize, f64)>>) -> Structure {
    rows.iter_mut().for_each(|row| row.sort_by_key(|(j, _)| *j));
    let supports = rows.iter().map(|row| row.iter().map(|(j, _)| *j).collect()).collect();
    (supports, rows.into_iter().flatten().map(|(_, c)| c).collect())
}

/// The model of the equations found.
pub(super) fn written(found: &Estimate, space: &Space, dt: f64) -> Result<Model, String> {
    model(space.clone(), &found.terms, &found.fits, found.stepping.form(), dt).map_err(|e| e.to_string())
}
