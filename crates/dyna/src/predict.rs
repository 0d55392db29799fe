//! What a policy will earn on the real system, before it has been there.

use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{EnvError, Policy, Seed};

use crate::belief::Belief;
use crate::evaluate::evaluate;
use crate::imagine::Trial;

/// Models that are asked, where there are several.
const MODELS: usize = 16;

/// Episodes in each of several models.
const EPISODES: usize = 50;

/// Episodes where there is one model.
const EPISODES_OF_ONE: usize = 200;

/// Means drawn, of which an interval's ends are quantiles.
const MEANS: usize = 2_000;

/// Returns of a policy in the models that the data allow.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Returns of the episodes in each model (models, episodes).
    returns: Vec<Vec<f64>>,
    /// Standard deviation of what the models have in common and the system has not, as far as real episodes told.
    pub(crate) misfit: f64,
    seed: Seed,
}

impl Prediction {
    /// What `policy` earns in the models of `belief`.
    pub(crate) fn new(belief: &Belief<'_>, policy: &dyn Policy, seed: Seed) -> Result<Self, EnvError> {
        let (models, episodes) = match belief.models.len() {
            1 => (1, EPISODES_OF_ONE),
            n => (n.min(MODELS), EPISODES),
        };
        let one = |i: usize| {
            let mut worlds: Vec<Trial<'_>> = (0..episodes).map(|_| Trial::new(belief, i)).collect();
            // Other starts in every model: their spread counts too.
            let stream = format!("prediction {i}");
            let earned = evaluate(&mut worlds, policy, episodes, seed, &stream)?;
            Ok(earned.iter().zip(&worlds).map(|(earned, world)| earned + world.charged()).collect())
        };
        Ok(Self { returns: (0..models).map(one).collect::<Result<_, EnvError>>()?, misfit: 0.0, seed })
    }

    /// The return of every episode in the models.
    pub(crate) fn returns(&self) -> Vec<f64> {
        self.returns.concat()
    }

    /// Expected return.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let n: usize = self.returns.iter().map(Vec::len).sum();
        self.returns.iter().flatten().sum::<f64>() / n.max(1) as f64
    }

    /// The interval that holds the mean return of `episodes` real episodes with probability `level`: over the models, over start
    /// states, and over what real episodes showed to be wrong with all models.
    #[must_use]
    pub fn interval(&self, level: f64, episodes: usize) -> (f64, f64) {
        let mut rng = self.seed.stream("prediction", 0);
        let mean_of = |_| {
            let returns = &self.returns[rng.random_range(0..self.returns.len())];
            // The episodes in the model are a sample as those on the system are.
            let n = (1.0 / (1.0 / episodes.max(1) as f64 + 1.0 / returns.len() as f64)).max(1.0) as usize;
            let mean = (0..n).map(|_| returns[rng.random_range(0..returns.len())]).sum::<f64>() / n as f64;
            let normal: f64 = StandardNormal.sample(&mut rng);
            mean + self.misfit * normal
        };
        let mut means: Vec<f64> = (0..MEANS).map(mean_of).collect();
        means.sort_by(f64::total_cmp);
        let at = |share: f64| means[(share * (MEANS - 1) as f64).round() as usize];
        let tail = 0.5 * (1.0 - level.clamp(0.0, 1.0));
        (at(tail), at(1.0 - tail))
    }
}
