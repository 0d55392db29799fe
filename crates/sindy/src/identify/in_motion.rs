//! Equations of motion with the way they are stepped: down to rounding where that explains the data, else with noise estimated.

use std::cell::OnceCell;

use ndarray::{Array2, Axis, concatenate, s};
use sindyna_core::{Channel, Dataset, FitError};

use super::Identifier;
use super::noisy::{Joined, Noisy};
use super::outliers;
use super::report::{Counts, Identified, Noise, Report};
use crate::coordinates::Coordinates;
use crate::data::{Segment, Smoother};
use crate::estimate::still;
use crate::library::{Joints, Term, Tiers};
use crate::regression::{Space, design};
use crate::{BestSubset, Stage, Watch, motion};

impl Identifier {
    /// Equations of motion, with the way they are stepped.
    pub(super) fn in_motion_of(
        &self,
        data: &Dataset,
        tiers: Tiers,
        coordinates: &Coordinates,
        solver: &BestSubset,
        watch: &Watch<'_>,
    ) -> Result<Identified, FitError> {
        let failed = |reason: String| FitError::Regression { reason };
        let tiers = self.with_rates_of_motion(tiers);
        let rates = self.rates();
        let declared: Vec<f64> = self.spec.noise_deviations().collect();
        let (runs, at_limits) = motion::runs(&self.spec, coordinates, data, &declared);
        let rows: usize = runs.iter().map(motion::Run::len).sum();
        let needed = self.needed_rows();
        if rows < needed {
            let count = rates.iter().filter(|r| r.is_none()).count();
            let unknowns = format!("{count} equation{}", if count == 1 { "" } else { "s" });
            return Err(FitError::TooFewRows { got: rows, needed, unknowns });
        }
        let constant = self.constant_inputs(&runs);
        let warned = |mut found: Identified| {
            found.report.warnings.extend(self.warnings(&constant));
            found.report.warnings.extend(self.unmoved(&found.report));
            found
        };
        let (segments, floor) = self.segments(&runs);
        let at_rest = still(&segments, &rates);
        let same = |i: &usize| at_rest.in_all.contains(i) || stays(runs.iter().flat_map(|r| r.x.column(*i).to_vec()));
        let inputs = constant.iter().map(|(k, _)| rates.len() + k);
        let same: Vec<usize> = (0..rates.len()).filter(same).chain(inputs).collect();
        let tiers = self.without(tiers, &same);
        for run in &runs {
            let z = concatenate![Axis(1), run.x.slice(s![..run.len(), ..]), run.u];
            let none = Array2::zeros((run.len(), 0));
            design(&tiers.terms, z.view(), none.view()).map_err(|e| failed(e.to_string()))?;
        }
        let angles = self.angles();
        let system =
            motion::System { terms: &tiers.terms, core: tiers.core, rates: &rates, angles: &angles, dt: self.spec.dt };
        let space = self.motion_space().map_err(failed)?;
        let search = motion::Search { system: &system, runs: &runs, space: &space, solver, watch };
        watch.tell(Stage::Rounding);
        let counts = Counts { rows, at_limit: at_limits, astray: 0 };
        // Of few steps, rounding first: it tells equations apart that no statistics does.
        let may_be_exact = self.spec.noise <= 0.0 && self.constraints.is_empty();
        let rounded = may_be_exact && search.is_short();
        // Of several joints one Lagrangian has the fewest unknowns.
        let joints = if may_be_exact { Joints::new(&self.inputs(), &rates, &at_rest.in_each) } else { None };
        let mechanical = joints.and_then(|joints| search.mechanical(&joints, &self.inputs()));
        let tilted = match mechanical {
            None => None,
            Some(found) => match search.tilted_instead(&found) {
                None => return Ok(warned(self.of_mechanics(found, &search, counts))),
                tilted => tilted,
            },
        };
        // Noise hides which samples are at a limit.
        let near = || {
            let noise = self.noise_of_limited(&segments, &floor)?;
            let (runs, at_limit) = motion::runs(&self.spec, coordinates, data, &noise);
            let rows: usize = runs.iter().map(motion::Run::len).sum();
            let (segments, floor) = self.segments(&runs);
            (rows >= needed).then_some((segments, floor, Counts { rows, at_limit, astray: 0 }))
        };
        let samples = OnceCell::new();
        let simulators = OnceCell::new();
        let noisy = || {
            let (segments, floor, counts) =
                samples.get_or_init(|| near().unwrap_or_else(|| (segments.clone(), floor.clone(), counts)));
            Noisy {
                segments,
                floor,
                stepping: motion::shown(&runs, &rates, self.spec.dt)
                    .unwrap_or(motion::Stepping::Continuous { substeps: 1 }),
                simulators: simulators.get_or_init(|| motion::simulators(&runs, &rates, self.spec.dt)),
                counts: *counts,
                space: &space,
                solver,
                watch,
            }
        };
        // One Lagrangian has fewer unknowns than a search for equations of rounding, with noise too.
        let proposed = if tilted.is_none() {
            match self.joined(&noisy())? {
                Joined::Adequate(found) => return Ok(warned(*found)),
                Joined::Proposed(proposed) => proposed,
            }
        } else {
            Vec::new()
        };
        let mut exact = tilted.or_else(|| rounded.then(|| search.exact()).flatten()).map(|found| (found, None, 0));
        if exact.is_none() && rounded {
            // What explains parts of the data to rounding explains all but a few steps.
            exact = search.without_strays().map(|(found, runs, strays)| (found, Some(runs), strays));
        }
        if exact.is_none() {
            let of_parts = may_be_exact.then(|| search.of_parts()).flatten();
            let found = self.estimated((tiers.terms, of_parts), &proposed, &noisy())?;
            return found.map(warned).ok_or_else(|| failed("no equations reproduce the data".into()));
        }
        let Some((mut found, kept, strays)) = exact else {
            return Err(failed("no equations reproduce the data".into()));
        };
        let runs = kept.as_deref().unwrap_or(&runs);
        let (model, errors) = match motion::polished(&found, runs) {
            Some(polished) => (polished.model, polished.errors),
            None => (found.model.clone(), Vec::new()),
        };
        let search = motion::Search { runs, ..search };
        let residuals = search.residuals(&found, &model);
        // The verdict is one on the model that is written, whose coefficients are others than those the search judged.
        let explained = search.explained_by(&found, &model, &residuals);
        for (fit, explained) in found.fits.iter_mut().zip(explained) {
            fit.reached_floor &= explained;
        }
        let counts = Counts { rows: rows - strays, at_limit: at_limits, astray: strays };
        let mut report = Report::in_motion(
            &self.names(),
            &tiers.terms,
            counts,
            Noise::Rounding,
            found,
            &residuals,
            (&model, &errors),
        );
        if strays > 0 {
            report.warnings.extend(outliers::told(&self.names(), &model, &segments, &floor));
        }
        Ok(warned(Identified { model, report, models: None }))
    }

