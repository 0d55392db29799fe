//! Systems that come along, simulated in this program.

use std::sync::Arc;

use sindyna_core::{Dynamics, Environment, Protocol, Sensors, Spec, Task};
use sindyna_envs::System;

use super::Problem;
use crate::Error;

/// A system that comes along.
pub(super) struct Native(System);

impl Native {
    pub(super) fn new(system: System) -> Self {
        Self(system)
    }

    pub(super) fn shared(system: System) -> Arc<dyn Problem> {
        Arc::new(Self(system))
    }

    pub(super) fn system(&self) -> &System {
        &self.0
    }
}

impl Problem for Native {
    fn spec(&self) -> &Spec {
        self.0.spec()
    }

    fn protocol(&self) -> Protocol {
        self.0.protocol()
    }

    fn task(&self) -> Arc<dyn Task> {
        self.0.task()
    }

    fn sensors(&self) -> Sensors {
        self.0.sensors()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        Ok(Box::new(self.0.environment()))
    }

    fn dynamics(&self) -> Option<Arc<dyn Dynamics>> {
        Some(self.0.dynamics())
    }

    fn true_equations(&self) -> Vec<String> {
        self.0.true_equations().iter().map(ToString::to_string).collect()
    }
}
