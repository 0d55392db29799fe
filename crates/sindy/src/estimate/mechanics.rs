//! Mechanics as a hypothesis among others: equations that one Lagrangian proposes for all joints.

use super::hypothesis::{Hypothesis, Start};
use super::problem::{Problem, Structure};
use super::search::Level;
use crate::data::Signals;
use crate::motion::Stepping;

/// Part of the budget of a search, for mechanics.
const SHARE: f64 = 0.2;

impl Problem<'_> {
    /// The best hypothesis with the terms of a Lagrangian, if it leaves noise alone. Its terms do so at all `levels` before they are fitted to the
    /// last digit.
    pub(super) fn mechanical(&self, signals: &Signals, levels: &[Level], stepping: Stepping) -> Option<Hypothesis> {
        let fitted = |problem: &Problem<'_>, proposal: &Structure| {
            let rough = problem.settled_at(levels, proposal, stepping)?;
            let found = problem.as_simulated(problem.fitted(&rough, signals)?);
            problem.is_settled(&found).then_some(found)
        };
        self.with_share(SHARE, |problem| {
            let all = problem.mechanics.iter().filter_map(|proposal| fitted(problem, proposal));
            all.min_by(|one, other| one.score.total_cmp(&other.score))
        })
    }

    /// The terms of `proposal`, fitted at one of `levels` after the other, if they leave noise alone at each.
    fn settled_at(&self, levels: &[Level], (supports, xi): &Structure, stepping: Stepping) -> Option<Hypothesis> {
        let mut settled: Option<Hypothesis> = None;
        for Level { floor, signals } in levels {
            let problem = Problem { floor, noise: &signals.sigma, ..*self };
            let begun = Start { xi, inside: &[], x: &signals.x, sigma: &signals.sigma };
            let found = match &settled {
                None => problem.hypothesis(supports.clone(), stepping, begun, 0..4)?,
                Some(rough) => problem.fitted(rough, signals)?,
            };
            let found = if problem.is_settled(&found) { found } else { problem.as_simulated(found) };
            if !problem.is_settled(&found) {
                return None;
            }
            settled = Some(found);
        }
        settled
    }
}
