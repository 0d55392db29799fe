//! What the system is asked for: how many steps, when, and by whom.

use sindyna_core::{Certainty, DynamicsLearner, Environment, Explorer, Inverse};

use super::Loop;
use crate::DynaError;
use crate::collect::{Actor, Amount};
use crate::curious::Curious;
use crate::{Refit, Rollouts, Schedule};

/// Steps to which data are doubled, as long as something speaks against the model.
const ENOUGH: usize = 2_000;

/// First real steps of which half are enough to ask by what to collect.
const HALVED: usize = 40;

impl<L: DynamicsLearner + ?Sized> Loop<'_, L> {
    /// First real steps: a loop that learns what to ask has half of them made by the explorer, if that is enough to ask anything by.
    pub(super) fn first_steps(&self) -> usize {
        let Schedule { rollout_len, curious, .. } = *self.parts.schedule;
        if curious && self.asks() && rollout_len >= HALVED { rollout_len / 2 } else { rollout_len }
    }

    /// First real steps that were not made yet.
    pub(super) fn first_steps_left(&self) -> usize {
        let Schedule { warmup_rollouts, rollout_len, .. } = *self.parts.schedule;
        (warmup_rollouts * rollout_len).saturating_sub(self.base.data().n_steps())
    }

    /// Collects real steps that tell the models apart which the data allow; by the `explorer` where there is one model.
    pub(super) fn collect_more(
        &mut self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<(), DynaError> {
        let steps = self.base.data().n_steps();
        let left = self.first_steps_left();
        let amount = Amount::Steps(if left > 0 { left } else { steps });
        let belief = if self.parts.schedule.curious { self.belief(self.course.turns, steps) } else { None };
        let real = &mut self.base.progress.real;
        match (belief, Inverse::of(self.parts.task.spec())) {
            (Some(belief), Ok(inverse)) if belief.trust.has_alternatives() => {
                let mut curious = Curious::new(belief.task, &belief.trust, &inverse);
                real.collect(env, Actor::Explorer(&mut curious), amount, interrupted)?;
            }
            _ => real.collect(env, Actor::Explorer(explorer), amount, interrupted)?,
        }
        Ok(())
    }

    /// Whether the system may be asked for so many `steps`.
    pub(super) fn may_ask(&self, steps: usize) -> bool {
        self.parts.schedule.max_real_steps.is_none_or(|most| self.base.data().n_steps() + steps <= most)
    }

    /// Whether to collect as much data again before a policy is learned: something speaks against the model, and it has not yet predicted data that it was
    /// not fitted to as well as its own.
    pub(super) fn wants_more(&self) -> bool {
        self.certainty() == Certainty::Doubted && !self.course.is_tested && self.may_double()
    }

    /// Whether to collect as much data again before anything is planned, as long as that costs less than the episode that confirms a plan: several models are as good,
    /// and a plan holds in one of them.
    pub(super) fn wants_one_model(&self) -> bool {
        let steps = self.base.data().n_steps();
        let is_cheap = 2 * steps <= self.parts.task.max_steps();
        self.base.agent.plans() && self.certainty() == Certainty::Ambiguous && is_cheap && self.may_double()
    }

    /// Whether a run asks the system for what it needs.
    pub(super) fn asks(&self) -> bool {
        let Schedule { imagined_rollouts, refit, .. } = *self.parts.schedule;
        imagined_rollouts == Rollouts::Auto && refit == Refit::AfterRollouts
    }

    /// Whether the system may be asked for as many steps as there are.
    pub(super) fn may_double(&self) -> bool {
        let steps = self.base.data().n_steps();
        self.asks() && 2 * steps <= ENOUGH && self.may_ask(steps)
    }

    /// Whether imagination goes by models that may disagree.
    pub(super) fn has_alternatives(&self) -> bool {
        self.imagination.as_ref().is_some_and(|imagination| imagination.belief.trust.has_alternatives())
    }

    /// Whether to collect data before a policy has a real episode that the models do not agree on: it could not confirm anything.
    pub(super) fn wants_to_know(&self) -> bool {
        self.parts.schedule.curious && self.has_alternatives() && self.may_double() && self.is_wide()
    }
}
