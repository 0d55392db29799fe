//! Algorithm 1 begun, resumed, and run to its end.

use sindyna_core::{Agent, DynamicsLearner, Environment, Explorer, Observer};

use crate::algorithm::{Dyna, Learned};
use crate::cycle::Loop;
use crate::{DynaError, ScheduleError};

impl<L: DynamicsLearner + ?Sized> Dyna<'_, L> {
    /// Algorithm 1 with `agent`, to be advanced step by step.
    ///
    /// # Errors
    /// [`ScheduleError`] if no run can have the schedule.
    pub fn begin(&self, agent: Box<dyn Agent>) -> Result<Loop<'_, L>, ScheduleError> {
        self.schedule.check()?;
        Ok(Loop::new(self, agent))
    }

    /// The loop that was `saved` by [`Loop::save`], with an agent and an explorer made as those were. It goes on with the same bits, if task, sensors,
    /// learner, schedule and seed are the same; a model that the learner does not write down is fitted again.
    ///
    /// # Errors
    /// [`DynaError::Checkpoint`] if the bytes are of something else, [`DynaError::Fit`] if the fit was told to stop.
    pub fn resume(
        &self,
        agent: Box<dyn Agent>,
        explorer: &mut dyn Explorer,
        saved: &[u8],
    ) -> Result<Loop<'_, L>, DynaError> {
        let mut begun = self.begin(agent)?;
        begun.restore(explorer, saved)?;
        Ok(begun)
    }

    /// Runs Algorithm 1 on the system `env` with `agent`; `interrupted` is asked often whether to stop.
    ///
    /// # Errors
    /// [`DynaError`]; what `observer` was told before it happened.
    pub fn run(
        &self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        agent: Box<dyn Agent>,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Learned<L::Model>, DynaError> {
        let mut begun = self.begin(agent)?;
        while !begun.has_ended() {
            begun.advance(env, explorer, observer, interrupted)?;
            if interrupted() {
                break;
            }
        }
        Ok(begun.finish())
    }
}
