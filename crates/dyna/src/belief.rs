//! What imagination goes by: the models that the data allow, where these were seen to hold, and what is at stake.

use std::sync::Arc;

use rand_distr::{ChiSquared, Distribution as _};
use sindyna_core::{Channel, Dataset, Dynamics, Kind, Knowledge, Rng, Sensors, Spec, Support, Task};

use crate::explore::uniform_action;
use crate::trust::Trust;

/// Models drawn from a posterior: every imagined system follows one of them.
const DRAWS: usize = 32;

/// Steps with random actions from which it is told what rewards there are.
const SAMPLES: usize = 500;

/// What a step far outside of the data costs, as a part of the spread of the rewards. Small beside what the task pays, large beside
/// nothing: where the task does not care, the policy stays where the model was compared with the system.
const PENALTY: f64 = 0.1;

/// Share of the steps that earn the highest reward, from which that is a cap and no coincidence.
const CAPPED: f64 = 0.05;

/// What rewards there are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stakes {
    /// The value of being paid the worst reward for ever, or nothing if that is better for no one: min(0, min r) / (1 − γ).
    pub(crate) worst_value: f64,
    /// The highest return there can be, where that is known: many steps are paid the highest reward there is, so that none pays more, and an
    /// episode in which all of them do is the best.
    pub(crate) ceiling: Option<f64>,
}

impl Stakes {
    /// What rewards there are, and what a step infinitely far from the data costs.
    fn of(
        model: &dyn Dynamics,
        task: &dyn Task,
        support: &Support,
        data: &Dataset,
        discount: f64,
        rng: &mut Rng,
    ) -> (Self, f64) {
        let spec = task.spec();
        let (mut x, mut next) = (vec![0.0; spec.state_dim()], vec![0.0; spec.state_dim()]);
        let (mut action, mut u) = (vec![0.0; spec.action_space.action_dim()], vec![0.0; spec.control_dim()]);
        let mut rewards: Vec<f64> = data.rollouts().flat_map(|r| r.rewards.to_vec()).collect();
        for sample in 0..SAMPLES {
            if sample % 2 == 0 {
                task.initial(rng, &mut x)
            } else {
                support.draw(rng, &mut x)
            }
            uniform_action(&spec.action_space, rng, &mut action);
            if task.terminated(&x)
                || !spec.action_space.control_into(&action, &mut u)
                || model.step(&x, &u, rng, &mut next).is_err()
                || !support.contains(&next)
            {
                // Where nobody follows the model, its rewards are none.
                continue;
            }
            let reward = task.reward(&x, &action, &u, &next);
            if reward.is_finite() {
                rewards.push(reward);
            }
        }
        rewards.sort_by(f64::total_cmp);
        let at =
            |share: f64| rewards.get((share * rewards.len().saturating_sub(1) as f64) as usize).map_or(0.0, |r| *r);
        let (least, most) = (at(0.0), at(1.0));
        let capped = rewards.iter().filter(|r| **r >= most).count() as f64 >= CAPPED * rewards.len() as f64;
        let spread = at(0.95) - at(0.05);
        let stakes = Self {
            worst_value: least.min(0.0) / (1.0 - discount).max(f64::EPSILON),
            ceiling: (capped && most > 0.0).then_some(most * task.max_steps() as f64),
        };
        (stakes, PENALTY * if spread > 0.0 { spread } else { most.abs().max(least.abs()) })
    }
}

/// A system as it may be: a model drawn, the sensors that it is seen through, and the task with start states as they may be.
#[derive(Clone)]
pub(crate) struct Possible<'a> {
    pub(crate) model: Arc<dyn Dynamics>,
    pub(crate) sensors: Arc<Sensors>,
    pub(crate) task: Arc<dyn Task + 'a>,
}

/// What imagination goes by.
#[derive(Clone)]
pub(crate) struct Belief<'a> {
    /// Systems as likely as each other; at least one.
    systems: Arc<[Possible<'a>]>,
    pub(crate) task: &'a dyn Task,
    pub(crate) trust: Arc<Trust>,
    pub(crate) stakes: Stakes,
}

