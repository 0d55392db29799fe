//! Which policy is handed over, and the prediction of its return.

use sindyna_core::DynamicsLearner;

use super::{Loop, Phase};
use crate::DynaError;
use crate::gap::Gap;
use crate::imagine::Imagination;
use crate::predict::Prediction;
use crate::tried::{TRIAL, Tried};

impl<L: DynamicsLearner + ?Sized> Loop<'_, L> {
    /// Whether the interval in which the return is predicted is wide beside what is at stake.
    pub(super) fn is_wide(&self) -> bool {
        let (Some(prediction), Some(best)) = (&self.prediction, &self.best) else { return false };
        // Returns near 0 are no measure of what matters.
        let scale = best.model_return.abs().max(self.course.trials.difference());
        prediction.is_wide(self.tried.as_ref().map_or(scale, |(_, confirmation)| confirmation.scale))
    }

    /// Returns of the best policy in the models, from start states that no trial began in.
    pub(super) fn foresee(&mut self) -> Result<(), DynaError> {
        if let (None, Some(Imagination { belief, .. }), Some(best)) = (&self.prediction, &self.imagination, &self.best)
        {
            self.prediction = Some(Prediction::new(belief, &*best.policy, self.parts.seed).map_err(DynaError::Trial)?);
        }
        Ok(())
    }

    /// Whether training after the last real episode found a policy that earns more than the one to be handed over, in a model that needs no confirmation of it.
    fn is_overtaken(&self) -> Result<bool, DynaError> {
        let (Some(Imagination { belief, .. }), Some(best), Some((tried, _))) =
            (&self.imagination, &self.best, &self.tried)
        else {
            return Ok(false);
        };
        if self.course.trials.is_empty() || self.is_doubted() {
            return Ok(false);
        }
        let episodes = self.course.trials.episodes(&self.parts.schedule.optimality);
        let tried = Tried::new(belief, &*tried.policy, (episodes, self.parts.seed, TRIAL))?;
        Ok(best.model_return > tried.mean())
    }

    pub(super) fn predict(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Phase, DynaError> {
        if self.is_overtaken()? {
            self.tried = None;
        }
        if let Some((best, _)) = &self.tried {
            (self.best, self.prediction) = (Some(best.clone()), None);
        }
        self.foresee()?;
        if !self.planned.is_empty() && interrupted() {
            // A planner that was stopped no longer plans: what it earned then predicts nothing.
            self.prediction = None;
            return Ok(Phase::Predict);
        }
        if let (Some(prediction), Some((_, confirmation))) = (&mut self.prediction, &self.tried) {
            prediction.misfit = confirmation.misfit();
        }
        if let (true, Some(Imagination { belief, .. }), Some(best)) =
            (self.has_alternatives() && self.is_wide(), &self.imagination, &self.best)
        {
            self.gap = Gap::of(belief, &*best.policy, self.parts.seed).map_err(DynaError::Trial)?;
        }
        Ok(Phase::Done)
    }
}
