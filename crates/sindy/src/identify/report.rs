//! What was found, and how much to believe it.

use super::feature::feature;
use super::models::Models;
use super::rows::Rows;
use super::warnings;
use crate::Triangle;
use crate::estimate::{Doubt, Estimate};
use crate::library::Term;
use crate::model::{Model, as_text};
use crate::motion::Found;
use crate::solve::{Selected, SizeReport, binomial};
use serde::{Deserialize, Serialize};

/// An identified model and the account of how it was found.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Identified {
    /// The equations of motion.
    #[serde(with = "as_text")]
    pub model: Model,
    /// The account.
    pub report: Report,
    /// The models that the data allow, where the noise was estimated.
    pub models: Option<Models>,
}

impl Identified {
    /// The same equations over control intervals of `dt` \[s\]; `None` where only what one interval leads to is known.
    #[must_use]
    pub fn over_intervals(self, dt: f64) -> Option<Self> {
        let models = match self.models {
            Some(models) => Some(models.over_intervals(dt)?),
            None => None,
        };
        Some(Self { model: self.model.over_intervals(dt)?, models, ..self })
    }

    /// The same where coefficients depend on something else that was estimated, with the standard error one: by `slopes`, of the equations that are not declared rates, one equation after the other as in
    /// [`Model::coefficients`]. Standard errors and models that the data allow contain it.
    #[must_use]
    pub fn depending(mut self, slopes: &[f64]) -> Self {
        let mut slopes_left = slopes.iter();
        for (i, equation) in self.report.equations.iter_mut().enumerate().filter(|(i, _)| !self.model.kinematic()[*i]) {
            for (entry, slope) in self.model.coefficients(i).iter().zip(&mut slopes_left) {
                let place = equation.coefficients.iter().position(|c| c.to_bits() == entry.coefficient.to_bits());
                if let Some(error) = place.and_then(|place| equation.standard_errors.get_mut(place)) {
                    *error = error.hypot(*slope);
                }
            }
        }
        self.models = self.models.map(|models| models.depending(slopes));
        self
    }
}

/// The account of an identification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Steps that went into the regression.
    pub rows: usize,
    /// Steps left out because an observation sat at a declared limit.
    pub rows_at_limit: usize,
    /// Steps left out because they do not follow the equations of all the others: impacts, end stops, undeclared limits.
    pub rows_astray: usize,
    /// Candidate terms, as people write them.
    pub features: Vec<String>,
    /// Condition number of the candidate columns, each scaled to unit length; infinite with fewer rows than terms.
    pub condition: f64,
    /// Where the size of the samples' errors comes from.
    pub noise: Noise,
    /// RMS difference of each state as measured and as it follows from the equations \[unit of the state\] (n), where it was
    /// estimated; else empty.
    pub noise_deviations: Vec<f64>,
    /// Share of the variance of each state's noise that grows with the square of its value (n): 0 for noise that is the same everywhere, 1
    /// for noise of so many per cent; empty where the noise was not estimated.
    pub noise_growing: Vec<f64>,
    /// Normalised root mean square error as a goodness of fit, 1 − ‖x − x̂‖/‖x − mean x‖ (n), of the states x̂ that follow the
    /// equations along each recording from a start that is estimated too; empty where the noise was not estimated.
    pub fit: Vec<f64>,
    /// States that were not measured, ascending.
    #[serde(default)]
    pub unmeasured: Vec<usize>,
    /// Whether the search tried all it would; it ends early where the data are many and the terms too. Terms with parameters inside have a share of
    /// the effort, and that this share was used up is not told here.
    pub search_complete: bool,
    /// −2 ln L of what was measured, with what terms and parameters cost (extended BIC); the smaller of two of the same data is the better one. `None`
    /// where the noise was not estimated.
    #[serde(default)]
    pub score: Option<f64>,
    /// What the data do not show, in sentences: inputs that never change, states that change too much from sample to sample.
    pub warnings: Vec<String>,
    /// One entry per state.
    pub equations: Vec<EquationReport>,
}

/// Where the size of the samples' errors comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Noise {
    /// Only rounding: equations explain the data down to it.
    Rounding,
    /// It was declared.
    Declared,
    /// It was estimated from the data, and again from what the equations leave.
    Estimated,
}

impl EquationReport {
    /// Whether it leaves what none of the terms explains: a state may not have been measured.
    #[must_use]
    pub fn is_spoilt(&self) -> bool {
        self.doubt.is_some_and(Doubt::is_spoilt)
    }
}