impl<'a> Belief<'a> {
    /// What is believed after `data` made `knowledge` of the system of `task`, seen through `sensors`.
    pub(crate) fn of<M: Dynamics + 'static>(
        knowledge: &Knowledge<M>,
        task: &'a dyn Task,
        sensors: &Sensors,
        data: &Dataset,
        discount: f64,
        rng: &mut Rng,
    ) -> Self {
        let model: Arc<dyn Dynamics> = knowledge.model.clone();
        let models: Vec<Arc<dyn Dynamics>> = match &knowledge.posterior {
            Some(posterior) => (0..DRAWS).map(|_| posterior.draw(rng)).collect(),
            None => vec![model.clone()],
        };
        let estimated = match &knowledge.sensor_noise {
            Some(deviations) => sensors.clone().with_noise(deviations),
            None => sensors.clone(),
        };
        let is_certain = models.len() == 1;
        let rivals = models.clone();
        let mut possible = |model| {
            let sensors = if is_certain { estimated.clone() } else { as_uncertain(&estimated, data, rng) };
            Possible { model, sensors: Arc::new(sensors), task: Arc::new(task) }
        };
        let mut systems: Vec<Possible<'a>> = models.into_iter().map(&mut possible).collect();
        let drawn: Vec<Arc<dyn Task>> = (0..DRAWS).map_while(|_| task.draw(rng)).collect();
        if !drawn.is_empty() {
            let with_task = |(i, task): (usize, _)| -> Possible<'a> {
                let Possible { model, sensors, .. } = systems[i % systems.len()].clone();
                Possible { model, sensors, task }
            };
            systems = drawn.into_iter().enumerate().map(with_task).collect();
        }
        let support = support(&systems, data, rng);
        let (stakes, penalty) = Stakes::of(&*model, task, &support, data, discount, rng);
        let noise = knowledge.sensor_noise.as_ref().map(|noise| noise_of_states(task.spec(), noise));
        let trust = Trust::new(support, (model, rivals), noise, penalty);
        Self { systems: systems.into(), task, trust: Arc::new(trust), stakes }
    }

    /// The system that number `i` of those imagined is.
    pub(crate) fn system(&self, i: usize) -> &Possible<'a> {
        &self.systems[i % self.systems.len()]
    }

    /// How many systems there are.
    pub(crate) fn n_systems(&self) -> usize {
        self.systems.len()
    }

    /// The same seen through sensors without noise.
    pub(crate) fn without_noise(&self) -> Self {
        let quiet = |s: &Possible<'a>| Possible { sensors: Arc::new(s.sensors.without_noise()), ..s.clone() };
        Self { systems: self.systems.iter().map(quiet).collect(), ..self.clone() }
    }
}

/// `estimated` sensors with noise of a variance drawn from its posterior after the samples of `data`, a scaled inverse χ² distribution.
fn as_uncertain(estimated: &Sensors, data: &Dataset, rng: &mut Rng) -> Sensors {
    let samples = data.n_steps().max(1) as f64;
    let Ok(distribution) = ChiSquared::new(samples) else { return estimated.clone() };
    let deviations: Vec<f64> =
        estimated.deviations().iter().map(|d| d * (samples / distribution.sample(rng)).sqrt()).collect();
    estimated.clone().with_noise(&deviations)
}

/// The standard deviation of each state of `spec` as it is seen, of those of the observations in `noise`; that of an angle is that of its cosine and its sine, and
/// what is not seen has none.
pub(crate) fn noise_of_states(spec: &Spec, noise: &[f64]) -> Vec<f64> {
    let of_state = |(i, state): (usize, &Channel)| {
        let shows = |o: &Channel| o.name == state.name || o.kind == Kind::CosOf(i) || o.kind == Kind::SinOf(i);
        spec.observation.iter().zip(noise).filter(|(o, _)| shows(o)).map(|(_, noise)| *noise).fold(0.0, f64::max)
    };
    spec.state.iter().enumerate().map(of_state).collect()
}

/// Start states from which it is told where episodes begin.
const STARTS: usize = 100;

/// The support of `data` and of the start states of `systems`.
fn support(systems: &[Possible<'_>], data: &Dataset, rng: &mut Rng) -> Support {
    let spec = systems[0].task.spec();
    let start = |i: usize| {
        let mut x = vec![0.0; spec.state_dim()];
        systems[i % systems.len()].task.initial(rng, &mut x);
        x
    };
    Support::of(spec, data, &(0..STARTS).map(start).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Diverged, Seed};

    /// x' = x + u, until it blows up.
    struct Push;

    impl Dynamics for Push {
        fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
            next[0] = if x[0] > 3.0 { 1e6 } else { x[0] + u[0] };
            Diverged::check(next)
        }
    }

    /// Pays −x².
    struct Stay(Spec);

    impl Task for Stay {
        fn spec(&self) -> &Spec {
            &self.0
        }
        fn max_steps(&self) -> usize {
            100
        }
        fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
            x[0] = 0.0;
        }
        fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
            -next[0] * next[0]
        }
        fn terminated(&self, _next: &[f64]) -> bool {
            false
        }
    }

    #[test]
    fn where_nobody_follows_a_model_that_blows_up_its_rewards_are_none() {
        let task = Stay(crate::one_state::spec());
        let mut data = Dataset::new(1, 1, 1, 0.1);
        data.begin(&[-2.0]).expect("finite");
        for x in [-1.0, 0.0, 1.0, 2.0] {
            data.push(&[1.0], &[1.0], -x * x, &[x]).expect("finite");
        }
        let support = Support::of(&task.0, &data, &[]);
        let (stakes, _) = Stakes::of(&Push, &task, &support, &data, 0.9, &mut Seed::new(0).numpy());
        // States are drawn from ±4, and the farthest that is followed from there is 5.
        assert!((-250.0..-40.0).contains(&stakes.worst_value), "{stakes:?}");
    }
}
