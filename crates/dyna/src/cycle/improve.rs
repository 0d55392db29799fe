//! Improving a policy in the model, and telling when it is optimal there.

use std::sync::Arc;

use sindyna_core::{Certainty, DynamicsLearner, Event, Observer, Policy, TrainedPolicy};

use super::{Best, Course, Loop, Phase};
use crate::base::{Base, Progress};
use crate::explore::Uniform;
use crate::imagine::Imagination;
use crate::tried::{TRIAL, Tried};
use crate::{DynaError, Rollouts};

impl<L: DynamicsLearner + ?Sized> Loop<'_, L> {
    pub(super) fn improve(
        &mut self,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Phase, DynaError> {
        if let Some(next) = self.plan(observer, interrupted)? {
            return Ok(next);
        }
        let schedule = self.parts.schedule;
        let rule = &schedule.optimality;
        let Some(imagination) = &mut self.imagination else { return Ok(Phase::Fit) };
        let Base { agent, progress, .. } = &mut self.base;
        let first_steps = schedule.random_steps.clamp(1, progress.replay.capacity());
        if progress.replay.len() < first_steps {
            // Only who has not learned anything yet acts at random.
            let random = Uniform::new(self.parts.task.spec());
            let policy: &dyn Policy = if self.course.is_beginner { &random } else { &**agent };
            imagination.turn(policy, progress);
            // Nothing can be learned in a model that blows up from nearly every state.
            let hopeless = imagination.diverged > schedule.random_steps as u64;
            if self.course.is_beginner && progress.replay.len() >= first_steps {
                self.course.is_beginner = false;
                agent.expect(&progress.replay.observed());
            }
            return Ok(if hopeless { Phase::Predict } else { Phase::Improve });
        }
        imagination.turn(&**agent, progress);
        let left = rule.max_updates.saturating_sub(progress.updates);
        for _ in 0..left.min(schedule.updates_per_turn as u64) {
            if !self.base.update(None) {
                return Ok(Phase::Predict);
            }
            if self.base.progress.updates.is_multiple_of(rule.trial_every) {
                self.try_out(observer)?;
            }
            // A turn may be as many updates as one likes.
            if interrupted() {
                return Ok(Phase::Improve);
            }
        }
        self.course.optimal = self.course.trials.optimal(rule) && !self.was_luck()? && !self.challenge()?;
        if self.course.optimal || self.base.progress.updates >= rule.max_updates {
            let asked = self.is_doubted() && self.best.is_some() && self.may_ask(self.parts.task.max_steps());
            if asked && self.wants_to_know() {
                return Ok(Phase::CollectMore);
            }
            return Ok(if asked { Phase::Confirm } else { Phase::Predict });
        }
        let rollouts = self.imagination.as_ref().map_or(0, |i| i.rollouts);
        let due = matches!(schedule.imagined_rollouts, Rollouts::Count(n) if rollouts >= n);
        Ok(if due && self.may_ask(self.parts.task.max_steps()) { Phase::Explore } else { Phase::Improve })
    }

    /// Whether the best policy has to hold against a second agent, which then begins: once, where the model is not exact. Where it is, training is most of the time that a run
    /// takes, and none of 500 runs on the tasks that come along ended so; on others some do (docs/notes).
    fn challenge(&mut self) -> Result<bool, DynaError> {
        let Course { is_challenged, ref trials, turns, believed, .. } = self.course;
        if is_challenged || trials.is_perfect() || self.certainty() == Certainty::Exact {
            return Ok(false);
        }
        let (Some(best), Some(belief)) = (self.best.clone(), self.belief(turns, believed)) else { return Ok(false) };
        self.course.is_challenged = true;
        self.course.trials = self.course.trials.of_second();
        self.learn_anew()?;
        self.base.forget_imagined();
        self.imagine(belief);
        self.try_policy(best.policy)?;
        Ok(true)
    }

    /// Whether the best policy earns less from start states that no trial began in. Then it is tried again, from more of them.
    fn was_luck(&mut self) -> Result<bool, DynaError> {
        self.foresee()?;
        let (Some(prediction), Some(best)) = (&self.prediction, &self.best) else { return Ok(false) };
        let luck =
            self.course.trials.was_luck(&self.parts.schedule.optimality, best.model_return, &prediction.returns());
        if luck {
            self.try_policy(best.policy.clone())?;
        }
        Ok(luck)
    }

    /// Tries the deterministic policy in the model, and tells about it.
    fn try_out(&mut self, observer: &mut dyn Observer) -> Result<(), DynaError> {
        let Progress { updates, counts, .. } = self.base.progress;
        observer.on(&Event::Updated {
            updates,
            max_updates: self.parts.schedule.optimality.max_updates,
            model_steps: counts.steps,
            diverged: counts.diverged,
            left_region: counts.left_region,
            metrics: &self.base.agent.metrics(),
        })?;
        let mean_return = self.try_policy(self.base.agent.policy())?;
        let best_return = self.best.as_ref().map_or(mean_return, |best| best.model_return);
        observer.on(&Event::Imagined { updates, mean_return, best_return })?;
        Ok(())
    }

    /// Runs `policy` in the model and keeps it if it is the best so far; its mean return.
    fn try_policy(&mut self, policy: Arc<dyn TrainedPolicy>) -> Result<f64, DynaError> {
        let Some(Imagination { belief, .. }) = &self.imagination else { return Ok(f64::NEG_INFINITY) };
        let rule = &self.parts.schedule.optimality;
        let tried = Tried::new(belief, &*policy, (self.course.trials.episodes(rule), self.parts.seed, TRIAL))?;
        let model_return = tried.mean();
        if self.course.trials.note(rule, (&tried.returns, tried.far), belief.stakes.ceiling) {
            self.best = Some(Best { policy, model_return });
            self.prediction = None;
        }
        Ok(model_return)
    }
}
