//! Which of two accounts of the same data is believed: noise alone, or disturbances.

use std::cell::Cell;

use super::Identifier;
use super::estimated::written;
use crate::LibraryChoice;
use crate::estimate::{Doubt, Estimate, Problem, budget, completed, estimate};
use crate::library::Joints;
use crate::model::Model;
use crate::motion::Stepping;
use crate::pieces::{Cut, Disturbed};
use crate::regression::Space;

/// Part of the usual effort from which on pieces are looked at. Equations of the system disturbed are those of the whole effort: their score is no other one's.
const LEAST: f64 = 0.1;

impl Identifier {
    /// Equations whose errors are those of sensors; where there are none, and states are positions and speeds of joints, equations of pieces: if the terms of
    /// these leave noise alone of all data, they are the equations, and if not those of the system disturbed, with sentences about the pieces. Of two that
    /// are approximations the one counts that leaves less of most pieces.
    ///
    /// The search for noise alone is made in any case: pieces that do not follow may as well be those in which a term acts that is missing.
    pub(super) fn estimated_or_in_pieces(
        &self,
        problem: &Problem<'_>,
        stepping: Stepping,
        space: &Space,
    ) -> (Option<Estimate>, Vec<String>) {
        let found = estimate(problem, stepping);
        let is_open = |doubt: &Doubt| doubt.is_spoilt() || *doubt == Doubt::Asymmetric;
        let is_settled = |found: &Estimate| !found.doubts.iter().flatten().any(is_open);
        if found.as_ref().is_some_and(is_settled) || !self.may_be_disturbed() || !problem.watch.go_on() {
            return (found, Vec::new());
        }
        let Some(joints) = Joints::any(&self.inputs(), problem.rates, &[]) else { return (found, Vec::new()) };
        let Some(cut) = Cut::new(problem.segments, problem.floor, &joints.speeds()) else { return (found, Vec::new()) };
        let search = (problem.solver, problem.watch);
        let disturbed = cut.disturbed(&joints, problem.rates, (space, self.spec.dt), search);
        let Some(Disturbed { found: of_pieces, left, notes }) = disturbed else { return (found, Vec::new()) };
        // Few samples with much noise may tell the equations of pieces, and not those of the whole, until these are known.
        let whole = |model: Model| {
            let structure = self.structure_of(&model, problem.terms)?;
            let (spent, whole) = (Cell::new(0), budget(1.0, problem.segments));
            let of_parts = Some(&structure);
            completed(&Problem { of_parts, whole, budget: whole, spent: &spent, ..*problem }, stepping)
        };
        let whole = written(&of_pieces, space, self.spec.dt).ok().and_then(whole);
        if let Some(whole) = whole.filter(is_settled) {
            return (Some(whole), Vec::new());
        }
        if self.effort < 1.0 {
            return (found, Vec::new());
        }
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

    /// Whether nothing is told of the equations that those of a Lagrangian could not have, and more than the simplest is looked for.
    fn may_be_disturbed(&self) -> bool {
        self.effort >= LEAST
            && self.library == LibraryChoice::Auto
            && self.constraints.is_empty()
            && self.own_terms.is_empty()
    }
}
