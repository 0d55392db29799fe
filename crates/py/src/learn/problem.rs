//! A system with its task, to be trained on.

use std::sync::Arc;

use pyo3::prelude::*;
use sindyna::Error;
use sindyna::core::{Environment, Protocol, Sensors, Spec, Task};
use sindyna::problem::Problem;

use super::outside::{Outside, Raised};
use super::task::PyTask;

/// A system that Python steps, or none, with a task.
pub(crate) struct Asked {
    pub(crate) task: Arc<PyTask>,
    pub(crate) sensors: Sensors,
    pub(crate) solved_at: Option<f64>,
    pub(crate) object: Option<Py<PyAny>>,
    pub(crate) raised: Raised,
}

impl Problem for Asked {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn protocol(&self) -> Protocol {
        Protocol { max_steps: self.task.max_steps(), solved_at: self.solved_at }
    }

    fn task(&self) -> Arc<dyn Task> {
        self.task.clone()
    }

    fn sensors(&self) -> Sensors {
        self.sensors.clone()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        let refused = |why: &str| Error::System { name: self.spec().name.clone(), why: why.into() };
        let object = self.object.as_ref().ok_or_else(|| refused("there is none, only data of it"))?;
        let object = Python::attach(|py| object.clone_ref(py));
        Ok(Box::new(Outside::new(object, self.spec().clone(), self.task.max_steps(), self.raised.clone())))
    }

    fn copies(&self) -> usize {
        1
    }

    fn check(&self) -> Result<(), Error> {
        if self.raised.is_there() {
            return Err(Error::System { name: self.spec().name.clone(), why: "an exception was raised".into() });
        }
        Ok(())
    }
}
