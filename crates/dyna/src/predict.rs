//! What a policy will earn on the system, before it has been there.

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

/// Models and episodes in each, and episodes where there is one model, of a policy that plans, which takes its time for every step.
const PLANNED: (usize, usize) = (5, 2);
const PLANNED_IN_ONE: usize = 10;

/// Probability of the interval that is called wide.
const LEVEL: f64 = 0.9;

/// Width of such an interval as a part of the returns' magnitude: the disagreement at which no confirmation episode agrees, as a standard deviation, to both sides.
const WIDE: f64 = 0.2;

/// Means drawn, of which an interval's ends are quantiles.
const MEANS: usize = 2_000;

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Sample variance; 0 of fewer than two values.
fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len().saturating_sub(1).max(1) as f64
}

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
        let plans = policy.begin().is_some();
        let (models, episodes) = match (belief.n_systems(), plans) {
            (1, false) => (1, EPISODES_OF_ONE),
            (1, true) => (1, PLANNED_IN_ONE),
            (n, false) => (n.min(MODELS), EPISODES),
            (n, true) => (n.min(PLANNED.0), PLANNED.1),
        };
        let one = |i: usize| {
            let mut systems: Vec<Trial<'_>> = (0..episodes).map(|_| Trial::new(belief, i)).collect();
            // Other starts in every model: their spread counts too.
            let stream = format!("prediction {i}");
            let earned = evaluate(&mut systems, policy, episodes, seed, &stream)?;
            Ok(earned.iter().zip(&systems).map(|(earned, system)| earned + system.charged()).collect())
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
        mean(&self.returns())
    }

    /// How much of the differences between the models' mean returns is theirs, and not of the episodes that each was asked for: √(τ² / V), where V is the
    /// variance of the means of models, s² that of episodes in a model, E their number, and τ² = V − s²/E (one-way random effects).
    fn own(&self) -> f64 {
        let means: Vec<f64> = self.returns.iter().map(|r| mean(r)).collect();
        let within = self.returns.iter().map(|r| variance(r) / r.len() as f64).sum::<f64>() / means.len() as f64;
        let between = variance(&means);
        if between > within { (1.0 - within / between).sqrt() } else { 0.0 }
    }

    /// Whether what of the interval is the models' own is wide beside returns of the magnitude `scale`: more data would tell more. The spread over start states stays.
    pub(crate) fn is_wide(&self, scale: f64) -> bool {
        let (low, high) = self.interval(LEVEL, EPISODES);
        self.own() * (high - low) > WIDE * scale
    }

    /// The interval that holds the mean return of `episodes` real episodes with probability `level`: over the models, over start
    /// states, and over what real episodes showed to be wrong with all models.
    #[must_use]
    pub fn interval(&self, level: f64, episodes: usize) -> (f64, f64) {
        let mut rng = self.seed.stream("prediction", 0);
        let (models, own) = (self.returns.len(), self.own());
        let all: usize = self.returns.iter().map(Vec::len).sum();
        // The episodes in the models are a sample as those on the system are.
        let n = (1.0 / (1.0 / episodes.max(1) as f64 + 1.0 / all as f64)).max(1.0) as usize;
        let mean_of = |_| {
            let model = rng.random_range(0..models);
            let mut drawn = || {
                let model = if rng.random_bool(own) { model } else { rng.random_range(0..models) };
                self.returns[model][rng.random_range(0..self.returns[model].len())]
            };
            let mean = (0..n).map(|_| drawn()).sum::<f64>() / n as f64;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(rng: &mut sindyna_core::Rng) -> f64 {
        StandardNormal.sample(rng)
    }

    /// Share of 400 systems whose mean return of 100 episodes the 90 % interval holds: models and system are drawn alike, their means with the deviation
    /// `between`, episodes with the deviation 1.
    fn coverage(between: f64) -> f64 {
        let held = (0..400).filter(|run| {
            let seed = Seed::new(*run);
            let mut rng = seed.stream("test", 0);
            let episodes = |n: usize, mean: f64, rng: &mut sindyna_core::Rng| -> Vec<f64> {
                (0..n).map(|_| mean + normal(rng)).collect()
            };
            let of_model = |_| {
                let mean = between * normal(&mut rng);
                episodes(EPISODES, mean, &mut rng)
            };
            let returns = (0..MODELS).map(of_model).collect();
            let true_mean = between * normal(&mut rng);
            let real = mean(&episodes(100, true_mean, &mut rng));
            let (low, high) = Prediction { returns, misfit: 0.0, seed }.interval(0.9, 100);
            (low..=high).contains(&real)
        });
        held.count() as f64 / 400.0
    }

    #[test]
    fn intervals_hold_as_often_as_they_say() {
        for between in [0.0, 0.1, 1.0] {
            let held = coverage(between);
            assert!((0.83..=0.96).contains(&held), "{held} at {between}");
        }
    }

    #[test]
    fn only_what_models_disagree_on_calls_for_data() {
        let mut rng = Seed::new(0).stream("test", 0);
        let mut of = |between: f64| {
            let one = |model: usize| (0..EPISODES).map(|_| between * model as f64 + normal(&mut rng)).collect();
            let prediction = Prediction { returns: (0..MODELS).map(one).collect(), misfit: 0.0, seed: Seed::new(0) };
            let (low, high) = prediction.interval(LEVEL, EPISODES);
            prediction.is_wide(0.5 * (high - low) / WIDE)
        };
        assert!(of(1.0), "models that disagree");
        assert!(!of(0.0), "starts alone");
    }

    #[test]
    fn an_interval_does_not_leave_the_range_of_returns() {
        let returns = vec![vec![500.0; EPISODES], [vec![500.0; EPISODES - 1], vec![300.0]].concat()];
        let (low, high) = Prediction { returns, misfit: 0.0, seed: Seed::new(0) }.interval(0.9, 100);
        assert!(low < 500.0 && high <= 500.0, "{low} to {high}");
    }
}
