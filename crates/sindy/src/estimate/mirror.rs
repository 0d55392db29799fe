//! Kinks from their other side: max(x − c, 0) = max(c − x, 0) + x − c.

use super::hypothesis::{Hypothesis, Start};
use super::problem::Problem;
use crate::Expr;

/// Part of two coefficients by which they may differ and be the same to rounding.
const NOTHING: f64 = 1e-6;

impl Problem<'_> {
    /// Writes every positive part of `best` from its other side, where the equation needs fewer terms then.
    pub(super) fn mirror(&self, best: &mut Hypothesis) {
        for i in 0..best.supports.len() {
            for j in best.supports[i].clone() {
                let Some(mut other) = self.mirrored(best, i, j) else { continue };
                self.prune(&mut other);
                if other.supports[i].len() < best.supports[i].len() && other.score < best.score {
                    *best = other;
                }
            }
        }
    }

    /// `best` with the mirror image of term `j` in equation `i`, and with the linear terms by which the two differ.
    fn mirrored(&self, best: &Hypothesis, i: usize, j: usize) -> Option<Hypothesis> {
        let shape = self.terms[j].shape.as_ref()?;
        let sign = shape.kink()?;
        let is_image = |k: &usize| self.terms[*k].shape.as_ref().is_some_and(|other| other.is_mirrored(shape));
        let image = (self.n_plain..self.terms.len()).find(is_image)?;
        let fitted = best.inside.iter().find(|(k, _)| *k == j)?.1.clone();
        let at = shape.values(&fitted);
        let named =
            |expr: &Expr| (0..self.n_plain).find(|&k| self.terms[k].rate.is_none() && self.terms[k].expr == *expr);
        let variable = (0..self.rates.len() + self.n_controls).find(|&v| shape.plainest().has(v))?;
        let (linear, one) = (named(&Expr::Variable(variable))?, named(&Expr::Constant(1.0))?);
        let first: usize = best.supports[..i].iter().map(Vec::len).sum();
        let own = &best.supports[i];
        let mut told: Vec<(usize, f64)> = own.iter().copied().zip(best.fit.xi[first..].iter().copied()).collect();
        let coefficient = told.iter().find(|(k, _)| *k == j)?.1;
        told.retain(|(k, _)| *k != j);
        for (term, change) in [(image, coefficient), (linear, sign * coefficient), (one, -sign * coefficient * at[0])] {
            match told.iter_mut().find(|(k, _)| *k == term) {
                // Others that the noise leaves are pruned.
                Some((_, value)) if (*value + change).abs() <= NOTHING * change.abs() => {
                    told.retain(|(k, _)| *k != term)
                }
                Some((_, value)) => *value += change,
                None => told.push((term, change)),
            }
        }
        told.sort_by_key(|(k, _)| *k);
        let mut supports = best.supports.clone();
        supports[i] = told.iter().map(|(k, _)| *k).collect();
        let mut xi = best.coefficients().to_vec();
        xi.splice(first..first + own.len(), told.iter().map(|(_, c)| *c));
        let inside: Vec<_> = best.inside.iter().cloned().chain([(image, fitted)]).collect();
        self.hypothesis(supports, best.flow.stepping(), Start { xi: &xi, inside: &inside, ..best.start() }, 3..4)
    }
}
