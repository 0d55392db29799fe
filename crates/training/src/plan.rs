//! What a run is put together from.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use sindyna_control::Planners;
use sindyna_core::{Agent, Explorer, Seed};
use sindyna_dyna::Schedule;
use sindyna_rl::Isa;

use crate::Error;
use crate::learner::Learner;
use crate::problem::{Problem, Replayed};
use crate::settings::TrainConfig;

/// What a run is put together from, besides its problem.
pub struct Plan {
    /// Who identifies.
    pub learner: Learner,
    /// When what is done.
    pub schedule: Schedule,
    /// Who gives the controller.
    pub agent: Box<dyn Agent>,
    /// Instructions of the updates.
    pub isa: Isa,
    /// Who chooses the first actions on the system.
    pub explorer: Box<dyn Explorer>,
}

impl Plan {
    /// For `problem`; fits end soon after `stop` is set.
    pub fn new(config: &TrainConfig, problem: &dyn Problem, stop: Arc<AtomicBool>) -> Result<Self, Error> {
        let spec = problem.spec();
        let agent = agent_of(config, problem, stop.clone())?;
        Ok(Self {
            learner: Learner { identifier: config.identifier(spec)?, given: problem.identified().cloned(), stop },
            schedule: config.schedule(),
            agent,
            isa: config.isa()?,
            explorer: match problem.log() {
                Some(log) => Box::new(Replayed::new(Arc::new(log.clone()), None)),
                None => config.warmup.explorer.explorer(spec),
            },
        })
    }
}

/// Who gives the controller: it is trained, or it plans until `stop` is set.
pub fn agent_of(config: &TrainConfig, problem: &dyn Problem, stop: Arc<AtomicBool>) -> Result<Box<dyn Agent>, Error> {
    if config.controller.trains() {
        let mut weights = Seed::new(config.seed).stream("initial weights", 0);
        return config.agent(problem.spec(), &mut weights);
    }
    Ok(Box::new(Planners::new(config.controller.methods(), problem.task(), stop)?))
}
