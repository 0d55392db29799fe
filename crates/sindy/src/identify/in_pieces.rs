//! Which of two accounts of the same data is believed: noise alone, or disturbances.

use std::cell::Cell;

use super::Identifier;
use super::estimated::written;
use crate::LibraryChoice;
use crate::data::sample_of;
use crate::estimate::{Estimate, Problem, estimate};
use crate::library::Joints;
use crate::motion::Stepping;
use crate::pieces::{Cut, Disturbed};
use crate::regression::Space;

/// Steps in which equations that leave noise alone are looked for first, and the part of the budget for that.
const PART: usize = 600;
const SHARE: u64 = 32;

/// Part of its spread that equations leave of a state in most pieces, beyond which they explain little.
const EXPLAINED: f64 = 0.2;

impl Identifier {
    /// Equations whose errors are those of sensors; where there are none, and states are positions and speeds of joints, equations of pieces, of the system
    /// disturbed, with sentences about these. Of two that are approximations the one counts that leaves less of most pieces.
    pub(super) fn estimated_or_in_pieces(
        &self,
        problem: &Problem<'_>,
        stepping: Stepping,
        space: &Space,
    ) -> (Option<Estimate>, Vec<String>) {
        let joints = if self.may_be_disturbed() { Joints::any(&self.inputs(), problem.rates, &[]) } else { None };
        let cut = joints
            .and_then(|joints| Some((joints.clone(), Cut::new(problem.segments, problem.floor, &joints.speeds())?)));
        let Some((joints, cut)) = cut else { return (estimate(problem, stepping), Vec::new()) };
        let settled = |found: &Estimate| !found.doubts.iter().flatten().any(|doubt| doubt.is_spoilt());
        let (part, spent) = (sample_of(problem.segments, PART), Cell::new(0));
        let quickly = Problem { segments: &part, budget: problem.budget / SHARE, spent: &spent, ..*problem };
        let first = estimate(&quickly, stepping);
        if first.as_ref().is_some_and(settled) || !problem.watch.go_on() {
            return (estimate(problem, stepping), Vec::new());
        }
        let disturbed = cut.disturbed(&joints, problem.rates, (space, self.spec.dt), (problem.solver, problem.watch));
        let noise = first.as_ref().map(|first| &first.signal_noise[..]);
        let is_disturbed = disturbed.as_ref().is_some_and(|d| d.left < EXPLAINED && d.leaves_more_than(noise));
        let found = if is_disturbed { None } else { estimate(problem, stepping) };
        let Some(Disturbed { found: of_pieces, left, notes }) = disturbed else { return (found, Vec::new()) };
        let is_better = |found: &Estimate| {
            let model = written(found, space, self.spec.dt).ok();
            settled(found)
                || model.and_then(|model| cut.left_by(&model, problem.watch)).is_some_and(|by_noise| by_noise < left)
        };
        match found.filter(is_better) {
            Some(found) => (Some(found), Vec::new()),
            None => (Some(of_pieces), notes),
        }
    }

    /// Whether nothing is told of the equations that those of a Lagrangian could not have.
    fn may_be_disturbed(&self) -> bool {
        self.library == LibraryChoice::Auto && self.constraints.is_empty() && self.own_terms.is_empty()
    }
}
