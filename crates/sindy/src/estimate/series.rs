//! Whether terms are the beginning of a series.

use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::white::is_white;

/// Factor by which every true term makes what is left smaller, at least, where nothing is left with all of them.
const ESSENTIAL: f64 = 1e3;

impl Problem<'_> {
    /// Whether equation `i` leaves nothing but what is correlated, and has a term without which not much more would be left. Of true terms each one
    /// explains what no others can; of those that approximate a function the last ones explain little.
    pub(super) fn is_series(&self, best: &Hypothesis, i: usize) -> bool {
        let white = best.innovations(self).is_some_and(|innovations| is_white(innovations, i));
        if white || self.rates[i].is_some() || !self.is_rounding(best) {
            return false;
        }
        let size = best.supports[i].len();
        let Some(regression) = self.regression_near(best, i, size) else { return false };
        let own = (best.fit.left[i] / best.fit.sigma[i]).min(1.0);
        regression.path().iter().any(|fewer| fewer.support.len() + 1 == size && fewer.residual < ESSENTIAL * own)
    }
}
