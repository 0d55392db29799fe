//! Algorithm 1 as a value that is advanced step by step.

mod saved;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sindyna_core::{
    Agent, AgentError, Batch, Certainty, Dataset, DynamicsLearner, EnvError, Environment, Event, Explorer, FitError,
    Inverse, Knowledge, Mode, Observer, Replay, Rng, Seed, TrainedPolicy,
};

use crate::algorithm::{Dyna, DynaError, Learned};
use crate::belief::Belief;
use crate::collect::{Actor, Amount, collect};
use crate::evaluate::evaluate;
use crate::explore::Holding;
use crate::imagine::{Counts, Dreamer, Imagination, Trial};
use crate::optimality::Trials;
use crate::predict::Prediction;
use crate::real::{Confirmation, confirm, remember};
use crate::surprise::is_surprised;
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
            self.trials = Trials::beside(held(&belief, episodes, seed).map_err(DynaError::Trial)?);
        }
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

    fn improve(&mut self, observer: &mut dyn Observer, interrupted: &dyn Fn() -> bool) -> Result<Phase, DynaError> {
        let schedule = self.parts.schedule;
        let rule = &schedule.optimality;
        let Some(imagination) = &mut self.imagination else { return Ok(Phase::Fit) };
        let first_steps = schedule.random_steps.clamp(1, self.replay.capacity());
        if self.replay.len() < first_steps {
            // Only who has not learned anything yet acts at random.
            let dreamer = if self.is_beginner { Dreamer::Random } else { Dreamer::Policy(&*self.agent) };
            imagination.turn(&dreamer, &mut self.replay, &mut self.counts);
            // Nothing can be learned in a model that blows up from nearly every state.
            let hopeless = imagination.diverged > schedule.random_steps as u64;
            if self.is_beginner && self.replay.len() >= first_steps {
                self.is_beginner = false;
                self.agent.expect(&self.replay.observed());
            }
            return Ok(if hopeless { Phase::Predict } else { Phase::Improve });
        }
        imagination.turn(&Dreamer::Policy(&*self.agent), &mut self.replay, &mut self.counts);
        let left = rule.max_updates.saturating_sub(self.updates);
        for _ in 0..left.min(schedule.updates_per_turn as u64) {
            self.replay.sample_into(&mut self.batch, &mut self.rng);
            if let Err(error) = self.agent.learn(&self.batch, &mut self.rng) {
                self.failure = Some(error);
                return Ok(Phase::Predict);
            }
            self.updates += 1;
            if self.updates.is_multiple_of(rule.trial_every) {
                self.try_out(observer)?;
            }
            // A turn may be as many updates as one likes.
            if interrupted() {
                return Ok(Phase::Improve);
            }
        }
        self.optimal = self.trials.optimal(rule);
        if self.optimal || self.updates >= rule.max_updates {
            let asked = self.is_doubted() && self.best.is_some() && self.may_ask(self.parts.task.spec().max_steps);
            return Ok(if asked { Phase::Confirm } else { Phase::Predict });
        }
        let rollouts = self.imagination.as_ref().map_or(0, |i| i.rollouts);
        let due = matches!(schedule.imagined_rollouts, Rollouts::Count(n) if rollouts >= n);
        Ok(if due && self.may_ask(self.parts.task.spec().max_steps) { Phase::Explore } else { Phase::Improve })
    }

    /// Runs the deterministic policy in the model and keeps it if it is the best so far.
    fn try_out(&mut self, observer: &mut dyn Observer) -> Result<(), DynaError> {
        let Some(Imagination { belief, .. }) = &self.imagination else { return Ok(()) };
        let rule = &self.parts.schedule.optimality;
        observer.on(&Event::Updated {
            updates: self.updates,
            max_updates: rule.max_updates,
            model_steps: self.counts.steps,
            diverged: self.counts.diverged,
            left_region: self.counts.left_region,
            metrics: &self.agent.metrics(),
        })?;
        let policy = self.agent.policy();
        let mut worlds: Vec<Trial<'_>> = (0..rule.trial_episodes).map(|i| Trial::new(belief, i)).collect();
        let returns = evaluate(&mut worlds, &*policy, rule.trial_episodes, self.parts.seed, "trial in the model")
            .map_err(DynaError::Trial)?;
        let mean = |values: f64| values / returns.len().max(1) as f64;
        let charged = mean(worlds.iter().map(Trial::charged).sum());
        let model_return = mean(returns.iter().sum()) + charged;
        let far = mean(worlds.iter().map(Trial::far).sum());
        if self.trials.note(rule, (&returns, far), belief.stakes.ceiling) {
            self.best = Some(Best { policy, model_return });
        }
        let best_return = self.best.as_ref().map_or(model_return, |best| best.model_return);
        observer.on(&Event::Imagined { updates: self.updates, mean_return: model_return, best_return })?;
        Ok(())
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

    fn predict(&mut self) -> Result<Phase, DynaError> {
        let misfit = self.tried.as_ref().map_or(0.0, |(_, confirmation)| confirmation.misfit());
        if let Some((best, _)) = &self.tried {
            self.best = Some(best.clone());
        }
        if let (Some(Imagination { belief, .. }), Some(best)) = (&self.imagination, &self.best) {
            let seed = self.parts.seed;
            self.prediction = Some(Prediction::new(belief, &*best.policy, misfit, seed).map_err(DynaError::Trial)?);
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

/// The best mean return of one action held all the time, over `episodes` episodes in the models of `belief`.
fn held(belief: &Belief<'_>, episodes: usize, seed: Seed) -> Result<Option<f64>, EnvError> {
    let mut best: Option<f64> = None;
    for policy in Holding::each(&belief.task.spec().action_space) {
        let mut worlds: Vec<Trial<'_>> = (0..episodes).map(|i| Trial::new(belief, i)).collect();
        let returns = evaluate(&mut worlds, &policy, episodes, seed, "trial in the model")?;
        let mean = returns.iter().sum::<f64>() / returns.len().max(1) as f64;
        best = Some(best.map_or(mean, |best| best.max(mean)));
    }
    Ok(best)
}
