//! Algorithm 1 as a value that is advanced step by step.

mod ask;
mod handover;
mod improve;
mod plan;
mod saved;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sindyna_core::{
    Agent, Certainty, CheckpointError, DynamicsLearner, Environment, Event, Explorer, Inverse, Mode, Observer,
    TrainedPolicy,
};

use crate::algorithm::{Dyna, Learned};
use crate::base::{Base, Fitted};
use crate::belief::Belief;
use crate::collect::{Actor, Amount};
use crate::gap::Gap;
use crate::imagine::Imagination;
use crate::optimality::Trials;
use crate::predict::Prediction;
use crate::real::{Confirmation, PREDICTED, confirm};
use crate::surprise::is_surprised;
use crate::tried::{OF_PLANNERS, TRIAL, Tried, held};
use crate::{DynaError, Refit, Rollouts};

/// What a [`Loop`] does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Collect the first real data.
    WarmUp,
    /// Fit a model to all real data.
    Fit,
    /// Collect as much data again as there are.
    CollectMore,
    /// Imagine a step of every system, and improve the policy with it.
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

/// Models in which a planner has a real episode, at most.
const REPLANNED: u64 = 5;

/// The best policy so far.
#[derive(Clone)]
struct Best {
    policy: Arc<dyn TrainedPolicy>,
    /// Mean return in the model.
    model_return: f64,
}

/// What changes besides the [`Base`], and can be written down as it is.
#[derive(Serialize, Deserialize)]
struct Course {
    phase: Phase,
    trials: Trials,
    optimal: bool,
    /// Rollouts that the model was fitted to.
    fitted: usize,
    /// Steps that imagination goes by.
    believed: usize,
    /// Whether the model before predicted as well what came in after it.
    is_tested: bool,
    /// Whether a confirmation episode agreed with its prediction, and the next model has to predict the same.
    in_review: bool,
    /// Start states of the trials that it was chosen by.
    tried_from: usize,
    /// Whether the agent has learned nothing yet.
    is_beginner: bool,
    /// Whether a second agent learns, or has learned, in this model.
    is_challenged: bool,
    /// Times imagination began anew.
    turns: u64,
    /// Why no model could be fitted to the data that came in last, if so: what is known is in doubt.
    refit_failure: Option<String>,
}

/// Algorithm 1 on its way, between two of its steps.
pub struct Loop<'a, L: DynamicsLearner + ?Sized> {
    parts: &'a Dyna<'a, L>,
    base: Base<'a, L>,
    course: Course,
    /// The agent's state before it learned anything.
    beginner: Vec<u8>,
    imagination: Option<Imagination<'a>>,
    best: Option<Best>,
    /// The policy to be handed over of those that were on the system.
    tried: Option<(Best, Confirmation)>,
    prediction: Option<Prediction>,
    /// What to collect next, where the prediction is wide.
    gap: Option<Gap>,
    /// What each planner earned in the model; none where the agent learns.
    planned: Vec<(&'static str, f64)>,
}

impl<'a, L: DynamicsLearner + ?Sized> Loop<'a, L> {
    pub(crate) fn new(parts: &'a Dyna<'a, L>, agent: Box<dyn Agent>) -> Self {
        let (spec, schedule, seed) = (parts.task.spec(), parts.schedule, parts.seed);
        let sizes = (schedule.batch_size, schedule.replay_capacity);
        Self {
            parts,
            beginner: agent.save(),
            base: Base::new(parts.learner, agent, (spec, seed), sizes),
            course: Course {
                phase: Phase::WarmUp,
                trials: Trials::default(),
                optimal: false,
                fitted: 0,
                believed: 0,
                is_tested: false,
                in_review: false,
                tried_from: 0,
                is_beginner: true,
                is_challenged: false,
                turns: 0,
                refit_failure: None,
            },
            imagination: None,
            best: None,
            tried: None,
            prediction: None,
            gap: None,
            planned: Vec::new(),
        }
    }

    /// What comes next.
    pub fn phase(&self) -> Phase {
        self.course.phase
    }

    /// Whether there is nothing more to do, or a fit was told to stop.
    pub fn has_ended(&self) -> bool {
        self.course.phase == Phase::Done || self.base.stopped
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
        let next = self.next(env, explorer, observer, interrupted);
        if let Err(DynaError::Collect(_)) = &next {
            // What was collected before the system failed is told all the same: it cannot be had again.
            observer.on(&Event::Collected { data: self.base.data() })?;
        }
        self.course.phase = next?;
        Ok(self.course.phase)
    }

