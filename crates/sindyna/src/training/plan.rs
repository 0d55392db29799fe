//! What a run is put together from.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use sindyna_core::{Agent, Explorer, Seed, Spec};
use sindyna_dyna::Schedule;
use sindyna_rl::Isa;

use super::learner::Learner;
use crate::Error;
use crate::settings::TrainConfig;

/// What a run is put together from, besides its problem.
pub(crate) struct Plan {
    pub(crate) learner: Learner,
    pub(crate) schedule: Schedule,
    pub(crate) agent: Box<dyn Agent>,
    pub(crate) isa: Isa,
    pub(crate) explorer: Box<dyn Explorer>,
}

impl Plan {
    /// For the system `spec`; fits end soon after `stop` is set.
    pub(crate) fn new(config: &TrainConfig, spec: &Spec, stop: Arc<AtomicBool>) -> Result<Self, Error> {
        let mut weights = Seed::new(config.seed).stream("initial weights", 0);
        Ok(Self {
            learner: Learner { identifier: config.identifier(spec)?, stop },
            schedule: config.schedule(),
            agent: config.agent(spec, &mut weights)?,
            isa: config.isa()?,
            explorer: config.warmup.explorer.explorer(spec),
        })
    }
}
