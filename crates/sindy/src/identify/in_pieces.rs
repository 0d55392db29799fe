//! Which of two accounts of the same data is believed: noise alone, or disturbances.

use super::Identifier;
use super::estimated::written;
use crate::LibraryChoice;
use crate::estimate::{Estimate, Problem, estimate};
use crate::library::Joints;
use crate::motion::Stepping;
use crate::pieces::{Cut, Disturbed};
use crate::regression::Space;

impl Identifier {
    /// Equations whose errors are those of sensors; where there are none, and states are positions and speeds of joints, equations of pieces, of the system
    /// disturbed, with sentences about these. Of two that are approximations the one counts that leaves less of most pieces.
    ///
    /// The search for noise alone is made in any case: pieces that do not follow may as well be those in which a term acts that is missing.
    pub(super) fn estimated_or_in_pieces(
        &self,
        problem: &Problem<'_>,
        stepping: Stepping,
        space: &Space,
    ) -> (Option<Estimate>, Vec<String>) {
        let found = estimate(problem, stepping);
        let is_settled = |found: &Estimate| !found.doubts.iter().flatten().any(|doubt| doubt.is_spoilt());
        if found.as_ref().is_some_and(is_settled) || !self.may_be_disturbed() || !problem.watch.go_on() {
            return (found, Vec::new());
        }
        let Some(joints) = Joints::any(&self.inputs(), problem.rates, &[]) else { return (found, Vec::new()) };
        let Some(cut) = Cut::new(problem.segments, problem.floor, &joints.speeds()) else { return (found, Vec::new()) };
        let search = (problem.solver, problem.watch);
        let disturbed = cut.disturbed(&joints, problem.rates, (space, self.spec.dt), search);
        let Some(Disturbed { found: of_pieces, left, notes }) = disturbed else { return (found, Vec::new()) };
        let is_better = |found: &Estimate| {
            let model = written(found, space, self.spec.dt).ok();
            model.and_then(|model| cut.left_by(&model, problem.watch)).is_some_and(|by_noise| by_noise < left)
        };
        let complete = found.as_ref().is_none_or(|found| found.complete);
        match found.filter(is_better) {
            Some(found) => (Some(found), Vec::new()),
            None => (Some(Estimate { complete, ..of_pieces }), notes),
        }
    }

    /// Whether nothing is told of the equations that those of a Lagrangian could not have, and the search is more than one that compares readings of a log.
    fn may_be_disturbed(&self) -> bool {
        self.effort >= 1.0
            && self.library == LibraryChoice::Auto
            && self.constraints.is_empty()
            && self.own_terms.is_empty()
    }
}
