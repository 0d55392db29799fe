//! What the policy that was kept does in its model, for the summary.

use std::sync::Arc;

use sindyna_control::Method;
use sindyna_core::{Policy, Seed};
use sindyna_dyna::Learned;
use sindyna_record::run::{Coverage, Evaluation, Improvable};
use sindyna_sindy::Model;

use crate::evaluation::evaluation;
use crate::improvable::improvable;
use crate::learner::Fitted;
use crate::predicting::Predicting;
use crate::problem::{Late, Problem};
use crate::reach::coverage;

/// Episodes in the model with controls that act late.
const EPISODES: usize = 20;

/// What a policy does in its model.
#[derive(Debug, Clone, Default)]
pub struct InModel {
    /// Where it goes, beside the data of a run on a log.
    pub(crate) coverage: Option<Coverage>,
    /// Returns of a policy whose controls act late, with that and with its predictions.
    pub(crate) late: Option<Evaluation>,
    /// How far a policy that is no plan is from better plans.
    pub(crate) improvable: Option<Improvable>,
}

/// What `policy`, that of `learned`, does in its model; `None` once `stopped`, since a planner that is stopped plans no more. `begun` is told how many
/// episodes were begun, of how many, whenever another is.
pub fn in_model(
    problem: &dyn Problem,
    learned: &Learned<Fitted>,
    policy: Option<&dyn Policy>,
    (begun, stopped): (&(dyn Fn(usize, usize) + Sync), &dyn Fn() -> bool),
) -> Option<InModel> {
    if learned.interrupted {
        return None;
    }
    let Some((fitted, policy)) = learned.model.as_ref().zip(policy) else { return Some(InModel::default()) };
    let model = &fitted.0.model;
    let coverage = problem.log().and_then(|log| coverage(problem, (model, policy), log, begun));
    let plans = policy.begin().is_some();
    let late = late(problem, model, policy);
    let follows = kept(learned).is_none_or(|name| name == Method::Lqr.name());
    let improvable = follows.then(|| improvable(problem, Arc::new(model.clone()), policy)).flatten();
    (!plans || !stopped()).then_some(InModel { coverage, late, improvable })
}

/// Returns of `policy` in `model` with controls that act as late as those of `problem`, and with predictions for when they act; `None` where they act at once.
fn late(problem: &dyn Problem, model: &Model, policy: &dyn Policy) -> Option<Evaluation> {
    let system = problem.late(model)?;
    let late = Late::of((problem.delay(), problem.lag()), problem.spec().dt);
    let predicting = Predicting::new(policy, problem, model.clone(), late).ok()?;
    evaluation(&*system, &predicting, EPISODES, Seed::new(0)).ok()
}

/// The planner that was kept, by name.
pub(crate) fn kept(learned: &Learned<Fitted>) -> Option<&'static str> {
    let policy = learned.policy.as_ref()?.to_bytes();
    learned.planned.iter().map(|(name, _)| *name).find(|name| name.as_bytes() == policy)
}
