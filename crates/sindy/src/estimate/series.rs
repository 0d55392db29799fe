//! Whether terms are the beginning of a series.

use super::hypothesis::Hypothesis;
use super::search::Problem;

/// Factor by which every true term makes what is left smaller, at least, where nothing is left with all of them.
const ESSENTIAL: f64 = 1e3;

impl Problem<'_> {
    /// Whether equation `i`, which leaves nothing, has a term without which not much more would be left. Of true terms each one explains what no
    /// others can; of those that approximate a function the last ones explain little.
    pub(super) fn is_series(&self, best: &Hypothesis, i: usize) -> bool {
        let size = best.supports[i].len();
        let Some(regression) = self.regression_near(best, i, size) else { return false };
        let own = (best.fit.left[i] / best.fit.sigma[i]).min(1.0);
        let fewer = regression.least_left(size.saturating_sub(1));
        fewer.is_some_and(|fewer| fewer < ESSENTIAL * own)
    }
}
