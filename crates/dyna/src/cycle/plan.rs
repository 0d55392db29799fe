//! Policies that need no updates: planned in the model.

use std::sync::Arc;

use sindyna_core::{Dynamics, DynamicsLearner, Event, Observer};

use super::{Best, Loop, Phase};
use crate::DynaError;
use crate::belief::noise_of_states;
use crate::imagine::Imagination;
use crate::tried::{OF_PLANNERS, TRIAL, Tried};

impl<L: DynamicsLearner + ?Sized> Loop<'_, L> {
    /// Tries what the agent plans in the model and keeps the one that earns most; of those that earn about the same, the first. `None` for an agent that learns.
    pub(super) fn plan(
        &mut self,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<Phase>, DynaError> {
        let (Some(knowledge), Some(Imagination { belief, .. })) = (&self.base.knowledge, &self.imagination) else {
            return Ok(None);
        };
        let model: Arc<dyn Dynamics> = knowledge.model.clone();
        let noise = knowledge.sensor_noise.as_ref().map(|noise| noise_of_states(self.parts.task.spec(), noise));
        let policies = self.base.agent.plan(&model, &noise.unwrap_or_default());
        if policies.is_empty() {
            return Ok(None);
        }
        let rule = &self.parts.schedule.optimality;
        (self.planned, self.best, self.prediction) = (Vec::new(), None, None);
        let mut kept: Option<(Best, Tried)> = None;
        for (name, policy) in policies {
            let tried = Tried::new(belief, &*policy, (OF_PLANNERS, self.parts.seed, TRIAL))?;
            if interrupted() {
                return Ok(Some(Phase::Improve));
            }
            let model_return = tried.mean();
            self.planned.push((name, model_return));
            let gains = |(best, _): &(Best, Tried)| {
                let unit = best.model_return.abs().max(model_return.abs());
                model_return > best.model_return + rule.gain * unit
            };
            if kept.as_ref().is_none_or(gains) {
                kept = Some((Best { policy, model_return }, tried));
            }
            let best_return = kept.as_ref().map_or(model_return, |(best, _)| best.model_return);
            observer.on(&Event::Imagined { updates: 0, mean_return: model_return, best_return })?;
        }
        if let Some((best, tried)) = kept {
            self.course.trials.note(rule, (&tried.returns, tried.far), belief.stakes.ceiling);
            self.best = Some(best);
        }
        let asked = self.is_doubted() && self.best.is_some() && self.may_ask(self.parts.task.max_steps());
        Ok(Some(if asked { Phase::Confirm } else { Phase::Predict }))
    }
}