    /// What one Lagrangian says of all joints. Its parameters are fitted already.
    fn of_mechanics(&self, of: motion::Mechanical, search: &motion::Search<'_>, counts: Counts) -> Identified {
        let motion::Mechanical { terms, found, errors, .. } = of;
        let model = found.model.clone();
        let system = motion::System { terms: &terms, core: terms.len(), ..*search.system };
        let residuals = motion::Search { system: &system, ..*search }.residuals(&found, &model);
        let fitted = (&model, &errors[..]);
        let report = Report::in_motion(&self.names(), &terms, counts, Noise::Rounding, found, &residuals, fitted);
        Identified { model, report, models: None }
    }

    /// The samples of `runs`, and the smallest error of each state (n) that is believed.
    fn segments(&self, runs: &[motion::Run]) -> (Vec<Segment>, Vec<f64>) {
        let error = |i: usize| runs.iter().flat_map(|r| r.sigma.column(i).to_vec()).fold(0.0, f64::max);
        let segments = runs.iter().map(|r| Segment::even(r, self.spec.dt)).collect();
        (segments, (0..self.spec.state_dim()).map(error).collect())
    }

    /// Standard deviations of the noise of the observations (m), estimated where none is declared and states have limits.
    fn noise_of_limited(&self, segments: &[Segment], floor: &[f64]) -> Option<Vec<f64>> {
        let limited = |c: &Channel| c.prior.bounds.0.is_finite() || c.prior.bounds.1.is_finite();
        if self.spec.noise > 0.0 || !self.spec.state.iter().any(limited) {
            return None;
        }
        let sigma = Smoother::new(segments, &self.rates(), floor, &|| true).signals(floor).sigma;
        let of = |o: &Channel| self.spec.state.iter().position(|s| s.name == o.name).map_or(0.0, |i| sigma[i]);
        Some(self.spec.observation.iter().map(of).collect())
    }