/// The account of one equation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EquationReport {
    /// Name of the state.
    pub state: String,
    /// RMS residual, in the unit of the left-hand side.
    pub residual: f64,
    /// RMS residual that rounding of the observations explains; zero if it is not known.
    pub floor: f64,
    /// Whether the equation is adequate: its residual no more than that, and where the noise is estimated, uncorrelated from sample to
    /// sample and no other terms as good.
    pub reached_floor: bool,
    /// Why it is not adequate, where the noise was estimated.
    pub doubt: Option<Doubt>,
    /// Whether every subset of the chosen size was looked at.
    pub proved: bool,
    /// Numbers of the chosen terms in [`Report::features`].
    pub support: Vec<usize>,
    /// Their coefficients.
    pub coefficients: Vec<f64>,
    /// How many of the terms, the last ones, are parts of the equation that were known, with coefficients that were given.
    pub n_known: usize,
    /// Standard errors of these, infinite where the data do not determine them; empty where they are not known.
    pub standard_errors: Vec<f64>,
    /// Parameters inside its terms, such as c of tanh(v/c).
    pub parameters: Vec<InsideParameter>,
    /// The best subset of each size tried; empty for solvers that try none.
    pub path: Vec<SizeReport>,
    /// Other subsets that the data cannot tell from the chosen one; at most eight.
    pub equally_good: Vec<Vec<usize>>,
}

/// A parameter inside a term that was fitted with the coefficients.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InsideParameter {
    /// Number of the term in [`Report::features`]; a parameter of a term in several equations is the same in all of them.
    pub term: usize,
    /// Its value.
    pub value: f64,
    /// The standard error of that; infinite where the data do not determine it.
    pub standard_error: f64,
}

/// Steps by what became of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counts {
    pub(super) rows: usize,
    pub(super) at_limit: usize,
    pub(super) astray: usize,
}

/// The parameters inside the terms of one equation.
fn inside(found: &Estimate, support: &[usize]) -> Vec<InsideParameter> {
    let own = found.inside.iter().filter(|(j, _)| support.contains(j));
    own.flat_map(|(j, values)| {
        values.iter().map(|&(value, standard_error)| InsideParameter { term: *j, value, standard_error })
    })
    .collect()
}

/// Standard errors that a coefficient is at least: the interval of 95 % of another contains zero.
const DETERMINED: f64 = 2.0;

/// That a coefficient is below two standard errors; those of equations that are solved for together are not known.
fn undetermined(coefficients: &[f64], errors: &[f64]) -> Option<Doubt> {
    let is_below = |(c, error): (&f64, &f64)| error.is_finite() && DETERMINED * *error > c.abs();
    coefficients.iter().zip(errors).any(is_below).then_some(Doubt::Undetermined)
}

impl Report {
    /// The account of a fit by [`Search`](crate::motion::Search): `found`, with the `residuals` of each equation, and `model`,
    /// its coefficients polished, with their standard errors.
    pub(super) fn in_motion(
        names: &[String],
        terms: &[Term],
        counts: Counts,
        noise: Noise,
        found: Found,
        residuals: &[(f64, f64)],
        (model, errors): (&Model, &[f64]),
    ) -> Self {
        let offsets = model.offsets().iter().filter(|v| **v != 0.0).count();
        let mut errors = errors.iter().copied().skip(offsets);
        let equations = found.fits.into_iter().zip(names).enumerate().map(|(i, (fit, state))| {
            let kinematic = model.kinematic()[i];
            let coefficients: Vec<f64> = model.coefficients(i).iter().map(|e| e.coefficient).collect();
            let standard_errors: Vec<f64> =
                if kinematic { Vec::new() } else { errors.by_ref().take(fit.support.len()).collect() };
            let doubt = fit.reached_floor.then(|| undetermined(&coefficients, &standard_errors)).flatten();
            EquationReport {
                state: state.clone(),
                residual: residuals[i].0,
                floor: residuals[i].1,
                reached_floor: fit.reached_floor && doubt.is_none(),
                doubt,
                proved: fit.proved,
                n_known: 0,
                parameters: Vec::new(),
                coefficients,
                standard_errors,
                support: fit.support,
                path: fit.path,
                equally_good: fit.ties,
            }
        });
        Self {
            rows: counts.rows,
            rows_at_limit: counts.at_limit,
            rows_astray: counts.astray,
            features: terms.iter().map(|t| feature(t, names)).collect(),
            condition: found.condition,
            noise,
            noise_deviations: Vec::new(),
            noise_growing: Vec::new(),
            fit: Vec::new(),
            unmeasured: Vec::new(),
            search_complete: true,
            score: None,
            warnings: Vec::new(),
            equations: equations.collect(),
        }
    }

