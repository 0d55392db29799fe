//! How far a policy is from better plans in its model.

use std::sync::Arc;

use rayon::prelude::*;
use sindyna_control::{Rollout, improved};
use sindyna_core::{Dynamics, Policy};
use sindyna_record::run::Improvable;

use crate::problem::Problem;
use crate::rollout::rollout;

/// Episodes in the model.
const EPISODES: u64 = 4;

/// What `policy` earns in `model`, and what it earns once its controls are improved; `None` where an episode fails.
pub(crate) fn improvable(problem: &dyn Problem, model: Arc<dyn Dynamics>, policy: &dyn Policy) -> Option<Improvable> {
    let made = |episode: u64| {
        let made = rollout(problem, &model, policy, ("improvable", episode));
        let start = made.states.into_iter().next().filter(|_| made.ended)?;
        Some(Rollout { start, controls: made.controls, earned: made.earned })
    };
    let rollouts = (0..EPISODES).into_par_iter().map(made).collect::<Option<Vec<Rollout>>>()?;
    let earned = rollouts.iter().map(|rollout| rollout.earned).sum::<f64>() / rollouts.len() as f64;
    let improved = improved(model, problem.task(), &rollouts);
    Some(Improvable { episodes: rollouts.len(), policy: earned, improved })
}
