//! Equations of which only the coefficients are fitted again.

use sindyna_core::FitError;

use super::Identifier;
use super::recording::Recording;
use crate::Expr;
use crate::coordinates::Coordinates;
use crate::data::{Segment, Smoother};
use crate::library::Term;
use crate::model::{Form, Model};
use crate::motion::Stepping;
use crate::shooting::{self, Bounds, Flow, Given, PARTS, Work};
use crate::{CoordinateMode, Watch};

/// Runge–Kutta steps per sampling interval: those of order eight, so that recordings without noise are followed to many digits.
const SUBSTEPS: usize = 16;

/// Steps of simulators by which these are told from others.
const SIMULATED: [Stepping; 3] =
    [Stepping::Euler, Stepping::SemiImplicit { substeps: 1 }, Stepping::Classical { substeps: 1 }];

/// Equations whose coefficients were fitted again.
#[derive(Debug, Clone, PartialEq)]
pub struct Refitted {
    /// −2 ln L, up to a constant.
    pub misfit: f64,
    /// Coefficients of the equations that are not declared rates, one equation after the other, as in [`Model::coefficients`].
    pub coefficients: Vec<f64>,
}

impl Identifier {
    /// −2 ln L of `recordings` with the equations of `model` and all states and inputs as linear terms, whose coefficients are fitted to them, and the noise of each state at its likeliest; up to a constant, which is that
    /// of all readings of the same samples. `None` if the equations cannot follow them, or are not continuous in time. With simulators, the least with steps of these.
    ///
    /// # Errors
    /// [`FitError`] if recordings do not have the spec's shape, or a state that was not measured is no rate of one that was.
    pub fn misfit(&self, model: &Model, recordings: &[Recording], watch: &Watch<'_>) -> Result<Option<f64>, FitError> {
        Ok(self.again(model, recordings, true, watch)?.map(|again| again.misfit))
    }

    /// The same with the terms of `model` alone, and their coefficients.
    ///
    /// # Errors
    /// As [`Self::misfit`].
    pub fn refitted(
        &self,
        model: &Model,
        recordings: &[Recording],
        watch: &Watch<'_>,
    ) -> Result<Option<Refitted>, FitError> {
        self.again(model, recordings, false, watch)
    }

    fn again(
        &self,
        model: &Model,
        recordings: &[Recording],
        linear: bool,
        watch: &Watch<'_>,
    ) -> Result<Option<Refitted>, FitError> {
        recordings.iter().try_for_each(|r| r.check(&self.spec))?;
        self.unmeasured(recordings)?;
        let rates = self.rates();
        if !matches!(model.form(), Form::Continuous(_)) || model.states().len() != rates.len() {
            return Ok(None);
        }
        let coordinates = Coordinates::new(&self.spec, CoordinateMode::Recognised)
            .map_err(|state| FitError::Regression { reason: format!("no observation shows the state `{state}`") })?;
        let segments: Vec<Segment> = recordings.iter().map(|r| r.known(&coordinates)).filter(|s| s.len() > 0).collect();
        let floor = self.smallest_errors(&coordinates, recordings);
        let signals = Smoother::new(&segments, &rates, &floor, watch.asks()).signals(&floor);
        let steppings = if self.simulators { &SIMULATED[..] } else { &[Stepping::Continuous { substeps: SUBSTEPS }] };
        let noise = Bounds { floor: &floor, shape: &signals.sigma };
        let samples: usize = segments.iter().map(|s| s.x.nrows()).sum();
        let is_measured = |i: &usize| segments.first().is_some_and(|s| s.measures(*i));
        let of = |stepping: &Stepping| {
            let (flow, xi) = free((model, linear), &rates, self.spec.control_dim(), *stepping);
            let work = (&Work::default(), watch.asks());
            let start = (&xi[..], &signals.x[..]);
            let fit = shooting::fit(&flow, &segments, start, &signals.sigma, noise, 0..PARTS.len(), work)?;
            let seen = |i: usize| fit.left[i].hypot(fit.drift[i]).max(fit.sigma[i]);
            let misfit = (0..rates.len()).filter(is_measured).map(|i| 2.0 * samples as f64 * seen(i).ln()).sum();
            Some(Refitted { misfit, coefficients: fit.xi })
        };
        Ok(steppings.iter().filter_map(of).min_by(|a, b| a.misfit.total_cmp(&b.misfit)))
    }
}

/// The terms of `model`, and which of them stand in the equation of each state, with their coefficients; none in those of states with declared `rates`.
pub(super) fn terms_of(model: &Model, rates: &[Option<usize>]) -> (Vec<Term>, Vec<Given>) {
    let exprs = model.shifted_terms();
    let (mut terms, mut given): (Vec<Term>, Vec<Given>) = (Vec::new(), vec![Given::new(); rates.len()]);
    for i in (0..rates.len()).filter(|&i| rates[i].is_none()) {
        for entry in model.coefficients(i) {
            given[i].push((terms.len(), entry.coefficient));
            let expr = exprs[entry.term].clone();
            terms.push(Term { expr, name: String::new(), complexity: 0, rate: entry.rate, shape: None });
        }
    }
    (terms, given)
}

/// The equations of `model`, stepped in this way, and their coefficients, which are free. If so, states and inputs are `linear` terms of every equation: of those that were read in a wrong way a model may have found nothing, and what
/// a delay does looks like damping.
fn free(
    (model, linear): (&Model, bool),
    rates: &[Option<usize>],
    n_controls: usize,
    stepping: Stepping,
) -> (Flow, Vec<f64>) {
    let (mut terms, mut rows) = terms_of(model, rates);
    let more = if linear { rates.len() + n_controls } else { 0 };
    for variable in (0..more).map(Expr::Variable) {
        for row in rows.iter_mut().zip(rates).filter_map(|(row, rate)| rate.is_none().then_some(row)) {
            if !row.iter().any(|(term, _)| terms[*term].expr == variable) {
                row.push((terms.len(), 0.0));
                terms.push(Term {
                    expr: variable.clone(),
                    name: String::new(),
                    complexity: 0,
                    rate: None,
                    shape: None,
                });
            }
        }
    }
    let supports: Vec<Vec<usize>> = rows.iter().map(|row| row.iter().map(|(term, _)| *term).collect()).collect();
    let xi = rows.iter().flatten().map(|(_, coefficient)| *coefficient).collect();
    let given = vec![Given::new(); rates.len()];
    (Flow::new(&terms, (&supports, &given, &[]), rates, n_controls, stepping), xi)
}