    /// The account of an estimate. Residuals are those of one step: what the noise of both samples adds to Δx/Δt.
    pub(super) fn estimated(names: &[String], counts: Counts, found: &Estimate, dt: f64) -> Self {
        // Of a rate that was not measured: what noise of the state that was adds to its second or third differences.
        let of_a_step = |levels: &[f64], i: usize| {
            let (head, order) = measured(found, i);
            binomial(2 * order, order).sqrt() * levels[head] / dt.powi(order as i32)
        };
        let of_noise = |values: &Vec<f64>| if found.rounding.is_some() { Vec::new() } else { values.clone() };
        let doubt = |i: usize| found.doubts[i].or_else(|| undetermined(&found.fits[i].coefficients, &found.errors[i]));
        let equations = found.fits.iter().zip(names).enumerate().map(|(i, (fit, state))| EquationReport {
            state: state.clone(),
            residual: of_a_step(&found.sigma, i),
            floor: of_a_step(found.rounding.as_ref().unwrap_or(&found.signal_noise), i),
            reached_floor: doubt(i).is_none(),
            doubt: doubt(i),
            proved: false,
            n_known: found.n_known[i],
            parameters: inside(found, &fit.support),
            support: fit.support.clone(),
            coefficients: fit.coefficients.clone(),
            standard_errors: found.errors[i].clone(),
            path: fit.path.clone(),
            equally_good: fit.ties.clone(),
        });
        Self {
            rows: counts.rows,
            rows_at_limit: counts.at_limit,
            rows_astray: counts.astray,
            features: found.terms.iter().map(|t| feature(t, names)).collect(),
            condition: found.condition,
            noise: if found.rounding.is_some() { Noise::Rounding } else { Noise::Estimated },
            noise_deviations: of_noise(&found.sigma),
            noise_growing: of_noise(&found.growing),
            fit: of_noise(&found.fit),
            search_complete: found.complete,
            unmeasured: (0..found.measured.len()).filter(|&i| !found.measured[i]).collect(),
            score: Some(found.score).filter(|score| score.is_finite()),
            warnings: warnings::of(names, found),
            equations: equations.collect(),
        }
    }

    pub(super) fn new(
        names: Vec<String>,
        terms: &[Term],
        rows: &Rows,
        triangle: &Triangle,
        fits: Vec<Selected>,
    ) -> Self {
        let all: Vec<usize> = (0..terms.len()).collect();
        let equations = fits.into_iter().zip(&names).zip(&rows.floor).map(|((fit, state), floor)| EquationReport {
            state: state.clone(),
            residual: fit.residual,
            floor: *floor,
            reached_floor: fit.reached_floor,
            doubt: None,
            proved: fit.proved,
            n_known: 0,
            parameters: Vec::new(),
            standard_errors: triangle.spread(&fit.support).into_iter().map(|s| s * fit.residual).collect(),
            support: fit.support,
            coefficients: fit.coefficients,
            path: fit.path,
            equally_good: fit.ties,
        });
        Self {
            rows: rows.z.nrows(),
            rows_at_limit: rows.at_limit,
            rows_astray: 0,
            features: terms.iter().map(|t| t.expr.pretty(&names).to_string()).collect(),
            condition: triangle.condition(&all),
            noise: Noise::Rounding,
            noise_deviations: Vec::new(),
            noise_growing: Vec::new(),
            fit: Vec::new(),
            unmeasured: Vec::new(),
            search_complete: true,
            score: None,
            warnings: Vec::new(),
            equations: equations.collect(),
        }
    }
}

/// The state that was measured of which state `i` is the rate, or the rate of its rate, and the order of the derivative that the equation of `i` is about: 1 for a
/// state that was measured.
fn measured(found: &Estimate, mut i: usize) -> (usize, usize) {
    for order in 1..=found.measured.len() {
        if found.measured[i] {
            return (i, order);
        }
        i = found.rates.iter().position(|rate| *rate == Some(i)).unwrap_or(i);
    }
    (i, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_below_two_standard_errors_are_not_determined() {
        assert_eq!(undetermined(&[3.0, -1.0], &[0.1, 0.6]), Some(Doubt::Undetermined));
        assert_eq!(undetermined(&[3.0, -1.0], &[0.1, 0.4]), None);
        // Known parts have no errors, and those of equations that are solved for together are not known.
        assert_eq!(undetermined(&[3.0, 2.0], &[0.0, f64::INFINITY]), None);
    }
}
