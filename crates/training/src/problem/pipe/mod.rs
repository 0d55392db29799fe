//! Any program as a system: it is told controls and tells states, a line of JSON each (`docs/pipe.md`).

mod process;
mod protocol;

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use sindyna_core::{Environment, Protocol, Sensors, Spec, Task};

use super::own::{Connected, Plant, PlantError};
use super::traits::Problem;
use crate::Error;
use crate::task_file::TaskFile;
pub use process::PipeSource;
use process::Process;
use protocol::{Reached, Request, Told};

/// A task file on a program.
pub(super) struct Piped {
    file: TaskFile,
    process: Arc<Mutex<Process>>,
}

impl Piped {
    /// Starts the program of `source`, which must be the system that the task file at `path` declares; `noise` is put on what it tells.
    pub(super) fn open(path: &Path, source: &PipeSource, noise: f64) -> Result<Self, Error> {
        let file = TaskFile::without_simulator(path)?;
        let name = || source.command.join(" ");
        let failed = |why: String| Error::Pipe { command: name(), why };
        let mut process = Process::start(source).map_err(failed)?;
        let told: Told = process.ask(&Request::spec(file.spec())).map_err(failed)?;
        told.check(file.spec()).map_err(failed)?;
        let file = match told.precision {
            Some(precision) => file.with_precision(precision.into()),
            None => file,
        };
        Ok(Self { file: file.with_noise(noise), process: Arc::new(Mutex::new(process)) })
    }
}

impl Problem for Piped {
    fn spec(&self) -> &Spec {
        self.file.spec()
    }

    fn protocol(&self) -> Protocol {
        self.file.protocol()
    }

    fn task(&self) -> Arc<dyn Task> {
        self.file.task()
    }

    fn sensors(&self) -> Sensors {
        self.file.sensors()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        Ok(Box::new(Connected::new(Shared(self.process.clone()), self.task(), self.sensors())))
    }

    fn copies(&self) -> usize {
        1
    }

    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        self.file.files()
    }
}

/// The one program, for whoever acts on it.
struct Shared(Arc<Mutex<Process>>);

impl Shared {
    fn reached(&self, request: &Request<'_>) -> Result<Vec<f64>, PlantError> {
        let mut process = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(process.ask::<Reached>(request)?.state)
    }
}

impl Plant for Shared {
    fn reset(&mut self, start: &[f64]) -> Result<Vec<f64>, PlantError> {
        self.reached(&Request::Reset { start })
    }

    fn step(&mut self, u: &[f64]) -> Result<Vec<f64>, PlantError> {
        self.reached(&Request::Step { control: u })
    }
}
