//! Which of two accounts of the same data is believed: noise alone, or disturbances.

use std::cell::{Cell, OnceCell};

use super::Identifier;
use super::estimated::written;
use crate::estimate::{Doubt, Estimate, OfPart, Problem, budget, completed, estimate, still};
use crate::library::Joints;
use crate::model::Model;
use crate::motion::Stepping;
use crate::pieces::{Cut, Disturbed};
use crate::regression::{Space, model};
use crate::{Disturbances, LibraryChoice};

/// Part of the usual effort from which on pieces are looked at. Equations of the system disturbed are those of the whole effort: their score is no other one's.
const LEAST: f64 = 0.1;

impl Identifier {
    /// Equations whose errors are those of sensors; where there are none, and states are positions and speeds of joints, equations of pieces: if the terms of
    /// these leave noise alone of all data, they are the equations, and if not those of the system disturbed, with sentences about the pieces. Of two that
    /// are approximations the one counts that leaves less of most pieces.
    ///
    /// The search for noise alone is made in any case, in all data or a part of them, unless the system is known to be disturbed: pieces that do not follow may as well be
    /// those in which a term acts that is missing.
    pub(super) fn estimated_or_in_pieces(
        &self,
        problem: &Problem<'_>,
        stepping: Stepping,
        space: &Space,
    ) -> (Option<Estimate>, Vec<String>) {
        let joints = if self.may_be_disturbed() {
            Joints::any(&self.inputs(), problem.rates, &still(problem.segments, problem.rates).in_each)
        } else {
            None
        };
        let cut = joints.as_ref().and_then(|joints| Cut::new(problem.segments, problem.floor, &joints.speeds()));
        let (in_pieces, complete) = (OnceCell::new(), Cell::new(true));
        let in_pieces = || {
            let found = || self.in_pieces(problem, stepping, space, (joints.as_ref()?, cut.as_ref()?));
            in_pieces.get_or_init(found).as_ref()
        };
        if self.disturbances == Disturbances::Known
            && let Some(InPieces { disturbed, whole }) = in_pieces()
        {
            return match whole {
                Some(whole) => (Some(whole.clone()), Vec::new()),
                None => (Some(disturbed.found.clone()), disturbed.notes.clone()),
            };
        }
        let is_better = |model: Option<Model>, left: f64| {
            let by_noise = model.and_then(|model| cut.as_ref()?.left_by(&model, problem.watch));
            by_noise.is_some_and(|by_noise| by_noise < left)
        };
        let instead = |OfPart { terms, fits, stepping, complete: finished }: OfPart<'_>| {
            complete.set(finished);
            let Some(InPieces { disturbed, whole }) = in_pieces() else { return false };
            let of_part = || model(space.clone(), terms, fits, stepping.form(), self.spec.dt).ok();
            whole.is_some() || !is_better(of_part(), disturbed.left)
        };
        // Less than the usual effort is made to compare scores, which equations of pieces have not.
        let instead = (self.effort >= 1.0).then_some(&instead as &dyn Fn(OfPart<'_>) -> bool);
        let found = estimate(&Problem { instead, ..*problem }, stepping);
        if found.as_ref().is_some_and(is_settled) || !problem.watch.go_on() {
            return (found, Vec::new());
        }
        let Some(InPieces { disturbed, whole }) = in_pieces() else { return (found, Vec::new()) };
        if whole.is_some() || self.effort < 1.0 {
            return (whole.clone().or(found), Vec::new());
        }
        let complete = found.as_ref().map_or(complete.get(), |found| found.complete);
        match found.filter(|found| is_better(written(found, space, self.spec.dt).ok(), disturbed.left)) {
            Some(found) => (Some(found), Vec::new()),
            None => (Some(Estimate { complete, ..disturbed.found.clone() }), disturbed.notes.clone()),
        }
    }

    /// Equations of the pieces `cut` of a system of `joints`.
    fn in_pieces(
        &self,
        problem: &Problem<'_>,
        stepping: Stepping,
        space: &Space,
        (joints, cut): (&Joints, &Cut<'_>),
    ) -> Option<InPieces> {
        let search = (problem.solver, problem.watch);
        let disturbed = cut.disturbed(joints, problem.rates, (space, self.spec.dt), search)?;
        // Few samples with much noise may tell the equations of pieces, and not those of the whole, until these are known.
        let whole = |model: Model| {
            let structure = self.structure_of(&model, problem.terms)?;
            let (spent, whole) = (Cell::new(0), budget(1.0, problem.segments));
            let of_parts = Some(&structure);
            completed(&Problem { of_parts, whole, budget: whole, spent: &spent, ..*problem }, stepping)
        };
        let whole = written(&disturbed.found, space, self.spec.dt).ok().and_then(whole).filter(is_settled);
        Some(InPieces { disturbed, whole })
    }

    /// Whether nothing is told of the equations that those of a Lagrangian could not have, and more than the simplest is looked for.
    fn may_be_disturbed(&self) -> bool {
        self.disturbances != Disturbances::None
            && self.effort >= LEAST
            && self.library == LibraryChoice::Auto
            && self.constraints.is_empty()
            && self.own_terms.is_empty()
    }
}

/// Equations of the pieces of a log.
struct InPieces {
    disturbed: Disturbed,
    /// Those with the same terms, and with others near these, if they leave noise alone of all data.
    whole: Option<Estimate>,
}

fn is_settled(found: &Estimate) -> bool {
    !found.doubts.iter().flatten().any(|doubt| doubt.is_spoilt() || *doubt == Doubt::Asymmetric)
}
