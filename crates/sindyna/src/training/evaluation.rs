//! A trained policy on the system itself.

use sindyna_core::{Policy, Seed};
use sindyna_dyna::evaluate;
use sindyna_record::run::Evaluation;

use crate::Error;
use crate::problem::Problem;

/// The returns of `policy` (its best actions) on the system, from start states fixed by `seed`.
pub(crate) fn evaluation(
    problem: &dyn Problem,
    policy: &dyn Policy,
    episodes: usize,
    seed: Seed,
) -> Result<Evaluation, Error> {
    let systems = episodes.min(problem.copies()).max(1);
    let mut envs = (0..systems).map(|_| problem.environment()).collect::<Result<Vec<_>, _>>()?;
    let returns = evaluate(&mut envs, policy, episodes, seed, "evaluation")?;
    problem.check()?;
    Ok(Evaluation::of(returns))
}
