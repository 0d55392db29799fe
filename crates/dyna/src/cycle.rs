//! Algorithm 1 as a value that is advanced step by step.

mod improve;
mod saved;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sindyna_core::{
    Agent, AgentError, Batch, Certainty, Dataset, DynamicsLearner, Environment, Event, Explorer, FitError, Inverse,
    Knowledge, Mode, Observer, Replay, Rng, TrainedPolicy,
};

use crate::algorithm::{Dyna, DynaError, Learned};
use crate::belief::Belief;
use crate::collect::{Actor, Amount, collect};
use crate::imagine::{Counts, Imagination};
use crate::optimality::Trials;
use crate::predict::Prediction;
use crate::real::{Confirmation, confirm, remember};
use crate::surprise::is_surprised;
use crate::tried::held;
use crate::{Refit, Rollouts, Schedule};
use saved::Fit;

/// What a [`Loop`] does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Collect the first real data.
    WarmUp,
    /// Fit a model to all real data.
    Fit,
    /// Collect as much data again as there are.
    CollectMore,
    /// Imagine a step of every world, and improve the policy with it.
    Improve,
    /// Let the policy that was best in the model have a real episode.
    Confirm,
    /// Collect a real episode with the policy in training.
    Explore,
    /// Predict what the policy will earn.
    Predict,
    /// Nothing: it is done.
    Done,
}

/// Steps to which data are doubled, as long as something speaks against the model.
const ENOUGH: usize = 2_000;

/// The best policy so far.
#[derive(Clone)]
struct Best {
    policy: Arc<dyn TrainedPolicy>,
    /// Mean return in the model.
    model_return: f64,
}

/// Algorithm 1 on its way, between two of its steps.
pub struct Loop<'a, L: DynamicsLearner + ?Sized> {
    parts: &'a Dyna<'a, L>,
    phase: Phase,
    agent: Box<dyn Agent>,
    /// The agent's state before it learned anything.
    beginner: Vec<u8>,
    data: Dataset,
    knowledge: Option<Knowledge<L::Model>>,
    /// The fits that knowledge comes from.
    fits: Vec<Fit>,
    /// Rollouts that imagination goes by.
    believed: usize,
    imagination: Option<Imagination<'a>>,
    replay: Replay,
    batch: Batch,
    trials: Trials,
    best: Option<Best>,
    /// The policy to be handed over of those that were on the real system.
    tried: Option<(Best, Confirmation)>,
    prediction: Option<Prediction>,
    optimal: bool,
    updates: u64,
    counts: Counts,
    /// Rollouts that the model was fitted to.
    fitted: usize,
    /// Whether the model before predicted as well what came in after it.
    is_tested: bool,
    /// Whether the agent has learned nothing yet.
    is_beginner: bool,
    /// Times imagination began anew.
    turns: u64,
    failure: Option<AgentError>,
    /// Whether a fit was told to stop.
    stopped: bool,
    real_rng: Rng,
    fit_rng: Rng,
    rng: Rng,
}

impl<'a, L: DynamicsLearner + ?Sized> Loop<'a, L> {
    pub(crate) fn new(parts: &'a Dyna<'a, L>, agent: Box<dyn Agent>) -> Self {
        let (spec, schedule, seed) = (parts.task.spec(), parts.schedule, parts.seed);
        let (m, k) = (spec.observation_dim(), spec.action_space.action_dim());
        Self {
            parts,
            phase: Phase::WarmUp,
            beginner: agent.save(),
            agent,
            data: Dataset::new(m, spec.control_dim(), k, spec.dt),
            knowledge: None,
            fits: Vec::new(),
            believed: 0,
            imagination: None,
            replay: Replay::new(schedule.replay_capacity, m, k),
            batch: Batch::zeros(schedule.batch_size, m, k),
            trials: Trials::default(),
            best: None,
            tried: None,
            prediction: None,
            optimal: false,
            updates: 0,
            counts: Counts::default(),
            fitted: 0,
            is_tested: false,
            is_beginner: true,
            turns: 0,
            failure: None,
            stopped: false,
            real_rng: seed.stream("real system", 0),
            fit_rng: seed.stream("identification", 0),
            rng: seed.stream("updates", 0),
        }
    }

    /// What comes next.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Whether there is nothing more to do, or a fit was told to stop.
    pub fn has_ended(&self) -> bool {
        self.phase == Phase::Done || self.stopped
    }

