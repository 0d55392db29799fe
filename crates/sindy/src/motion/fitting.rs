//! One regression for each equation, along a way that is given.

use ndarray::{Array2, Axis, concatenate};

use super::choice::Choice;
use super::found::{Found, Search};
use super::unseen::unseen;
use super::{Run, Stepping, System};
use crate::design::whiten;
use crate::model::ModelError;
use crate::regression::model;
use crate::solve::{FLOOR_FACTOR, Selected, Selection};
use crate::{Expr, Model, Stage, Triangle};

/// Half the RMS of whitened residuals that rounding explains. It is generous: rounding errors are no random numbers, and
/// a system rounds on its way too.
pub(super) const ROUNDING: f64 = 2.0;

/// Where the terms of an equation come from.
pub(super) enum Terms<'a> {
    /// The best ones of those that are allowed each equation.
    Best(&'a [Choice]),
    /// The best ones of those of equations found before.
    Of(&'a [Selected]),
    /// All those of equations found before.
    Same(&'a [Selected]),
}

impl Search<'_> {
    /// Per equation: whether the coefficients of `model` leave no more than the errors of the samples explain, step by step or in sums
    /// over steps; `found` has its terms, `residuals` are what it leaves and what of it the errors explain.
    pub(crate) fn explained_by(&self, found: &Found, model: &Model, residuals: &[(f64, f64)]) -> Vec<bool> {
        let errors = self.errors_of_terms(model, found.stepping, true);
        let theta = self.averages_of(found, model);
        let explained = |(i, fit): (usize, &Selected)| {
            // Equations that blow up along the data are followed so badly that any residual is within their own errors.
            if residuals[i].1 > self.signal(i) {
                return false;
            }
            if residuals[i].0 <= FLOOR_FACTOR * ROUNDING * residuals[i].1 {
                return true;
            }
            let Ok(triangle) = whitened(self.system, self.runs, &theta, &fit.support, i, Some(&errors)) else {
                return false;
            };
            let all: Vec<usize> = (0..fit.support.len()).collect();
            let xi: Vec<f64> = model.coefficients(i).iter().map(|e| e.coefficient).collect();
            let left = triangle.residual_norm(&all, &xi, all.len()).powi(2) / triangle.n_rows().max(1) as f64;
            left.sqrt() <= FLOOR_FACTOR * ROUNDING
        };
        let fitted = |(i, fit): (usize, &Selected)| self.system.rates[i].is_some() || explained((i, fit));
        found.fits.iter().enumerate().map(fitted).collect()
    }

    /// RMS of Δx/Δt of state `i`; infinite for a state that stands still, of which there is nothing to explain.
    fn signal(&self, i: usize) -> f64 {
        let moves = |run: &Run| -> f64 {
            (0..run.len()).map(|t| ((run.x[[t + 1, i]] - run.x[[t, i]]) / self.system.dt).powi(2)).sum()
        };
        let rows = self.runs.iter().map(Run::len).sum::<usize>().max(1) as f64;
        let rms = (self.runs.iter().map(moves).sum::<f64>() / rows).sqrt();
        if rms > 0.0 { rms } else { f64::INFINITY }
    }

    /// One round: averages along the way of `along`, then the terms and coefficients of each equation. Rows weigh as much as
    /// the errors of the samples, of the terms, and of the finest Runge–Kutta steps allow.
    pub(super) fn fit(
        &self,
        stepping: Stepping,
        offsets: &[f64],
        along: Option<&Model>,
        terms: &Terms<'_>,
    ) -> Result<Found, ModelError> {
        let errors = along.map(|model| self.errors_of_terms(model, stepping, true));
        self.fit_weighted(stepping, offsets, along, terms, errors.as_deref())
    }

    /// Errors of each step besides those of the states at its ends, run by run; see [`unseen`].
    pub(super) fn errors_of_terms(&self, model: &Model, stepping: Stepping, numerical: bool) -> Vec<Array2<f64>> {
        self.runs.iter().map(|run| unseen(model, stepping, run, self.system.dt, numerical)).collect()
    }

    /// The same with `errors` of the steps that are known.
    pub(super) fn fit_weighted(
        &self,
        stepping: Stepping,
        offsets: &[f64],
        along: Option<&Model>,
        terms: &Terms<'_>,
        errors: Option<&[Array2<f64>]>,
    ) -> Result<Found, ModelError> {
        if !self.watch.go_on() {
            return Err(ModelError::Interrupted);
        }
        self.watch.tell(Stage::Rounding);
        let system = self.system;
        let wanted: Vec<usize> = match terms {
            Terms::Of(fits) | Terms::Same(fits) => {
                let mut used: Vec<usize> = fits.iter().flat_map(|f| f.support.iter().copied()).collect();
                used.sort_unstable();
                used.dedup();
                used
            }
            Terms::Best(choices) if choices.contains(&Choice::Wide) => (0..system.terms.len()).collect(),
            Terms::Best(_) => (0..system.core).collect(),
        };
        let averages = |run: &Run| system.averages(run, stepping, along, offsets, &wanted);
        let theta: Vec<Array2<f64>> = self.runs.iter().map(averages).collect();
        let (mut misfit, mut condition) = (0.0, 1.0_f64);
        let mut fits = Vec::with_capacity(system.rates.len());
        for (i, rate) in system.rates.iter().enumerate() {
            if let Some(rate) = *rate {
                fits.push(kinematic(system, rate));
                continue;
            }
            let choice: Vec<usize> = match terms {
                Terms::Of(fits) | Terms::Same(fits) => fits[i].support.clone(),
                Terms::Best(choices) => self.choice(choices[i], i),
            };
            let triangle = whitened(system, self.runs, &theta, &choice, i, errors)?;
            let target = choice.len();
            let selected = match terms {
                Terms::Same(_) => Selected::all(&triangle, target, ROUNDING),
                Terms::Best(_) | Terms::Of(_) => {
                    let complexity: Vec<u32> = choice.iter().map(|&j| system.terms[j].complexity).collect();
                    let floor = ROUNDING;
                    let selection = Selection { floor, complexity: &complexity, region: None };
                    self.solver.solve_while(&triangle, target, selection, self.watch.asks())
                }
            };
            misfit += triangle.residual_norm(&selected.support, &selected.coefficients, target).powi(2);
            condition = condition.max(triangle.condition(&selected.support));
            let selected = selected.renumbered(&choice);
            fits.push(match terms {
                Terms::Same(fits) => selected.found_by(&fits[i]),
                Terms::Best(_) | Terms::Of(_) => selected,
            });
        }
        let model = model(self.space.clone(), system.terms, &fits, stepping.form(), system.dt)?.with_offsets(offsets);
        Ok(Found { model, fits, stepping, condition, misfit })
    }

    /// The same with a verdict on each equation: whether its residual is no more than the errors of the samples, those that
    /// enter through the terms, and those of the Runge–Kutta steps.
    pub(super) fn judged(&self, mut found: Found) -> Result<Found, ModelError> {
        let offsets = found.model.offsets().to_vec();
        let judged = self.fit(found.stepping, &offsets, Some(&found.model), &Terms::Same(&found.fits))?;
        for (fit, verdict) in found.fits.iter_mut().zip(judged.fits) {
            fit.reached_floor = verdict.reached_floor;
            fit.residual = verdict.residual;
        }
        Ok(found)
    }

    /// The averages of the terms of `found` along the way of `model`, run by run.
    pub(super) fn averages_of(&self, found: &Found, model: &Model) -> Vec<Array2<f64>> {
        let used: Vec<usize> = found.fits.iter().flat_map(|f| f.support.iter().copied()).collect();
        let averages = |run| self.system.averages(run, found.stepping, Some(model), model.offsets(), &used);
        self.runs.iter().map(averages).collect()
    }

    /// Per state: RMS of Δx/Δt − Σ c θ̄ for the equations of `found` with the coefficients of `model`, and what of it the errors of
    /// the samples explain, in the unit of the rate.
    pub(crate) fn residuals(&self, found: &Found, model: &Model) -> Vec<(f64, f64)> {
        let rows = self.runs.iter().map(Run::len).sum::<usize>().max(1) as f64;
        let mut sums = vec![(0.0, 0.0); found.fits.len()];
        for (run, theta) in self.runs.iter().zip(self.averages_of(found, model)) {
            let extra = unseen(model, found.stepping, run, self.system.dt, true);
            for (i, fit) in found.fits.iter().enumerate() {
                for t in 0..run.len() {
                    let explained: f64 = fit
                        .support
                        .iter()
                        .zip(model.coefficients(i))
                        .map(|(&j, e)| e.coefficient * theta[[t, j]])
                        .sum();
                    let left = (run.x[[t + 1, i]] - run.x[[t, i]]) / self.system.dt - explained;
                    let seen = run.sigma[[t, i]].hypot(run.sigma[[t + 1, i]]) / self.system.dt;
                    sums[i].0 += left * left;
                    sums[i].1 += seen * seen + extra[[t, i]] * extra[[t, i]];
                }
            }
        }
        sums.into_iter().map(|(left, seen): (f64, f64)| ((left / rows).sqrt(), (seen / rows).sqrt())).collect()
    }
}

/// The triangle of [Θ of `allowed` | Δxᵢ/Δt], its rows whitened.
pub(super) fn whitened(
    system: &System<'_>,
    runs: &[Run],
    theta: &[Array2<f64>],
    allowed: &[usize],
    i: usize,
    extra: Option<&[Array2<f64>]>,
) -> Result<Triangle, ModelError> {
    let mut triangle = Triangle::new(allowed.len() + 1);
    for (at, (run, theta)) in runs.iter().zip(theta).enumerate() {
        let target = Array2::from_shape_fn((run.len(), 1), |(t, _)| (run.x[[t + 1, i]] - run.x[[t, i]]) / system.dt);
        let mut rows = concatenate![Axis(1), theta.select(Axis(1), allowed), target];
        let extra = extra.map_or_else(|| vec![0.0; run.len()], |e| e[at].column(i).to_vec());
        whiten(rows.view_mut(), &run.sigma.column(i).to_vec(), &extra, &vec![system.dt; run.len()]);
        triangle.push(rows.view()).map_err(|_| ModelError::BadNumber { what: "a term", value: f64::NAN })?;
    }
    Ok(triangle)
}

/// ẋ = v.
fn kinematic(system: &System<'_>, rate: usize) -> Selected {
    let term = system.terms.iter().position(|t| t.rate.is_none() && t.expr == Expr::Variable(rate));
    Selected {
        support: term.into_iter().collect(),
        coefficients: vec![1.0; usize::from(term.is_some())],
        residual: 0.0,
        reached_floor: true,
        proved: true,
        converged: true,
        path: Vec::new(),
        ties: Vec::new(),
    }
}
