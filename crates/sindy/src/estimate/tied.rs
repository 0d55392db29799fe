//! Equations whose coefficients the parameters of one Lagrangian tie together, held against the data as they are.

use std::cell::Cell;

use nalgebra::{DMatrix, DVector};

use super::account::{BEYOND, Doubt, Estimate, ROWS_A_TERM};
use super::constancy::distance;
use super::constraints::Constraints;
use super::hypothesis::{FLOOR, Hypothesis, Start, TOLD_APART};
use super::posterior::Posterior;
use super::problem::Problem;
use super::strays::Kept;
use super::white::by_chance;
use crate::data::{Segment, Signals, without_glitches};
use crate::mechanics::{Equations, Tied, condition};
use crate::motion::Stepping;
use crate::shooting::Flow;
use crate::solve::{Selected, binomial};

/// Rounds of Gauss–Newton over the parameters, and the change, in standard errors of each, below which one has settled.
const ROUNDS: usize = 8;
const SETTLED: f64 = 0.1;

/// Parameters that were fitted to all data at once.
#[derive(Clone)]
struct Fitted {
    theta: Vec<f64>,
    /// Of the parameters beside the unit.
    covariance: DMatrix<f64>,
    /// The hypothesis with all coefficients given.
    found: Hypothesis,
    /// The same with coefficients of their own.
    free: Hypothesis,
    /// Their derivatives by the parameters beside the unit.
    slopes: DMatrix<f64>,
    /// How far the halves of the data are apart; `None` where one of them does not determine all parameters.
    apart: Option<f64>,
}

/// Whether the `equations` of a Lagrangian with parameters `theta` that were fitted to the samples of `problem` leave noise alone of these.
pub(crate) fn leaves_noise(
    problem: &Problem<'_>,
    (equations, theta): (&Equations, &[f64]),
    signals: &Signals,
    stepping: Stepping,
) -> bool {
    let Some(constraints) = given(equations, theta) else { return false };
    let problem = Problem {
        terms: &equations.terms,
        n_plain: equations.terms.len(),
        constraints: &constraints,
        noise: &signals.sigma,
        spent: &Cell::new(0),
        of_parts: None,
        mechanics: &[],
        ..*problem
    };
    let start = Start { xi: &[], inside: &[], x: &signals.x, sigma: &signals.sigma };
    let none = || vec![Vec::new(); problem.rates.len()];
    let found = problem.hypothesis(none(), stepping, start, 0..4).map(|found| problem.as_simulated(found));
    let again =
        |right: &Problem<'_>, begun: &Hypothesis| right.hypothesis(none(), begun.flow.stepping(), begun.start(), 2..4);
    found.is_some_and(|found| {
        problem.is_settled(&found) || problem.corrected(&found, &|found| (found, None), &again).is_some()
    })
}

/// The coefficients of `equations` at `theta`, as all that each equation has.
fn given(equations: &Equations, theta: &[f64]) -> Option<Vec<Constraints>> {
    let mut rest = equations.coefficients(theta)?.into_iter();
    let is_rate = equations.model.kinematic();
    let of = |(support, is_rate): (&Vec<usize>, &bool)| Constraints {
        fixed: if *is_rate { Vec::new() } else { support.iter().copied().zip(rest.by_ref()).collect() },
        ..Constraints::default()
    };
    Some(equations.supports.iter().zip(is_rate).map(of).collect())
}

/// What a Lagrangian comes to.
pub(crate) enum Judged {
    /// Nothing speaks against its equations but others that are as good.
    Adequate(Box<Estimate>),
    /// They leave noise alone of the data with corrected inputs, to which its parameters are to be chosen anew.
    Rounded(Kept),
    /// They leave more than noise, or the data do not agree on them.
    Inadequate,
}

