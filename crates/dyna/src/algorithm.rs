//! Algorithm 1 of Arora, da Silva and Moss (2022).

use std::io;

use sindyna_core::{
    Agent, AgentError, Batch, Dataset, DynamicsLearner, EnvError, Environment, Event, Explorer, FitError, Observe,
    Observer, Region, Replay, Seed, Task, Unseen,
};

use crate::collect::{Actor, Amount, CollectError, collect};
use crate::imagine::{Counts, Imagined};
use crate::improve::{ImproveError, Improvement, Stop};
use crate::optimality::Trials;
use crate::real::{Tried, confirm, explore};
use crate::{Refit, Rollouts, Schedule};

/// Dyna-style learning inside a learned model: warm-up, fit, imagine, improve, and a real rollout now and then.
///
/// # Deviations
/// 1. Imagined rollouts run side by side and are shorter than an episode; some begin anywhere in the trusted region
///    ([`Schedule`] says how many). The paper imagines whole episodes from the task's start states.
/// 2. "While π is not optimal" is the rule of [`crate::Optimality`], judged in the model. For finite N the policy that is
///    optimal there has one real episode to keep what the model promises (within a tenth); else training goes on, with
///    that episode among the data.
///
/// # References
/// Arora, da Silva, Moss (2022), *Model-Based Reinforcement Learning with SINDy*, Algorithm 1.
pub struct Dyna<'a, L> {
    /// What is to be achieved.
    pub task: &'a dyn Task,
    /// What the agent sees of an imagined state.
    pub sensors: &'a dyn Observe,
    /// Who makes a model of the real data.
    pub learner: &'a L,
    /// How much of what is done.
    pub schedule: &'a Schedule,
    /// Where all randomness comes from.
    pub seed: Seed,
}

/// What a run leaves.
#[derive(Debug, Clone)]
pub struct Learned<M, P> {
    /// All real data, every step and reset.
    pub data: Dataset,
    /// The model fitted last; none for learners that make none.
    pub model: Option<M>,
    /// The policy that was best in the model; none if training never came to a trial.
    pub policy: Option<P>,
    /// What that policy scored in the model.
    pub model_return: Option<f64>,
    /// Whether the stop rule called it optimal in the model.
    pub optimal_in_model: bool,
    /// Updates made.
    pub updates: u64,
    /// Steps imagined.
    pub model_steps: u64,
    /// Imagined rollouts that were ended, for whatever reason.
    pub model_rollouts: u64,
    /// Imagined rollouts cut because the model diverged.
    pub diverged: u64,
    /// Imagined rollouts ended because they left the trusted region.
    pub left_region: u64,
    /// Why training stopped short, if it did; what was learned before is all here.
    pub failure: Option<AgentError>,
    /// Whether somebody stopped it before it was done.
    pub interrupted: bool,
}

impl<M, P> Learned<M, P> {
    /// The same with the policy wrapped by `wrap`.
    pub fn map_policy<Q>(self, wrap: impl FnOnce(P) -> Q) -> Learned<M, Q> {
        Learned {
            policy: self.policy.map(wrap),
            data: self.data,
            model: self.model,
            model_return: self.model_return,
            optimal_in_model: self.optimal_in_model,
            updates: self.updates,
            model_steps: self.model_steps,
            model_rollouts: self.model_rollouts,
            diverged: self.diverged,
            left_region: self.left_region,
            failure: self.failure,
            interrupted: self.interrupted,
        }
    }
}

