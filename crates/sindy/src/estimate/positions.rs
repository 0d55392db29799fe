//! Positions without rates do not show how a simulator moved them.

use std::cell::Cell;

use super::account::Estimate;
use super::problem::Problem;
use super::search::estimated;
use crate::motion::Stepping;

/// Ways in which simulators move positions that nature does not.
const DISCRETE: [Stepping; 2] = [Stepping::SemiImplicit { substeps: 1 }, Stepping::Euler];

/// Part of the budget of a search for each of them.
const SHARE: f64 = 0.25;

impl Problem<'_> {
    /// `found`, or where that leaves what no term explains, rates were not measured and samples are even, equations stepped as a simulator does that leave no such
    /// thing.
    pub(super) fn as_stepped(&self, found: Estimate) -> Estimate {
        let spoilt = |found: &Estimate| found.doubts.iter().flatten().any(|doubt| doubt.is_spoilt());
        let measured = (0..self.rates.len()).all(|i| self.measures(i));
        if measured || !self.discrete || !spoilt(&found) || !self.is_even() {
            return found;
        }
        let (budget, mut best) = ((SHARE * self.budget as f64) as u64, found);
        for stepping in DISCRETE {
            let problem = Problem { budget, spent: &Cell::new(0), ..*self };
            let tried = estimated(&problem, stepping).filter(|tried| !spoilt(tried) && tried.score < best.score);
            best = tried.unwrap_or(best);
        }
        best
    }

    /// Whether all samples are equally far apart.
    fn is_even(&self) -> bool {
        let mut steps = self.segments.iter().flat_map(|s| s.dt.iter().copied());
        let first = steps.next().unwrap_or(0.0);
        steps.all(|dt| (dt - first).abs() <= EVEN * first)
    }
}

/// Part of a sampling interval by which even ones may differ.
const EVEN: f64 = 1e-6;
