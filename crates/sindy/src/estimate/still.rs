//! States that noise hides.

use super::hypothesis::Hypothesis;
use super::problem::Problem;

impl Problem<'_> {
    /// Whether equation `i` has a term of a state whose own equation has none, and which is the same in all segments as far as its noise lets see. A factor that is not
    /// known is no more than a constant, and one that has any value with the coefficient to match it.
    pub(super) fn has_still_state(&self, best: &Hypothesis, i: usize) -> bool {
        let is_still = |k: &usize| {
            let own = best.supports[*k].is_empty()
                && self.rates[*k].is_none()
                && self.given().get(*k).is_none_or(Vec::is_empty);
            own && best.fit.sigma[*k] > self.floor[*k] && !self.differs(best, *k)
        };
        (0..self.rates.len()).filter(is_still).any(|k| best.supports[i].iter().any(|&j| self.terms[j].expr.has(k)))
    }

    /// Whether no equation has a term, though states vary: by their noise, or by what no candidate term describes.
    pub(super) fn finds_no_motion(&self, best: &Hypothesis) -> bool {
        let varies = |k: usize| best.fit.sigma[k] > self.floor[k];
        best.supports.iter().all(Vec::is_empty)
            && self.rates.iter().all(Option::is_none)
            && self.given().iter().all(Vec::is_empty)
            && (0..self.rates.len()).any(varies)
    }

    /// Whether the state `k`, constant in each segment, has values whose differences its noise does not explain.
    fn differs(&self, best: &Hypothesis, k: usize) -> bool {
        let mut values: Vec<(f64, f64)> =
            best.fit.x.iter().map(|x| (x[[0, k]], best.fit.sigma[k] / (x.nrows() as f64).sqrt())).collect();
        values.sort_by(|one, other| one.0.total_cmp(&other.0));
        values.windows(2).any(|pair| pair[1].0 - pair[0].0 > APART * pair[0].1.hypot(pair[1].1))
    }
}

/// Standard errors by which two values differ.
const APART: f64 = 5.0;