/// Why a run ended without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DynaError {
    /// The real system failed.
    #[error("collecting real data failed")]
    Collect(#[source] CollectError),
    /// No model could be made of the data.
    #[error("identification failed")]
    Fit(#[from] FitError),
    /// Rollouts cannot branch off from states that are not seen.
    #[error(transparent)]
    Unseen(#[from] Unseen),
    /// A trial in the model failed.
    #[error("a trial in the model failed")]
    Trial(#[source] EnvError),
    /// What was found could not be written down.
    #[error("recording failed")]
    Record(#[source] io::Error),
}

impl From<CollectError> for DynaError {
    fn from(error: CollectError) -> Self {
        Self::Collect(error)
    }
}

impl From<ImproveError> for DynaError {
    fn from(error: ImproveError) -> Self {
        match error {
            ImproveError::Trial(e) => Self::Trial(e),
            ImproveError::Observer(e) => Self::Record(e),
        }
    }
}

impl From<io::Error> for DynaError {
    fn from(error: io::Error) -> Self {
        Self::Record(error)
    }
}

impl<L: DynamicsLearner> Dyna<'_, L> {
    /// Runs Algorithm 1 on the real system `env` with `agent`; `interrupted` is asked often whether to stop.
    ///
    /// # Errors
    /// [`DynaError`]; what `observer` was told before it happened.
    pub fn run<A: Agent>(
        &self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        agent: A,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Learned<L::Model, A::Frozen>, DynaError> {
        let spec = self.task.spec();
        let (m, k) = (spec.observation_dim(), spec.action_space.action_dim());
        let mut data = Dataset::new(m, spec.control_dim(), k, spec.dt);
        let mut real_rng = self.seed.stream("real system", 0);
        for _ in 0..self.schedule.warmup_rollouts {
            let actor = Actor::Explorer(explorer);
            collect(env, actor, Amount::Steps(self.schedule.rollout_len), &mut data, &mut real_rng, interrupted)?;
        }
        observer.on(&Event::Collected { data: &data })?;

        let mut learned = Learned {
            data,
            model: None,
            policy: None,
            model_return: None,
            optimal_in_model: false,
            updates: 0,
            model_steps: 0,
            model_rollouts: 0,
            diverged: 0,
            left_region: 0,
            failure: None,
            interrupted: interrupted(),
        };
        if learned.interrupted {
            return Ok(learned);
        }
        let mut fit_rng = self.seed.stream("identification", 0);
        let model = match self.learner.fit(&learned.data, None, &mut fit_rng) {
            Ok(Some(model)) => model,
            Ok(None) => return Ok(learned),
            Err(FitError::Interrupted) => {
                learned.interrupted = true;
                return Ok(learned);
            }
            Err(error) => return Err(error.into()),
        };
        self.tell(&model, &learned.data, observer)?;

        let schedule = self.schedule;
        let mut improvement = Improvement {
            agent,
            replay: Replay::new(schedule.replay_capacity, m, k),
            trials: Trials::new(&schedule.optimality),
            best: None,
            updates: 0,
            counts: Counts::default(),
            rng: self.seed.stream("updates", 0),
            batch: Batch::zeros(schedule.batch_size, m, k),
        };
        let mut model = model;
        let mut least_short: Option<Tried<A::Frozen>> = None;
        let mut turn = 0;
        while !learned.interrupted {
            let region = Region::around(spec, &learned.data);
            let worst_value = worst_value(&learned.data, schedule.discount);
            let imagined = Imagined::new(&model, self.task, self.sensors, &region, worst_value);
            let stop = improvement.run(&imagined, schedule, self.seed, turn, observer, interrupted)?;
            turn += 1;
            match (stop, schedule.imagined_rollouts, improvement.best.clone()) {
                (Stop::Failed(error), ..) => {
                    learned.failure = Some(error);
                    break;
                }
                (Stop::Interrupted, ..) => {
                    learned.interrupted = true;
                    break;
                }
                (Stop::Done { optimal: true }, Rollouts::Count(_), Some(best)) => {
                    let data = &mut learned.data;
                    let tried =
                        confirm(env, &mut improvement, &imagined, best.policy, data, &mut real_rng, interrupted)?;
                    let kept = tried.kept();
                    // Fine-tuning may make a policy worse: the one that came nearest to its promise is handed over.
                    if least_short.as_ref().is_none_or(|least| tried.shortfall() <= least.shortfall()) {
                        least_short = Some(tried);
                    }
                    observer.on(&Event::Collected { data: &learned.data })?;
                    if kept || improvement.updates >= schedule.optimality.max_updates {
                        learned.optimal_in_model = true;
                        break;
                    }
                    improvement.trials.renew();
                }
                (Stop::Done { optimal }, ..) => {
                    learned.optimal_in_model = optimal;
                    break;
                }
                (Stop::RealDue, ..) => {
                    explore(env, &mut improvement, &mut learned.data, &mut real_rng, interrupted)?;
                    observer.on(&Event::Collected { data: &learned.data })?;
                }
            }
            if schedule.refit == Refit::AfterRollouts {
                match self.learner.fit(&learned.data, Some(&model), &mut fit_rng) {
                    Ok(fitted) => model = fitted.unwrap_or(model),
                    Err(FitError::Interrupted) => {
                        learned.interrupted = true;
                        break;
                    }
                    Err(error) => return Err(error.into()),
                }
                self.tell(&model, &learned.data, observer)?;
                improvement.start_over();
            }
        }
        if let Some(tried) = least_short {
            improvement.keep(tried.policy);
        }
        learned.updates = improvement.updates;
        learned.model_steps = improvement.counts.steps;
        learned.model_rollouts = improvement.counts.rollouts;
        learned.diverged = improvement.counts.diverged;
        learned.left_region = improvement.counts.left_region;
        learned.model_return = improvement.best.as_ref().map(|best| best.model_return);
        learned.policy = improvement.best.map(|best| best.policy);
        learned.model = Some(model);
        Ok(learned)
    }

    /// Tells `observer` of `model`, fitted to `data`.
    fn tell(&self, model: &L::Model, data: &Dataset, observer: &mut dyn Observer) -> io::Result<()> {
        let rows = self.learner.rows(model, data);
        observer.on(&Event::Fitted { rows, description: &self.learner.describe(model) })
    }
}

/// The value of being paid the worst reward seen for ever, or nothing if that is better for no one:
/// min(0, min r) / (1 − γ).
fn worst_value(data: &Dataset, discount: f64) -> f64 {
    let worst = data.rollouts().flat_map(|r| r.rewards.to_vec()).fold(0.0, f64::min);
    worst / (1.0 - discount)
}