    /// Does what comes next. Ends early, to be continued by the next call, once `interrupted` says so.
    ///
    /// # Errors
    /// [`DynaError`]; what `observer` was told before it happened.
    pub fn advance(
        &mut self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Phase, DynaError> {
        self.phase = match self.phase {
            Phase::WarmUp => self.warm_up(env, explorer, observer, interrupted)?,
            Phase::Fit => self.fit(observer)?,
            Phase::CollectMore => {
                let (actor, amount) = (Actor::Explorer(explorer), Amount::Steps(self.data.n_steps()));
                collect(env, actor, amount, &mut self.data, &mut self.real_rng, interrupted)?;
                observer.on(&Event::Collected { data: &self.data })?;
                Phase::Fit
            }
            Phase::Improve => self.improve(observer, interrupted)?,
            Phase::Confirm => self.confirm(env, observer, interrupted)?,
            Phase::Explore => {
                let actor = Actor::Policy(&*self.agent, Mode::Explore);
                collect(env, actor, Amount::Episode, &mut self.data, &mut self.real_rng, interrupted)?;
                self.collected(observer)?
            }
            Phase::Predict => self.predict()?,
            Phase::Done => Phase::Done,
        };
        Ok(self.phase)
    }

    fn warm_up(
        &mut self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Phase, DynaError> {
        let schedule = self.parts.schedule;
        for _ in 0..schedule.warmup_rollouts {
            let (actor, amount) = (Actor::Explorer(explorer), Amount::Steps(schedule.rollout_len));
            collect(env, actor, amount, &mut self.data, &mut self.real_rng, interrupted)?;
        }
        observer.on(&Event::Collected { data: &self.data })?;
        Ok(Phase::Fit)
    }

    fn fit(&mut self, observer: &mut dyn Observer) -> Result<Phase, DynaError> {
        let Dyna { task, learner, schedule, seed, .. } = *self.parts;
        let previous = self.knowledge.as_ref().map(|k| &*k.model);
        let refitted = previous.is_some();
        let fits = !refitted || schedule.refit == Refit::AfterRollouts;
        if let (Some(model), Ok(inverse)) = (previous, Inverse::of(task.spec())) {
            let mut rng = seed.stream("surprise", self.fitted as u64);
            self.is_tested = !is_surprised(model, &inverse, &self.data, self.fitted, &mut rng);
        }
        if fits {
            self.fitted = self.data.n_rollouts();
            let fit = Fit { rollouts: self.fitted, rng: self.fit_rng.clone() };
            match learner.fit(&self.data, previous, &mut self.fit_rng) {
                Ok(Some(fitted)) => {
                    self.knowledge = Some(fitted);
                    if !learner.goes_on() {
                        self.fits.clear();
                    }
                    self.fits.push(fit);
                }
                Ok(None) if refitted => {}
                Ok(None) => return Ok(Phase::Done),
                Err(FitError::Interrupted) => {
                    self.stopped = true;
                    return Ok(Phase::Fit);
                }
                Err(error) => return Err(error.into()),
            }
            if let Some(Knowledge { model, .. }) = &self.knowledge {
                let (rows, description) = (learner.rows(model, &self.data), learner.describe(model));
                observer.on(&Event::Fitted { rows, description: &description })?;
            }
            // What was imagined so far was in another model.
            self.replay.clear();
            remember(&mut self.replay, &self.data, 0);
        }
        if self.wants_more() {
            return Ok(Phase::CollectMore);
        }
        self.believed = self.data.n_rollouts();
        let Some(belief) = self.belief(self.turns) else { return Ok(Phase::Done) };
        if fits {
            // What was tried so far was in another model.
            let episodes = schedule.optimality.trial_episodes;
            self.trials = Trials::beside(held(&belief, episodes, seed)?);
        }
        self.prediction = None;
        self.imagination = Some(Imagination::new(belief, schedule, seed, self.turns));
        self.turns += 1;
        Ok(Phase::Improve)
    }

    /// What imagination number `turn` goes by; `None` without a model.
    fn belief(&self, turn: u64) -> Option<Belief<'a>> {
        let Dyna { task, sensors, schedule, seed, .. } = *self.parts;
        let data = self.data.first(self.believed);
        let mut rng = seed.stream("belief", turn);
        Some(Belief::of(self.knowledge.as_ref()?, task, sensors, &data, schedule.discount, &mut rng))
    }

    /// How well the model explains the data.
    fn certainty(&self) -> Certainty {
        self.knowledge.as_ref().map_or(Certainty::Doubted, |k| k.certainty)
    }

    /// Whether the real system may be asked for so many `steps`.
    fn may_ask(&self, steps: usize) -> bool {
        self.parts.schedule.max_real_steps.is_none_or(|most| self.data.n_steps() + steps <= most)
    }

    /// Whether to collect as much data again before a policy is learned: something speaks against the model, and it has not yet predicted data that it was
    /// not fitted to as well as its own.
    fn wants_more(&self) -> bool {
        let Schedule { imagined_rollouts, refit, .. } = *self.parts.schedule;
        let asks = imagined_rollouts == Rollouts::Auto && refit == Refit::AfterRollouts;
        let steps = self.data.n_steps();
        asks && self.certainty() == Certainty::Doubted && !self.is_tested && 2 * steps <= ENOUGH && self.may_ask(steps)
    }

    /// Whether the model is not believed before the real system confirmed it: it is an approximation, or the policy goes where it was never compared with
    /// the system.
    fn is_doubted(&self) -> bool {
        match self.parts.schedule.imagined_rollouts {
            Rollouts::Unlimited => false,
            Rollouts::Count(_) => true,
            Rollouts::Auto => self.certainty() < Certainty::Exact || self.trials.is_far(),
        }
    }

    fn confirm(
        &mut self,
        env: &mut dyn Environment,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Phase, DynaError> {
        let (Some(Imagination { belief, .. }), Some(best)) = (&self.imagination, &self.best) else {
            return Ok(Phase::Predict);
        };
        let inverse = Inverse::of(self.parts.task.spec())?;
        // Returns near 0 are no measure of what matters.
        let scale = best.model_return.abs().max(self.trials.difference());
        let view = (belief, &inverse, scale);
        let confirmation = confirm(env, &*best.policy, view, &mut self.data, &mut self.real_rng, interrupted)?;
        if interrupted() {
            return Ok(Phase::Confirm);
        }
        observer.on(&Event::Confirmed { real: confirmation.real, promised: confirmation.expected() })?;
        let (kept, rule, best_return) = (confirmation.is_kept(), &self.parts.schedule.optimality, best.model_return);
        let shown = self.tried.as_ref().filter(|(_, before)| before.is_kept()).map(|(before, _)| before.model_return);
        // Training in a new model may make a policy worse: of those that broke their promise the one that earned most is handed over.
        if self.tried.as_ref().is_none_or(|(_, before)| kept || confirmation.real >= before.real) {
            self.tried = Some((best.clone(), confirmation));
        }
        let exhausted = self.updates >= rule.max_updates;
        let next = self.collected(observer)?;
        // A policy that works far from the data has widened their support: there may be more to gain beyond.
        let earlier = shown.is_none_or(|shown| best_return - shown > rule.gain * scale);
        if exhausted || (kept && !(self.trials.is_far() && earlier)) {
            return Ok(Phase::Predict);
        }
        if self.parts.schedule.refit == Refit::AfterRollouts {
            // What was learned in a model that broke its promise, or from too near, stands in the way of learning anew.
            self.agent.restore(&self.beginner)?;
            self.is_beginner = true;
        }
        self.trials.renew();
        Ok(next)
    }

    /// A real episode was added to the data: it is learned from, and the model fitted anew or imagination begun anew.
    fn collected(&mut self, observer: &mut dyn Observer) -> Result<Phase, DynaError> {
        observer.on(&Event::Collected { data: &self.data })?;
        remember(&mut self.replay, &self.data, self.data.n_rollouts().saturating_sub(1));
        Ok(Phase::Fit)
    }

    /// Returns of the best policy in the models, from start states that no trial began in.
    fn foresee(&mut self) -> Result<(), DynaError> {
        if let (None, Some(Imagination { belief, .. }), Some(best)) = (&self.prediction, &self.imagination, &self.best)
        {
            self.prediction = Some(Prediction::new(belief, &*best.policy, self.parts.seed).map_err(DynaError::Trial)?);
        }
        Ok(())
    }

    fn predict(&mut self) -> Result<Phase, DynaError> {
        if let Some((best, _)) = &self.tried {
            (self.best, self.prediction) = (Some(best.clone()), None);
        }
        self.foresee()?;
        if let (Some(prediction), Some((_, confirmation))) = (&mut self.prediction, &self.tried) {
            prediction.misfit = confirmation.misfit();
        }
        Ok(Phase::Done)
    }

    /// What was learned so far.
    pub fn finish(self) -> Learned<L::Model> {
        let (model_return, policy) = self.best.map(|best| (best.model_return, best.policy)).unzip();
        Learned {
            interrupted: self.phase != Phase::Done,
            model: self.knowledge.map(|k| k.model),
            data: self.data,
            policy,
            model_return,
            prediction: self.prediction,
            confirmation: self.tried.map(|(_, confirmation)| confirmation),
            optimal_in_model: self.optimal,
            updates: self.updates,
            model_steps: self.counts.steps,
            model_rollouts: self.counts.rollouts,
            diverged: self.counts.diverged,
            left_region: self.counts.left_region,
            failure: self.failure,
        }
    }
}
