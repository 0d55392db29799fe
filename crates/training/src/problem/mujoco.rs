//! Systems that come along, with MuJoCo as their physics.

use std::sync::Arc;

use sindyna_core::{Environment, Protocol, Sensors, Spec, Task};
use sindyna_mujoco::{Library, Search, inverted_pendulum_of};

use super::Problem;
use super::native::Native;
use crate::Error;

/// A system that comes along, in MuJoCo; only the inverted pendulum has a model there.
pub(super) struct OnMujoco {
    library: Library,
    native: Native,
}

impl OnMujoco {
    pub(super) fn new(native: Native) -> Result<Self, Error> {
        if native.system().name() != "inverted-pendulum" {
            return Err(Error::NoSimulator { task: native.system().name().into(), simulator: "MuJoCo" });
        }
        Ok(Self { library: Library::load(&Search::from_environment())?, native })
    }
}

impl Problem for OnMujoco {
    fn spec(&self) -> &Spec {
        self.native.spec()
    }

    fn protocol(&self) -> Protocol {
        self.native.protocol()
    }

    fn task(&self) -> Arc<dyn Task> {
        self.native.task()
    }

    fn sensors(&self) -> Sensors {
        self.native.sensors()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        Ok(Box::new(inverted_pendulum_of(&self.library, self.native.system())?))
    }

    fn true_equations(&self) -> Vec<String> {
        self.native.true_equations()
    }
}
