//! A model of bodies, joints and motors.

use std::ffi::CString;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use crate::error::MujocoError;
use crate::ffi::{DataHandle, LoadError, ModelHandle, Part};
use crate::library::Library;

/// A compiled MJCF model. Clones share it, on any number of threads.
#[derive(Clone)]
pub struct MujocoModel {
    handle: Arc<ModelHandle>,
    rest: Arc<[f64]>,
}

impl MujocoModel {
    /// Compiles the MJCF file at `path`.
    ///
    /// # Errors
    /// [`MujocoError::Model`] with MuJoCo's own message.
    pub fn from_file(library: &Library, path: impl AsRef<Path>) -> Result<Self, MujocoError> {
        let path = path.as_ref();
        let origin = path.display().to_string();
        let refused = |message: String| MujocoError::Model { origin: origin.clone(), message };
        let text = path.to_str().ok_or_else(|| refused("the path is not UTF-8".into()))?;
        let file = CString::new(text).map_err(|e| refused(e.to_string()))?;
        Self::new(ModelHandle::from_file(library.api(), &file)).map_err(|LoadError(message)| refused(message))
    }

    /// Compiles the MJCF text `xml`; files it names are looked for in the current folder.
    ///
    /// # Errors
    /// [`MujocoError::Model`] with MuJoCo's own message.
    pub fn from_xml(library: &Library, xml: &str) -> Result<Self, MujocoError> {
        Self::new(ModelHandle::from_xml(library.api(), xml))
            .map_err(|LoadError(message)| MujocoError::Model { origin: "the model's text".into(), message })
    }

    fn new(loaded: Result<ModelHandle, LoadError>) -> Result<Self, LoadError> {
        let handle = Arc::new(loaded?);
        let data = DataHandle::new(&handle)?;
        let mut rest = vec![0.0; data.len(Part::State)];
        data.get(Part::State, &mut rest)?;
        Ok(Self { handle, rest: rest.into() })
    }

    /// Number of positions nq; a ball or free joint has one more than it has velocities.
    #[must_use]
    pub fn position_dim(&self) -> usize {
        self.handle.sizes()[0]
    }

    /// Number of velocities nv.
    #[must_use]
    pub fn velocity_dim(&self) -> usize {
        self.handle.sizes()[1]
    }

    /// Number of states n = nq + nv.
    #[must_use]
    pub fn state_dim(&self) -> usize {
        self.position_dim() + self.velocity_dim()
    }

    /// Number of controls k.
    #[must_use]
    pub fn control_dim(&self) -> usize {
        self.handle.sizes()[2]
    }

    /// Step of the simulation \[s\].
    #[must_use]
    pub fn timestep(&self) -> f64 {
        self.handle.timestep()
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