/// The `equations` of a Lagrangian with the parameters of `tied`, fitted to all data at once, and whether anything speaks against them: they leave noise alone, and the halves of the data
/// agree on all parameters.
pub(crate) fn judged(problem: &Problem<'_>, (equations, tied): (&Equations, &Tied), stepping: Stepping) -> Judged {
    let n = problem.rates.len();
    let (segments, glitches) =
        without_glitches(problem.segments, problem.floor).unwrap_or((problem.segments.to_vec(), 0));
    let problem = Problem {
        terms: &equations.terms,
        n_plain: equations.terms.len(),
        segments: &segments,
        spent: &Cell::new(0),
        of_parts: None,
        mechanics: &[],
        ..*problem
    };
    let signals = problem.smoother().signals(problem.floor);
    let problem = Problem { noise: &signals.sigma, ..problem };
    let Some(fitted) = problem.fitted_together(equations, &tied.theta, (&signals, stepping)) else {
        return Judged::Inadequate;
    };
    if !problem.is_settled(&fitted.found) {
        let again =
            |right: &Problem<'_>, begun: &Fitted| right.fitted_together(equations, &begun.theta, (&signals, stepping));
        let problem = Problem { spent: &Cell::new(0), ..problem };
        let right = problem.corrected(&fitted, &|fitted| (&fitted.free, Some(&fitted.slopes)), &again);
        return right.map_or(Judged::Inadequate, |(right, _)| Judged::Rounded(Kept { astray: glitches, ..right }));
    }
    let left = &fitted.found.fit.left;
    let is_large = |i: usize| left[i] > BEYOND * signals.sigma[i].max(problem.floor[i]);
    let adequate = !(0..n).any(is_large)
        && problem.samples() * n as f64 >= 2.0 * ROWS_A_TERM * tied.theta.len() as f64
        && fitted.apart.is_none_or(|d| d < by_chance(tied.theta.len() - 1));
    let found = if adequate { problem.of_tied((equations, tied), fitted, &signals) } else { None };
    found.map_or(Judged::Inadequate, |found| Judged::Adequate(Box::new(Estimate { astray: glitches, ..found })))
}

