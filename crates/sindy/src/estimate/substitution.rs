//! Equations that say the same of a system once derivatives in them are replaced by what other equations say of these.

use super::problem::Problem;
use crate::Expr;

/// A term: a factor, and the state whose derivative it multiplies.
type Product = (Option<usize>, Expr);

impl Problem<'_> {
    /// Whether the terms `other` in equation `i`, with every derivative replaced by the terms of its equation in `supports`, are among those that equation
    /// i has there.
    pub(super) fn are_the_same_by_substitution(&self, other: &[usize], supports: &[Vec<usize>], i: usize) -> bool {
        let own: Vec<Product> = supports[i].iter().map(|&j| self.product(j)).collect();
        let is_own = |product: &Product| own.contains(product);
        let replaced = |j: &usize| {
            let (rate, factor) = self.product(*j);
            let Some(l) = rate else { return false };
            let each = |&k: &usize| {
                let (inner, term) = self.product(k);
                let either = [factor.clone().times(term.clone()), term.times(factor.clone())];
                either.into_iter().any(|product| is_own(&(inner, product)))
            };
            l != i && !supports[l].is_empty() && supports[l].iter().all(each)
        };
        other.iter().all(|j| is_own(&self.product(*j)) || replaced(j))
    }

    fn product(&self, j: usize) -> Product {
        let term = &self.terms[j];
        (term.rate, term.expr.clone())
    }
}
