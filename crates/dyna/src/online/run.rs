//! Learning while acting begun, resumed, and run to its end.

use sindyna_core::{Agent, DynamicsLearner, Environment, Explorer};

use super::algorithm::{Online, Practised};
use super::turns::OnlineLoop;
use crate::DynaError;

impl<L: DynamicsLearner + ?Sized> Online<'_, L> {
    /// Learning with `agent`, to be advanced step by step.
    ///
    /// # Errors
    /// [`DynaError`] if no run can have the schedule, or if rollouts are to branch off from states that are not seen.
    pub fn begin(&self, agent: Box<dyn Agent>) -> Result<OnlineLoop<'_, L>, DynaError> {
        self.schedule.check()?;
        OnlineLoop::new(self, agent)
    }

    /// The loop that was `saved` by [`OnlineLoop::save`], with a system, an explorer and an agent made as those were. It goes on with the same bits, if task,
    /// sensors, learner, schedule and seed are the same; models that the learner does not write down are fitted again.
    ///
    /// # Errors
    /// [`DynaError::Checkpoint`] if the bytes are of something else, [`DynaError::Fit`] if a fit was told to stop.
    pub fn resume(
        &self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        agent: Box<dyn Agent>,
        saved: &[u8],
    ) -> Result<OnlineLoop<'_, L>, DynaError> {
        let mut begun = self.begin(agent)?;
        begun.restore(env, explorer, saved)?;
        Ok(begun)
    }

    /// Learns on the system `env`; checks are on `judges`, systems of the same kind. `interrupted` is asked often whether to stop.
    ///
    /// # Errors
    /// [`DynaError`] if no run can have the schedule, a system fails or a model cannot be fitted.
    pub fn run<E: Environment>(
        &self,
        env: &mut dyn Environment,
        judges: &mut [E],
        explorer: &mut dyn Explorer,
        agent: Box<dyn Agent>,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Practised<L::Model>, DynaError> {
        let mut begun = self.begin(agent)?;
        while !begun.has_ended() && !interrupted() {
            begun.advance(env, judges, explorer)?;
        }
        Ok(begun.finish())
    }
}
