//! Equations of several joints, as one Lagrangian has them.

use super::System;
use super::found::{Found, Search};
use crate::library::{Input, Joints, Key, Term, term};
use crate::mechanics::{Mechanics, mechanics};
use crate::model::Model;
use crate::regression::model;
use crate::solve::Selected;

/// Change of a parameter, as part of its standard error or of itself, by which coefficients are derived.
const NUDGE: f64 = 1e-6;

/// Equations with the terms they are of.
pub(crate) struct Mechanical {
    pub(crate) terms: Vec<Term>,
    pub(crate) found: Found,
    /// Standard errors of the coefficients, one equation after the other.
    pub(crate) errors: Vec<f64>,
    /// Parameters that were fitted.
    unknowns: usize,
    /// Whether zeros of angles may be off.
    is_tilted: bool,
}

impl Search<'_> {
    /// The equations of `joints`, if one Lagrangian explains the steps to rounding; `inputs` are what the terms are of.
    pub(crate) fn mechanical(&self, joints: &Joints, inputs: &[Input]) -> Option<Mechanical> {
        let explains = |found: &Mechanics| self.of_mechanics(found, inputs);
        let few = (&self.few()[..], self.system.rates, self.system.dt);
        mechanics(joints, few, self.is_short(), explains, self.watch)
    }

    /// Equations that explain the steps with the zeros of angles elsewhere, and with no more numbers than `other`.
    pub(crate) fn tilted_instead(&self, other: &Mechanical) -> Option<Found> {
        if !other.is_tilted || !self.is_short() {
            return None;
        }
        let is_simpler = |found: &Found| {
            let is_tilted = found.model.offsets().iter().any(|offset| *offset != 0.0);
            is_tilted && found.model.fitted().len() <= other.unknowns
        };
        self.exactly().filter(is_simpler)
    }

    fn of_mechanics(&self, of: &Mechanics, inputs: &[Input]) -> Option<Mechanical> {
        let equations = of.lagrangian.equations(&of.parameters)?;
        let mut terms: Vec<Term> = Vec::new();
        let mut place = |(expr, rate): &Key| {
            let known = terms.iter().position(|t| t.rate == *rate && t.expr == *expr);
            known.unwrap_or_else(|| {
                terms.push(term(inputs, expr.clone(), *rate));
                terms.len() - 1
            })
        };
        let mut fits: Vec<Selected> = Vec::with_capacity(self.system.rates.len());
        for rate in self.system.rates {
            fits.push(selected(match rate {
                Some(rate) => vec![(place(&(crate::Expr::Variable(*rate), None)), 1.0)],
                None => Vec::new(),
            }));
        }
        for (equation, (_, speed)) in equations.iter().zip(&of.lagrangian.joints) {
            let mut own: Vec<(usize, f64)> = equation.iter().map(|(key, c)| (place(key), *c)).collect();
            own.sort_by_key(|(j, _)| *j);
            fits[*speed] = selected(own);
        }
        let space = self.space.clone();
        let model = model(space, &terms, &fits, of.stepping.form(), self.system.dt).ok()?;
        let errors = standard_errors(of, &model, &terms);
        let condition = of.triangle.condition(&(0..of.parameters.len() - 1).collect::<Vec<_>>());
        let mut found = Found { model, fits, stepping: of.stepping, condition, misfit: 0.0 };
        let system = System { terms: &terms, core: terms.len(), ..*self.system };
        let search = Search { system: &system, ..*self };
        let residuals = search.residuals(&found, &found.model);
        let explained = search.explained_by(&found, &found.model, &residuals);
        for ((fit, explained), residual) in found.fits.iter_mut().zip(explained).zip(residuals) {
            (fit.reached_floor, fit.residual) = (explained, residual.0);
        }
        let (unknowns, is_tilted) = (of.parameters.len() - 1, of.lagrangian.is_tilted(&of.parameters));
        found.explains().then_some(Mechanical { terms, found, errors, unknowns, is_tilted })
    }
}

/// Terms with coefficients.
fn selected(of: Vec<(usize, f64)>) -> Selected {
    let (support, coefficients) = of.into_iter().unzip();
    Selected {
        support,
        coefficients,
        residual: 0.0,
        reached_floor: true,
        proved: false,
        converged: true,
        path: Vec::new(),
        ties: Vec::new(),
    }
}

/// Standard errors of the coefficients of `model`, which follow from the parameters; in the order of [`Model::fitted`], without offsets.
fn standard_errors(of: &Mechanics, model: &Model, terms: &[Term]) -> Vec<f64> {
    let all: Vec<usize> = (0..of.parameters.len() - 1).collect();
    let spread = of.triangle.spread(&all);
    let coefficients = |parameters: &[(usize, f64)]| -> Option<Vec<f64>> {
        let equations = of.lagrangian.equations(parameters)?;
        let mut rows: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
        for (equation, (_, speed)) in equations.iter().zip(&of.lagrangian.joints) {
            let place = |key: &Key| terms.iter().position(|t| t.rate == key.1 && t.expr == key.0);
            let mut own: Vec<(usize, f64)> =
                equation.iter().map(|(key, c)| Some((place(key)?, *c))).collect::<Option<_>>()?;
            own.sort_by_key(|(j, _)| *j);
            rows.push((*speed, own));
        }
        rows.sort_by_key(|(speed, _)| *speed);
        Some(rows.into_iter().flat_map(|(_, own)| own.into_iter().map(|(_, c)| c)).collect())
    };
    let mut squares = vec![0.0; model.fitted().len()];
    for (j, error) in spread.iter().enumerate() {
        let mut moved = of.parameters.clone();
        let by = NUDGE * moved[1 + j].1;
        moved[1 + j].1 += by;
        let (Some(here), Some(there)) = (coefficients(&of.parameters), coefficients(&moved)) else { continue };
        for ((square, a), b) in squares.iter_mut().zip(here).zip(there) {
            *square += ((b - a) / by * error).powi(2);
        }
    }
    squares.into_iter().map(f64::sqrt).collect()
}
