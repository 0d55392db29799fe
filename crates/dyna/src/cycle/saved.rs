//! A loop as bytes.

use sindyna_core::{Agent, CheckpointError, DynamicsLearner, Explorer, decode, encode};

use super::{Best, Course, Loop, Phase};
use crate::DynaError;
use crate::imagine::Imagination;
use crate::real::Confirmation;

/// A policy as bytes, and its mean return in the model.
type Kept = (Vec<u8>, f64);

impl Best {
    fn save(&self) -> Kept {
        (self.policy.to_bytes(), self.model_return)
    }

    fn read((policy, model_return): Kept, agent: &dyn Agent) -> Result<Self, CheckpointError> {
        Ok(Self { policy: agent.read_policy(&policy)?, model_return })
    }
}

/// What is saved besides the base and the course: best policy, policy that was tried, imagination and explorer.
type Rest = (Option<Kept>, Option<(Kept, Confirmation)>, Option<Vec<u8>>, Vec<u8>);

impl<L: DynamicsLearner + ?Sized> Loop<'_, L> {
    /// The loop and its `explorer` as bytes, to go on from by [`Dyna::resume`](crate::Dyna::resume). Only between two steps that were not interrupted: what
    /// [`Loop::advance`] did not do to the end is not in it. `None` once there is nothing more to go on with but the result, and for planners, which are
    /// made of their model and not of bytes.
    pub fn save(&self, explorer: &dyn Explorer) -> Option<Vec<u8>> {
        if self.base.failure.is_some() || self.course.phase == Phase::Done || !self.planned.is_empty() {
            return None;
        }
        let tried = self.tried.as_ref().map(|(best, confirmation)| (best.save(), confirmation.clone()));
        let imagination = self.imagination.as_ref().map(Imagination::save);
        let rest: Rest = (self.best.as_ref().map(Best::save), tried, imagination, explorer.save());
        Some(encode(&(self.base.save(), &self.course, rest)))
    }

    /// Makes a loop that has just begun the one that was saved.
    pub(crate) fn restore(&mut self, explorer: &mut dyn Explorer, saved: &[u8]) -> Result<(), DynaError> {
        let (base, course, (best, tried, imagination, explored)): (Vec<u8>, Course, Rest) = decode(saved)?;
        self.base.restore(&base)?;
        explorer.restore(&explored)?;
        let read = |kept| Best::read(kept, &*self.base.agent);
        self.best = best.map(read).transpose()?;
        self.tried = tried.map(|(kept, confirmation)| Ok::<_, DynaError>((read(kept)?, confirmation))).transpose()?;
        self.course = course;
        if let Some(imagination) = &imagination {
            let turn = self.course.turns.saturating_sub(1);
            let belief = self
                .belief(turn, self.course.believed)
                .ok_or_else(|| CheckpointError::new("imagination without a model"))?;
            let mut begun = self.imagination(belief, turn);
            begun.restore(imagination)?;
            self.imagination = Some(begun);
        }
        Ok(())
    }
}