impl Problem<'_> {
    /// The parameters of `tied` fitted to whole trajectories; `None` where these do not settle.
    fn fitted_together(
        &self,
        equations: &Equations,
        begun: &[f64],
        (signals, stepping): (&Signals, Stepping),
    ) -> Option<Fitted> {
        let n = self.rates.len();
        let is_rate = equations.model.kinematic();
        let own = |i: usize| if is_rate[i] { Vec::new() } else { equations.supports[i].clone() };
        let supports: Vec<Vec<usize>> = (0..n).map(own).collect();
        let mut theta = begun.to_vec();
        let (mut x, mut sigma) = (signals.x.clone(), signals.sigma.clone());
        let mut errors = Vec::new();
        for _ in 0..ROUNDS {
            let xi = equations.coefficients(&theta)?;
            errors.resize(xi.len(), 0.0);
            let constraints = given(equations, &theta)?;
            let problem = Problem { constraints: &constraints, ..*self };
            let start = Start { xi: &[], inside: &[], x: &x, sigma: &sigma };
            let found = problem.hypothesis(vec![Vec::new(); n], stepping, start, 0..4)?;
            let flow = Flow::new(self.terms, (&supports, &[], &[]), self.rates, self.n_controls, found.flow.stepping());
            let mut free = found.clone();
            (free.flow, free.supports, free.fit.xi, free.fit.errors) = (flow, supports.clone(), xi, errors);
            let slopes = equations.slopes(&theta)?;
            let by_theta = |first: usize, last: usize| {
                let (triangle, volume) = self.told_by(&free, first, last)?;
                let column = |j: usize| (0..slopes.nrows()).map(|i| (i, slopes[(i, j)])).collect();
                let target = vec![(slopes.nrows(), 1.0)];
                let columns: Vec<Vec<(usize, f64)>> = (0..slopes.ncols()).map(column).chain([target]).collect();
                let tied = triangle.combined(&columns);
                let mut moved = tied.solve_unit(&(0..slopes.ncols()).collect::<Vec<_>>(), slopes.ncols());
                if let Some(volume) = volume {
                    let shift = tied.shift((slopes.transpose() * DVector::from_vec(volume)).as_slice())?;
                    moved.iter_mut().zip(shift).for_each(|(moved, shift)| *moved -= shift);
                }
                Some((tied, moved))
            };
            let total: usize = self.segments.iter().map(Segment::len).sum();
            let (triangle, moved) = by_theta(0, total)?;
            let inverse = triangle.inverse()?;
            let covariance = &inverse * inverse.transpose();
            let change = |(j, by): (usize, &f64)| by.abs() / covariance[(j, j)].sqrt();
            let largest = moved.iter().enumerate().map(change).fold(0.0, f64::max);
            if largest < SETTLED {
                let found = problem.as_simulated(found);
                let halves = (by_theta(0, total / 2)?, by_theta(total / 2, total)?);
                let all: Vec<usize> = (0..moved.len()).collect();
                let apart = distance(&halves.0, &halves.1, &all);
                return Some(Fitted { theta, covariance, found, free, slopes, apart });
            }
            let of_xi = &slopes * &covariance * slopes.transpose();
            errors = of_xi.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
            theta[1..].iter_mut().zip(&moved).for_each(|(theta, by)| *theta += by);
            (x, sigma) = (found.fit.x.clone(), found.fit.sigma.clone());
        }
        None
    }

    /// What was found.
    fn of_tied(&self, (equations, tied): (&Equations, &Tied), fitted: Fitted, signals: &Signals) -> Option<Estimate> {
        let n = self.rates.len();
        let told = self.whatever_the_inputs((&fitted.free, Some(&fitted.slopes)));
        let Fitted { mut theta, mut covariance, found, .. } = fitted;
        if let Some((told, inverse)) = told.and_then(|told| Some((told.change, told.triangle.inverse()?))) {
            theta[1..].iter_mut().zip(&told).for_each(|(theta, by)| *theta += by);
            covariance = &inverse * inverse.transpose();
        }
        let rivals = (tied.nearest <= TOLD_APART).then_some(Doubt::OtherTerms);
        let doubt = (tied.linear > TOLD_APART).then_some(Doubt::NotHeld).or(rivals);
        let xi = equations.coefficients(&theta)?;
        let by_theta = equations.slopes(&theta)?;
        let of_xi = &by_theta * &covariance * by_theta.transpose();
        let mut told = xi.iter().enumerate().map(|(j, c)| (*c, of_xi[(j, j)].max(0.0).sqrt()));
        let is_rate = equations.model.kinematic();
        let (mut fits, mut errors) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for (i, support) in equations.supports.iter().enumerate() {
            let own: Vec<(f64, f64)> = told.by_ref().take(if is_rate[i] { 0 } else { support.len() }).collect();
            fits.push(Selected {
                support: support.clone(),
                coefficients: if is_rate[i] { vec![1.0] } else { own.iter().map(|(c, _)| *c).collect() },
                residual: found.fit.left[i],
                reached_floor: is_rate[i] || doubt.is_none(),
                proved: false,
                converged: true,
                path: Vec::new(),
                ties: Vec::new(),
            });
            errors.push(own.into_iter().map(|(_, error)| error).collect());
        }
        let drawn = equations.drawn(&theta, &covariance);
        let size = theta.len();
        let ways = binomial(tied.lagrangian.parameters.len(), size);
        let of_spread = |i: usize| {
            if self.measures(i) && found.fit.left[i] < self.spread(i) {
                1.0 - found.fit.left[i] / self.spread(i)
            } else {
                f64::NAN
            }
        };
        Some(Estimate {
            posterior: Posterior::of_draws(equations.terms.clone(), self.rates, &equations.supports, drawn),
            terms: equations.terms.clone(),
            inside: Vec::new(),
            fits,
            twins: Vec::new(),
            contradicted: vec![Vec::new(); n],
            n_known: vec![0; n],
            errors,
            stepping: self.classical(&found),
            condition: condition(&covariance),
            sigma: found.fit.left.clone(),
            signal_noise: signals.sigma.clone(),
            measured: (0..n).map(|i| self.measures(i)).collect(),
            rates: self.rates.to_vec(),
            path: found.fit.x.clone(),
            score: found.score + size as f64 * self.samples().ln() + 2.0 * ways.ln(),
            astray: 0,
            growing: vec![0.0; n],
            doubts: is_rate.iter().map(|is_rate| doubt.filter(|_| !is_rate)).collect(),
            fit: (0..n).map(of_spread).collect(),
            complete: true,
            corrections: self.corrected_inputs(),
            leaves_nothing: self.leaves_nothing(&found),
            rounding: self.is_rounding(&found).then(|| self.floor.iter().map(|floor| FLOOR * floor).collect()),
        })
    }
}
