//! What was found, and how much to believe it.

use super::rows::Rows;
use crate::Triangle;
use crate::library::Term;
use crate::model::Model;
use crate::motion::Found;
use crate::solve::{Selected, SizeReport};

/// An identified model and the account of how it was found.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The equations of motion.
    pub model: Model,
    /// The account.
    pub report: Report,
}

/// The account of an identification.
#[derive(Debug, Clone, PartialEq)]
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
    /// One entry per state.
    pub equations: Vec<EquationReport>,
}

/// The account of one equation.
#[derive(Debug, Clone, PartialEq)]
pub struct EquationReport {
    /// Name of the state.
    pub state: String,
    /// RMS residual, in the unit of the left-hand side.
    pub residual: f64,
    /// RMS residual that rounding of the observations explains; zero if it is not known.
    pub floor: f64,
    /// Whether the residual is no more than that: the equation is then exact as far as can be seen.
    pub reached_floor: bool,
    /// Whether every subset of the chosen size was looked at.
    pub proved: bool,
    /// Numbers of the chosen terms in [`Report::features`].
    pub support: Vec<usize>,
    /// Their coefficients.
    pub coefficients: Vec<f64>,
    /// Standard errors of these, infinite where the data do not determine them; empty where they are not known.
    pub standard_errors: Vec<f64>,
    /// The best subset of each size tried; empty for solvers that try none.
    pub path: Vec<SizeReport>,
    /// Other subsets that the data cannot tell from the chosen one; at most eight.
    pub ties: Vec<Vec<usize>>,
}

impl Report {
    /// The account of a fit by [`Search`](crate::motion::Search): `found`, with the `residuals` of each equation, and `model`,
    /// its coefficients polished, with their standard errors.
    pub(super) fn in_motion(
        names: &[String],
        terms: &[Term],
        (rows, rows_at_limit, rows_astray): (usize, usize, usize),
        found: Found,
        residuals: &[(f64, f64)],
        (model, errors): (&Model, &[f64]),
    ) -> Self {
        let feature = |t: &Term| match t.rate {
            None => t.expr.pretty(names).to_string(),
            Some(l) if t.expr.is_one() => format!("d{}/dt", names[l]),
            Some(l) => format!("{}·d{}/dt", t.expr.pretty(names).as_factor(), names[l]),
        };
        let offsets = model.offsets().iter().filter(|v| **v != 0.0).count();
        let mut errors = errors.iter().copied().skip(offsets);
        let equations = found.fits.into_iter().zip(names).enumerate().map(|(i, (fit, state))| {
            let kinematic = model.kinematic()[i];
            EquationReport {
                state: state.clone(),
                residual: residuals[i].0,
                floor: residuals[i].1,
                reached_floor: fit.reached_floor,
                proved: fit.proved,
                coefficients: model.coefficients(i).iter().map(|e| e.coefficient).collect(),
                standard_errors: if kinematic { Vec::new() } else { errors.by_ref().take(fit.support.len()).collect() },
                support: fit.support,
                path: fit.path,
                ties: fit.ties,
            }
        });
        Self {
            rows,
            rows_at_limit,
            rows_astray,
            features: terms.iter().map(feature).collect(),
            condition: found.condition,
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
            proved: fit.proved,
            standard_errors: triangle.spread(&fit.support).into_iter().map(|s| s * fit.residual).collect(),
            support: fit.support,
            coefficients: fit.coefficients,
            path: fit.path,
            ties: fit.ties,
        });
        Self {
            rows: rows.z.nrows(),
            rows_at_limit: rows.at_limit,
            rows_astray: 0,
            features: terms.iter().map(|t| t.expr.pretty(&names).to_string()).collect(),
            condition: triangle.condition(&all),
            equations: equations.collect(),
        }
    }
}