    /// `tiers` with the terms of kinematic equations, which need them whatever library was chosen.
    pub(super) fn with_rates_of_motion(&self, mut tiers: Tiers) -> Tiers {
        for &rate in self.rates().iter().flatten() {
            let expr = crate::Expr::Variable(rate);
            if !tiers.terms.iter().any(|t| t.rate.is_none() && t.expr == expr) {
                tiers.terms.push(Term {
                    name: self.inputs()[rate].name.clone(),
                    expr,
                    complexity: 2,
                    rate: None,
                    shape: None,
                });
            }
        }
        tiers
    }

    /// `tiers` without terms of the states `still`, which never change: what these multiply says no more than what is multiplied. Terms of
    /// the user's own stay, and those of declared rates.
    fn without(&self, tiers: Tiers, still: &[usize]) -> Tiers {
        let kept = |t: &Term| {
            let own = self.own_terms.contains(&t.name) || matches!(t.expr, crate::Expr::Variable(_));
            own || !still.iter().any(|&i| t.expr.has(i))
        };
        let core = tiers.terms.iter().take(tiers.core).filter(|t| kept(t)).count();
        Tiers { terms: tiers.terms.into_iter().filter(kept).collect(), core }
    }

    /// The space of a model whose declared rates are kinematic equations.
    pub(super) fn motion_space(&self) -> Result<Space, String> {
        let kinematic = self.rates().iter().map(Option::is_some).collect();
        Ok(Space { kinematic, ..self.space()? })
    }

    /// The inputs that stay where they are, which is not zero: what they do cannot be told from a constant.
    fn constant_inputs(&self, runs: &[motion::Run]) -> Vec<(usize, f64)> {
        let values = |k: usize| runs.iter().flat_map(move |run| run.u.column(k).to_vec());
        let constant =
            |k: usize| values(k).next().filter(|first| *first != 0.0 && stays(values(k))).map(|first| (k, first));
        (0..self.spec.control_dim()).filter_map(constant).collect()
    }

    /// Warnings of states whose equations have no terms.
    fn unmoved(&self, report: &Report) -> Vec<String> {
        let states = self.spec.state.iter().zip(self.rates()).zip(&report.equations);
        let empty = states.filter(|((_, rate), equation)| rate.is_none() && equation.support.is_empty());
        let told = |((state, _), _): ((&Channel, _), _)| {
            format!("the equation of `{}` has no terms: no candidate term explains more than noise", state.name)
        };
        empty.map(told).collect()
    }

    /// Warnings of inputs that never change.
    fn warnings(&self, constant: &[(usize, f64)]) -> Vec<String> {
        let told = |(k, value): &(usize, f64)| {
            let name = &self.spec.control[*k].name;
            format!(
                "the input `{name}` is {value} in every step: its effect is part of the constant terms and unknown for other values"
            )
        };
        constant.iter().map(told).collect()
    }
}

/// Whether all `values` are the same.
pub(super) fn stays(mut values: impl Iterator<Item = f64>) -> bool {
    let first = values.next();
    first.is_none_or(|first| values.all(|v| v.to_bits() == first.to_bits()))
}