    fn next(
        &mut self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Phase, DynaError> {
        Ok(match self.course.phase {
            Phase::WarmUp => {
                let steps = Amount::Steps(self.first_steps());
                for _ in 0..self.parts.schedule.warmup_rollouts {
                    let real = &mut self.base.progress.real;
                    real.collect(env, Actor::Explorer(explorer), steps, interrupted)?;
                }
                self.collected(observer)?
            }
            Phase::Fit => self.fit(observer)?,
            Phase::CollectMore => {
                self.collect_more(env, explorer, interrupted)?;
                self.collected(observer)?
            }
            Phase::Improve => self.improve(observer, interrupted)?,
            Phase::Confirm => self.confirm(env, observer, interrupted)?,
            Phase::Explore => {
                let actor = Actor::policy(&*self.base.agent, Mode::Explore);
                let real = &mut self.base.progress.real;
                real.collect(env, actor, Amount::Episode(self.parts.task.max_steps()), interrupted)?;
                self.collected(observer)?
            }
            Phase::Predict => self.predict(interrupted)?,
            Phase::Done => Phase::Done,
        })
    }

    /// Real data came in: they are learned from, and the model is fitted anew or imagination begun anew.
    fn collected(&mut self, observer: &mut dyn Observer) -> Result<Phase, DynaError> {
        observer.on(&Event::Collected { data: self.base.data() })?;
        self.base.remember();
        Ok(Phase::Fit)
    }

    fn fit(&mut self, observer: &mut dyn Observer) -> Result<Phase, DynaError> {
        let Dyna { task, learner, schedule, seed, .. } = *self.parts;
        let refitted = self.base.knowledge.is_some();
        let fits = !refitted || schedule.refit == Refit::AfterRollouts;
        if let (Some(model), Ok(inverse)) = (self.base.model(), Inverse::of(task.spec())) {
            let mut rng = seed.stream("surprise", self.course.fitted as u64);
            let data = self.base.data();
            self.course.is_tested = !is_surprised(model, &inverse, data, self.course.fitted, &mut rng);
        }
        if fits {
            self.course.fitted = self.base.data().n_rollouts();
            match self.base.fit() {
                Ok(Fitted::Model) => self.course.refit_failure = None,
                Ok(Fitted::Nothing) if refitted => {}
                Ok(Fitted::Nothing) => return Ok(Phase::Done),
                Ok(Fitted::Stopped) => return Ok(Phase::Fit),
                // Half of the first steps may be too few.
                Err(_) if self.first_steps_left() > 0 => return Ok(Phase::CollectMore),
                // What was known is not lost, and may do for data to come.
                Err(error) if refitted => {
                    let (rows, reason) = (self.base.data().n_steps(), error.to_string());
                    observer.on(&Event::NotFitted { rows, reason: &reason })?;
                    self.course.refit_failure = Some(reason);
                }
                Err(error) => return Err(error.into()),
            }
            let data = self.base.data();
            if let (Some(model), None) = (self.base.model(), &self.course.refit_failure) {
                let (rows, description) = (learner.rows(model, data), learner.describe(model));
                observer.on(&Event::Fitted { rows, description: &description })?;
            }
            self.base.forget_older_models();
        }
        if self.first_steps_left() > 0 && self.asks() {
            return Ok(Phase::CollectMore);
        }
        let in_review = std::mem::take(&mut self.course.in_review);
        if !in_review && (self.wants_more() || self.wants_one_model()) {
            return Ok(Phase::CollectMore);
        }
        self.course.believed = self.base.data().n_steps();
        let Some(belief) = self.belief(self.course.turns, self.course.believed) else { return Ok(Phase::Done) };
        let stands = in_review && self.stands(&belief)?;
        if in_review && !stands && self.wants_more() {
            return Ok(Phase::CollectMore);
        }
        if fits {
            // What was tried so far was in another model.
            let episodes = schedule.optimality.trial_episodes;
            self.course.trials = Trials::beside(held(&belief, episodes, seed)?);
            self.course.is_challenged = false;
        }
        self.imagine(belief);
        Ok(if stands { Phase::Predict } else { Phase::Improve })
    }

    /// Whether the confirmed policy has the same return in the models of `belief`, which know its episode, as in those before. One episode is a poor
    /// estimate of a mean return; equations that stay the same where it went are better evidence.
    fn stands(&mut self, belief: &Belief<'a>) -> Result<bool, DynaError> {
        let rule = &self.parts.schedule.optimality;
        let Some((best, confirmation)) = &self.tried else { return Ok(false) };
        let exhausted = self.base.progress.updates >= rule.max_updates;
        let tried = Tried::new(belief, &*best.policy, (self.course.tried_from, self.parts.seed, TRIAL))?;
        if exhausted || confirmation.allows(best.model_return - tried.mean()) {
            return Ok(true);
        }
        self.tried = None;
        self.learn_anew()?;
        Ok(false)
    }

    /// What was learned in a model whose prediction failed, or from data too near, hinders learning again.
    fn learn_anew(&mut self) -> Result<(), CheckpointError> {
        self.base.agent.restore(&self.beginner)?;
        self.course.is_beginner = true;
        Ok(())
    }

    /// Begins imagination that goes by `belief`.
    fn imagine(&mut self, belief: Belief<'a>) {
        self.prediction = None;
        self.imagination = Some(self.imagination(belief, self.course.turns));
        self.course.turns += 1;
    }

    /// Imagination number `turn`: of a second agent from the task's start states alone.
    fn imagination(&self, belief: Belief<'a>, turn: u64) -> Imagination<'a> {
        let Dyna { schedule, seed, .. } = *self.parts;
        let scattered = if self.course.is_challenged { 0.0 } else { schedule.scattered_starts };
        Imagination::new(belief, (schedule, scattered), seed, turn)
    }

    /// What imagination number `turn` goes by, after so many real steps; `None` without a model.
    fn belief(&self, turn: u64, steps: usize) -> Option<Belief<'a>> {
        let Dyna { task, sensors, schedule, seed, .. } = *self.parts;
        let data = self.base.data().first(steps);
        let mut rng = seed.stream("belief", turn);
        Some(Belief::of(self.base.knowledge.as_ref()?, task, sensors, &data, schedule.discount, &mut rng))
    }

    /// How well the model explains the data, all of them.
    fn certainty(&self) -> Certainty {
        let fitted = self.base.knowledge.as_ref().filter(|_| self.course.refit_failure.is_none());
        fitted.map_or(Certainty::Doubted, |k| k.certainty)
    }

    /// Whether the model is not believed before the system confirmed it: it is an approximation, or the policy goes where it was never compared with
    /// the system.
    fn is_doubted(&self) -> bool {
        match self.parts.schedule.imagined_rollouts {
            Rollouts::Unlimited => false,
            Rollouts::Count(_) => true,
            Rollouts::Auto => self.certainty() < Certainty::Exact || self.course.trials.is_far(),
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
        let scale = best.model_return.abs().max(self.course.trials.difference());
        let planned = !self.planned.is_empty();
        let models = if planned { belief.n_systems().min(PREDICTED) } else { belief.n_systems() };
        let view = (belief, models, &inverse, scale);
        let confirmation = confirm(env, &*best.policy, view, &mut self.base.progress.real, interrupted)?;
        if interrupted() {
            return Ok(Phase::Confirm);
        }
        observer.on(&Event::Confirmed { real: confirmation.real, predicted: confirmation.expected() })?;
        let (agrees, rule, best_return) = (confirmation.agrees(), &self.parts.schedule.optimality, best.model_return);
        let shown = self.tried.as_ref().filter(|(_, before)| before.agrees()).map(|(before, _)| before.model_return);
        // Training in a new model may make a policy worse: of those that were not confirmed the one with the highest return is handed over.
        if self.tried.as_ref().is_none_or(|(_, before)| agrees || confirmation.real >= before.real) {
            self.tried = Some((best.clone(), confirmation));
        }
        // Planners make no updates: they are asked a few times.
        let replanned = planned && self.course.turns >= REPLANNED;
        let exhausted = replanned || self.base.progress.updates >= rule.max_updates;
        let next = self.collected(observer)?;
        // A policy that works far from the data has widened their support: there may be more to gain beyond for one that was trained within.
        let earlier = !planned && shown.is_none_or(|shown| best_return - shown > rule.gain * scale);
        let refits = self.parts.schedule.refit == Refit::AfterRollouts;
        if exhausted || (agrees && !(self.course.trials.is_far() && earlier)) {
            self.course.in_review = agrees && refits && self.certainty() < Certainty::Exact;
            self.course.tried_from = if planned { OF_PLANNERS } else { self.course.trials.episodes(rule) };
            return Ok(if self.course.in_review { next } else { Phase::Predict });
        }
        if refits {
            self.learn_anew()?;
        }
        self.course.trials.renew();
        Ok(next)
    }

    /// What was learned so far.
    pub fn finish(self) -> Learned<L::Model> {
        let Base { knowledge, progress, failure, .. } = self.base;
        let (model_return, policy) = self.best.map(|best| (best.model_return, best.policy)).unzip();
        Learned {
            interrupted: self.course.phase != Phase::Done,
            model: knowledge.map(|k| k.model),
            trust: self.imagination.map(|imagination| imagination.belief.trust),
            data: progress.real.data,
            policy,
            model_return,
            prediction: self.prediction,
            gap: self.gap,
            planned: self.planned,
            confirmation: self.tried.map(|(_, confirmation)| confirmation),
            converged: self.course.optimal,
            updates: progress.updates,
            model_steps: progress.counts.steps,
            model_rollouts: progress.counts.rollouts,
            diverged: progress.counts.diverged,
            left_region: progress.counts.left_region,
            refit_failure: self.course.refit_failure,
            failure,
        }
    }
}
