//! A model of bodies, joints and motors.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use crate::compile::{compile, compile_text};
use crate::error::MujocoError;
use crate::ffi::{DataHandle, LoadError, ModelHandle, Raised, take_warnings};
use crate::library::Library;
use crate::probe::Conventions;

/// A compiled MJCF model. Clones share it, on any number of threads.
#[derive(Clone)]
pub struct MujocoModel {
    handle: Arc<ModelHandle>,
    conventions: Arc<Conventions>,
    /// Lengths of qpos, qvel and ctrl.
    sizes: [usize; 3],
    timestep: f64,
    rest: Arc<[f64]>,
}

impl MujocoModel {
    /// Compiles the MJCF file at `path`.
    ///
    /// # Errors
    /// [`MujocoError::Model`] with MuJoCo's own message.
    pub fn from_file(library: &Library, path: impl AsRef<Path>) -> Result<Self, MujocoError> {
        let path = path.as_ref();
        Self::new(library, compile(library.api(), path))
            .map_err(|LoadError(message)| MujocoError::Model { origin: path.display().to_string(), message })
    }

    /// Compiles the MJCF text `xml`, which names no other files but by full paths.
    ///
    /// # Errors
    /// [`MujocoError::Model`] with MuJoCo's own message, or where no temporary file can be written.
    pub fn from_xml(library: &Library, xml: &str) -> Result<Self, MujocoError> {
        Self::new(library, compile_text(library.api(), xml))
            .map_err(|LoadError(message)| MujocoError::Model { origin: "the model's text".into(), message })
    }

    fn new(library: &Library, compiled: Result<ModelHandle, LoadError>) -> Result<Self, LoadError> {
        let (handle, conventions) = (Arc::new(compiled?), Arc::clone(library.conventions()));
        let mut sizes = [0; 3];
        for (size, part) in sizes.iter_mut().zip([conventions.positions, conventions.velocities, conventions.controls])
        {
            *size = handle.state_size(part)?;
        }
        let mut data = DataHandle::new(&handle)?;
        let mut rest = vec![0.0; sizes[0] + sizes[1]];
        data.get(conventions.state(), &mut rest)?;
        // The time is 0, and 0 + h = h without rounding, even where the step diverges and MuJoCo begins anew.
        let mut time = [f64::NAN];
        let stepped = data.step();
        take_warnings();
        stepped.map_err(|Raised(message)| LoadError(format!("its first step fails: {message}")))?;
        data.get(conventions.time, &mut time)?;
        let [timestep] = time;
        if !(timestep.is_finite() && timestep > 0.0) {
            return Err(LoadError(format!("a step takes {timestep} s")));
        }
        Ok(Self { handle, conventions, sizes, timestep, rest: rest.into() })
    }

    /// Number of positions nq; a ball or free joint has one more than it has velocities.
    #[must_use]
    pub fn position_dim(&self) -> usize {
        self.sizes[0]
    }

    /// Number of velocities nv.
    #[must_use]
    pub fn velocity_dim(&self) -> usize {
        self.sizes[1]
    }

    /// Number of states n = nq + nv.
    #[must_use]
    pub fn state_dim(&self) -> usize {
        self.position_dim() + self.velocity_dim()
    }

    /// Number of controls k.
    #[must_use]
    pub fn control_dim(&self) -> usize {
        self.sizes[2]
    }

    /// Step of the simulation \[s\].
    #[must_use]
    pub fn timestep(&self) -> f64 {
        self.timestep
    }

    /// The state (n) the model is drawn in, at rest: what MuJoCo resets a simulation to.
    #[must_use]
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// What MuJoCo warned of while it compiled the model.
    #[must_use]
    pub fn warning(&self) -> Option<&str> {
        self.handle.warning()
    }

    pub(crate) fn conventions(&self) -> &Arc<Conventions> {
        &self.conventions
    }

    pub(crate) fn handle(&self) -> &Arc<ModelHandle> {
        &self.handle
    }
}

impl fmt::Debug for MujocoModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MujocoModel")
            .field("position_dim", &self.position_dim())
            .field("velocity_dim", &self.velocity_dim())
            .field("control_dim", &self.control_dim())
            .field("timestep", &self.timestep())
            .finish_non_exhaustive()
    }
}
