//! Equations of motion from data whose errors are more than rounding.

use sindyna_core::FitError;

use super::Identifier;
use super::report::{Counts, Identified, Report};
use crate::data::Segment;
use crate::estimate::{Estimate, Problem, estimate};
use crate::library::{Term, general};
use crate::model::Model;
use crate::motion::{Run, Stepping, shown};
use crate::regression::{Space, model};
use crate::solve::Selected;
use crate::{BestSubset, Expr, LibraryChoice};

impl Identifier {
    /// The candidate terms when the data have noise: all at once, judged by one score.
    fn general_terms(&self, tiers: Vec<Term>, runs: &[Run]) -> Vec<Term> {
        if self.library != LibraryChoice::Auto {
            return tiers;
        }
        let inputs = self.inputs();
        let n = self.spec.state_dim();
        let lowest = |i: usize| {
            let values =
                runs.iter().flat_map(|r| if i < n { r.x.column(i).to_vec() } else { r.u.column(i - n).to_vec() });
            values.fold(f64::INFINITY, f64::min)
        };
        let positive: Vec<bool> = (0..inputs.len()).map(|i| lowest(i) > 0.0).collect();
        let mut terms = general(&inputs, &self.speeds(), &positive);
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

    /// Equations with the best score, with noise estimated. `None` if no equations follow the data.
    pub(super) fn estimated(
        &self,
        tiers: Vec<Term>,
        runs: &[Run],
        at_limits: usize,
        space: &Space,
        solver: &BestSubset,
    ) -> Result<Option<Identified>, FitError> {
        let failed = |reason: String| FitError::Regression { reason };
        let terms = self.general_terms(tiers, runs);
        let rates = self.rates();
        let segments: Vec<Segment> = runs.iter().map(|r| Segment::even(r, self.spec.dt)).collect();
        let floor: Vec<f64> = (0..rates.len())
            .map(|i| runs.iter().flat_map(|r| r.sigma.column(i).to_vec()).fold(0.0, f64::max))
            .collect();
        let n_controls = self.spec.control_dim();
        let problem = Problem { terms: &terms, rates: &rates, n_controls, segments: &segments, floor: &floor, solver };
        let stepping = shown(runs, &rates, self.spec.dt).unwrap_or(Stepping::Continuous { substeps: 1 });
        let Some(found) = estimate(&problem, stepping) else { return Ok(None) };
        let model = written(&found, &terms, &rates, space, self.spec.dt).map_err(failed)?;
        let rows = runs.iter().map(Run::len).sum();
        let counts = Counts { rows, at_limit: at_limits, astray: 0 };
        let report = Report::estimated(&self.names(), &terms, counts, &found, self.spec.dt);
        Ok(Some(Identified { model, report }))
    }
}

/// The model of the equations found.
fn written(found: &Estimate, terms: &[Term], rates: &[Option<usize>], space: &Space, dt: f64) -> Result<Model, String> {
    let fit = |(fit, rate): (&Selected, &Option<usize>)| match rate {
        None => fit.clone(),
        Some(v) => {
            let term = terms.iter().position(|t| t.rate.is_none() && t.expr == Expr::Variable(*v));
            Selected { support: term.into_iter().collect(), coefficients: vec![1.0], ..fit.clone() }
        }
    };
    let fits: Vec<Selected> = found.fits.iter().zip(rates).map(fit).collect();
    model(space.clone(), terms, &fits, found.stepping.form(), dt).map_err(|e| e.to_string())
}
