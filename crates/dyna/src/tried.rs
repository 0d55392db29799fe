//! A policy tried in the models that are believed in.

use sindyna_core::{Policy, Seed};

use crate::DynaError;
use crate::belief::Belief;
use crate::evaluate::evaluate;
use crate::explore::Holding;
use crate::imagine::Trial;

/// The stream of the start states of trials.
pub(crate) const TRIAL: &str = "trial in the model";

/// Episodes of each planner in the model: every step of them is planned.
pub(crate) const OF_PLANNERS: usize = 4;

/// Episodes of a policy in the models that are believed in, a model each.
pub(crate) struct Tried {
    /// What each earned, less what was charged for going far from the data.
    pub(crate) returns: Vec<f64>,
    /// What was charged, on average.
    pub(crate) charged: f64,
    /// How far they went, on average.
    pub(crate) far: f64,
}

impl Tried {
    /// `policy` in so many episodes, from start states of a stream of a seed.
    pub(crate) fn new(
        belief: &Belief<'_>,
        policy: &dyn Policy,
        (episodes, seed, stream): (usize, Seed, &str),
    ) -> Result<Self, DynaError> {
        let mut systems: Vec<Trial<'_>> = (0..episodes).map(|i| Trial::new(belief, i)).collect();
        let returns = evaluate(&mut systems, policy, episodes, seed, stream).map_err(DynaError::Trial)?;
        let mean = |values: f64| values / episodes.max(1) as f64;
        let charged = mean(systems.iter().map(Trial::charged).sum());
        Ok(Self { returns, charged, far: mean(systems.iter().map(Trial::far).sum()) })
    }

    /// What they earned on average.
    pub(crate) fn mean(&self) -> f64 {
        self.returns.iter().sum::<f64>() / self.returns.len().max(1) as f64 + self.charged
    }
}

/// The best mean return of one action held all the time, over `episodes` episodes in the models of `belief`.
pub(crate) fn held(belief: &Belief<'_>, episodes: usize, seed: Seed) -> Result<Option<f64>, DynaError> {
    let mut best: Option<f64> = None;
    for policy in Holding::each(&belief.task.spec().action_space) {
        let returns = Tried::new(belief, &policy, (episodes, seed, TRIAL))?.returns;
        let mean = returns.iter().sum::<f64>() / returns.len().max(1) as f64;
        best = Some(best.map_or(mean, |best| best.max(mean)));
    }
    Ok(best)
}
