//! What an equation may be made of, and when it may be made of more.

use super::found::{Found, Search};
use crate::Expr;
use crate::model::ModelError;

/// What an equation may be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// The first tier.
    Core,
    /// The first tier, and waves times the derivative that the equation is for: a moment of inertia that depends on an angle.
    /// Where the angle hardly moves such a term explains a derivative by itself, so it is believed only if nothing is left
    /// to explain.
    Inertia,
    /// Both tiers.
    Wide,
}

impl Search<'_> {
    /// What `search` finds in the first tier, and where that does not explain the data, in more.
    pub(super) fn widening(
        &self,
        search: impl Fn(&[Choice], Option<&Found>) -> Result<Found, ModelError>,
    ) -> Result<Found, ModelError> {
        let mut found = search(&self.core(), None)?;
        for choice in [Choice::Inertia, Choice::Wide] {
            let Some(unexplained) = self.unexplained(&found) else { break };
            if choice == Choice::Inertia && !self.system.terms.iter().any(|t| t.rate.is_some()) {
                continue;
            }
            let more = |unexplained: &bool| if *unexplained { choice } else { Choice::Core };
            let choices: Vec<Choice> = unexplained.iter().map(more).collect();
            let Ok(wider) = search(&choices, Some(&found)) else { continue };
            if choice == Choice::Inertia {
                let count = |found: &Found| found.fits.iter().filter(|f| f.reached_floor).count();
                if count(&wider) > count(&found) && self.is_regular(&wider) {
                    found = wider;
                }
            } else if self.score(&wider) < self.score(&found) {
                found = wider;
            }
        }
        Ok(found)
    }

    /// Numbers of the terms equation `i` may have.
    pub(super) fn choice(&self, choice: Choice, i: usize) -> Vec<usize> {
        let system = self.system;
        let tried = if choice == Choice::Wide { system.terms.len() } else { system.core };
        let own = |j: usize| system.terms[j].rate == Some(i);
        let trivial = |j: usize| own(j) && (choice != Choice::Inertia || system.terms[j].expr.is_one());
        (0..tried).filter(|&j| !trivial(j)).collect()
    }

    pub(super) fn core(&self) -> Vec<Choice> {
        vec![Choice::Core; self.system.rates.len()]
    }

    /// Which equations the first tier does not explain down to the errors of the samples; `None` if there is none.
    fn unexplained(&self, found: &Found) -> Option<Vec<bool>> {
        let wide: Vec<bool> = found.fits.iter().map(|f| !f.reached_floor).collect();
        (self.system.core < self.system.terms.len() && wide.contains(&true)).then_some(wide)
    }

    /// Whether what each equation says of its own derivative, (1 − Σ c w) ẋ, is well away from nothing on all data.
    fn is_regular(&self, found: &Found) -> bool {
        /// Smallest part of 1 + Σ |c| that must be left.
        const LEFT: f64 = 0.1;
        let offsets = found.model.offsets();
        found.fits.iter().enumerate().all(|(i, fit)| {
            let own: Vec<(&Expr, f64)> = fit
                .support
                .iter()
                .zip(&fit.coefficients)
                .filter(|(j, _)| self.system.terms[**j].rate == Some(i))
                .map(|(j, c)| (&self.system.terms[*j].expr, *c))
                .collect();
            let least = LEFT * (1.0 + own.iter().map(|(_, c)| c.abs()).sum::<f64>());
            self.runs.iter().flat_map(|run| run.x.rows().into_iter().take(run.len()).zip(run.u.rows())).all(|(x, u)| {
                let shifted = x.iter().zip(offsets).map(|(x, d)| x + d);
                let z: Vec<f64> = shifted.chain(u.iter().copied()).collect();
                (1.0 - own.iter().map(|(w, c)| c * w.eval(&z)).sum::<f64>()).abs() >= least
            })
        })
    }
}
