//! A task on equations that were found in other logs of its system than those of a run.

use std::path::Path;
use std::sync::Arc;

use sindyna_core::{Environment, Protocol, Sensors, Simulated, Spec, Task};
use sindyna_sindy::Model;

use super::Problem;
use super::log_source::LogSource;
use super::recorded::Recorded;
use crate::Error;
use crate::task_file::TaskFile;

/// A task on the equations of a log, which are its system.
pub(super) struct Twin {
    task: TaskFile,
    model: Arc<Model>,
}

impl Twin {
    /// The task file at `path` on the equations found in `source`, with sensors whose noise is the part `noise` of the scale of each channel.
    pub(super) fn load(path: &Path, source: &LogSource, noise: f64) -> Result<Self, Error> {
        let (task, model) = Recorded::load(path, source)?.into_parts();
        Ok(Self { task: task.with_noise(noise), model: Arc::new(model) })
    }
}

impl Problem for Twin {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn protocol(&self) -> Protocol {
        self.task.protocol()
    }

    fn task(&self) -> Arc<dyn Task> {
        self.task.task()
    }

    fn sensors(&self) -> Sensors {
        self.task.sensors()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        Ok(Box::new(Simulated::new(self.model.clone(), self.task(), self.sensors())))
    }

    fn copies(&self) -> usize {
        usize::MAX
    }
}
