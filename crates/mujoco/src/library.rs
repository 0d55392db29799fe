//! A MuJoCo that was found, loaded and checked.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::elf;
use crate::error::{Attempt, MujocoError};
use crate::ffi::{Api, OpenError};
use crate::probe::Conventions;
use crate::search::Search;

/// MuJoCo's shared library. Clones share it; it stays loaded until the process ends.
#[derive(Clone)]
pub struct Library {
    file: PathBuf,
    api: Arc<Api>,
    conventions: Arc<Conventions>,
}

impl Library {
    /// The first usable library among the places of `search`.
    ///
    /// A library is usable if it is a MuJoCo 3 or 4 and does to a small model what is expected; how that is
    /// found out, and why, stands in the module `probe`.
    ///
    /// # Errors
    /// [`MujocoError::NotFound`] with every place that was looked at and why it would not do.
    pub fn load(search: &Search) -> Result<Self, MujocoError> {
        let mut tried = Vec::new();
        for place in search.places() {
            for (place, found) in place.libraries() {
                let files = match found {
                    Ok(files) => files,
                    Err(reason) => {
                        tried.push(Attempt { place, reason });
                        continue;
                    }
                };
                for file in files {
                    match Self::open(&file) {
                        Ok(library) => return Ok(library),
                        Err(reason) => tried.push(Attempt { place: file.display().to_string(), reason }),
                    }
                }
            }
        }
        Err(MujocoError::NotFound { tried })
    }

    fn open(file: &Path) -> Result<Self, String> {
        if let Some((needed, len)) = elf::cut_short(file) {
            return Err(format!("it is cut short: {len} bytes of {needed} or more"));
        }
        let api = Api::open(file).map_err(|e| match e {
            OpenError::Load(reason) => reason,
            OpenError::Missing(name) => format!("this is no MuJoCo: it has no function `{name}`"),
            OpenError::Unknown(version) => format!("this is MuJoCo {version}; the versions supported are 3.x and 4.x"),
        })?;
        let api = Arc::new(api);
        let conventions =
            Conventions::of(&api).map_err(|e| format!("MuJoCo {} does not behave as expected: {e}", api.version))?;
        Ok(Self { file: file.into(), api, conventions: Arc::new(conventions) })
    }

    /// Version, such as `3.17.0`.
    #[must_use]
    pub fn version(&self) -> &str {
        &self.api.version
    }

    /// The file it was loaded from; a bare name if the system's loader found it.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    pub(crate) fn conventions(&self) -> &Arc<Conventions> {
        &self.conventions
    }

    pub(crate) fn api(&self) -> &Arc<Api> {
        &self.api
    }
}

impl fmt::Debug for Library {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Library").field("version", &self.version()).field("file", &self.file).finish()
    }
}
