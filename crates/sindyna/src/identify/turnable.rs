//! Which states may be angles, though neither names nor units say so.

use sindyna_core::{Kind, Spec};
use sindyna_sindy::{Expr, Identified, Model};

use super::as_read::is_spoilt;
use crate::logs::Log;

/// The states of `log` that could be angles: those without a unit whose rates are states of the system `spec`, or do not depend on them in the equations `found` of it.
pub(super) fn could_turn<'a>(log: &'a Log, spec: &'a Spec, found: &'a Model) -> impl Iterator<Item = usize> + 'a {
    let open = |i: &usize| {
        let state = &spec.state[*i];
        let has_rate = spec.state.iter().any(|s| s.kind == Kind::RateOf(*i));
        let is_free = has_rate || turns_freely(found, *i);
        state.kind == Kind::Plain && is_free && log.could_turn.iter().any(|(name, _)| *name == state.name)
    };
    (0..spec.state_dim()).filter(open)
}

/// States that are to be tried as angles together, one choice after the other: those of `log`, of the system `spec`, that could be, of which some equation `found` of it has a term that is not
/// linear in them; then those of which it has a product, too, which may be that of another state that turns. Those that are called as angles are among the second ones also where equations leave what no term explains.
pub(super) fn turning(log: &Log, spec: &Spec, found: &Identified) -> Vec<Vec<String>> {
    let spoilt = is_spoilt(found);
    let is_named = |i: usize| log.could_turn.iter().any(|(name, named)| *named && *name == spec.state[i].name);
    let speaks = |i: &usize| is_bent(&found.model, *i) || (spoilt && is_named(*i));
    let names = |of: &dyn Fn(&usize) -> bool| -> Vec<String> {
        could_turn(log, spec, &found.model).filter(of).map(|i| spec.state[i].name.clone()).collect()
    };
    let mut choices = vec![names(&|i| is_curved(&found.model, *i)), names(&speaks)];
    choices.dedup();
    choices.retain(|names| !names.is_empty());
    choices
}

/// Those of the states `names`, taken for angles, that are some: those in terms of the equations of `model`, and those of which a rate is a state of the system `spec`, since one coordinate of a mechanism may turn with
/// another one. What nothing depends on is no angle.
pub(super) fn angles_of(names: Vec<String>, spec: &Spec, model: &Model) -> Vec<String> {
    let is_rate = |of: usize| spec.state.iter().any(|s| s.kind == Kind::RateOf(of));
    let turns = |i: usize| is_rate(i) || terms_with(model, i).next().is_some();
    let is_angle = |name: &String| spec.state.iter().position(|s| s.name == *name).is_some_and(turns);
    names.into_iter().filter(is_angle).collect()
}

/// What is tried, as it is told.
pub(super) fn told(names: &[String]) -> String {
    format!("trying {} as {}", names.join(" and "), if names.len() > 1 { "angles" } else { "an angle" })
}

/// Whether a term of `model` is not linear in the state `i`.
fn is_curved(model: &Model, i: usize) -> bool {
    terms_with(model, i).any(|term| term.derivative(i).is_some_and(|slope| slope.has(i)))
}

/// Whether a term of `model` has the state `i` and is not that alone.
fn is_bent(model: &Model, i: usize) -> bool {
    terms_with(model, i).any(|term| *term != Expr::Variable(i))
}

/// Whether the rate of the state `i` of `model` depends on something, and not on the state: it is the same in all directions.
fn turns_freely(model: &Model, i: usize) -> bool {
    let own = model.coefficients(i);
    !own.is_empty() && own.iter().all(|entry| !model.terms()[entry.term].has(i))
}

/// The terms of the equations of `model` that have the state `i`.
fn terms_with(model: &Model, i: usize) -> impl Iterator<Item = &Expr> {
    let used = (0..model.states().len()).flat_map(|equation| model.coefficients(equation));
    used.map(|entry| &model.terms()[entry.term]).filter(move |term| term.has(i))
}
