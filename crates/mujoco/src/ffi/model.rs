//! A compiled model.

#![allow(unsafe_code, reason = "owns MuJoCo's mjModel")]

use std::ffi::CStr;
use std::ptr::NonNull;
use std::sync::Arc;

use super::api::{Api, RawModel, Signature};
use super::guard::{Raised, guarded, take_warnings};

/// Why a model could not be compiled: MuJoCo's words, or ours where MuJoCo was not asked.
pub(crate) struct LoadError(pub(crate) String);

impl From<Raised> for LoadError {
    fn from(Raised(message): Raised) -> Self {
        Self(message)
    }
}

/// Owns an `mjModel`, which nothing changes after it is compiled.
pub(crate) struct ModelHandle {
    model: NonNull<RawModel>,
    warning: Option<String>,
    api: Arc<Api>,
}

// SAFETY: no function declared in `Api` writes to an mjModel but the one that deletes it, and that needs ownership.
unsafe impl Send for ModelHandle {}
// SAFETY: as above; MuJoCo documents that threads may share a model.
unsafe impl Sync for ModelHandle {}

impl ModelHandle {
    /// Compiles the MJCF in `file`.
    pub(crate) fn from_file(api: &Arc<Api>, file: &CStr) -> Result<Self, LoadError> {
        take_warnings();
        let (model, text) = api.load(file)?;
        let said = Some(text).filter(|t| !t.is_empty()).or(take_warnings().pop());
        let Some(model) = NonNull::new(model) else {
            return Err(LoadError(said.unwrap_or("no reason given".into())));
        };
        Ok(Self { model, warning: said, api: Arc::clone(api) })
    }

    /// Number of values in the parts of a state in `signature`.
    pub(crate) fn state_size(&self, signature: Signature) -> Result<usize, Raised> {
        guarded(|| self.size(signature))?
    }

    /// Refuses a number of values that `signature` has not; to be called within [`guarded`].
    pub(super) fn demand_len(&self, signature: Signature, len: usize) -> Result<(), Raised> {
        match self.size(signature)? {
            size if size == len => Ok(()),
            size => Err(Raised(format!("this part of a state has {size} values, got {len}"))),
        }
    }

    fn size(&self, signature: Signature) -> Result<usize, Raised> {
        // SAFETY: the model is alive.
        let size = unsafe { (self.api.state_size)(self.as_ptr(), signature) };
        usize::try_from(size).map_err(|_| Raised(format!("a state of {size} values")))
    }

    /// Writes all that it holds into `file`, with every digit.
    pub(crate) fn print(&self, file: &CStr) -> Result<(), Raised> {
        // SAFETY: the model is alive, and both texts are C strings.
        guarded(|| unsafe { (self.api.print_formatted_model)(self.as_ptr(), file.as_ptr(), c"%.17g".as_ptr()) })
    }

    /// What MuJoCo warned of while compiling.
    pub(crate) fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    pub(super) fn api(&self) -> &Api {
        &self.api
    }

    pub(super) fn as_ptr(&self) -> *mut RawModel {
        self.model.as_ptr()
    }
}

impl Drop for ModelHandle {
    fn drop(&mut self) {
        // SAFETY: owned, and every mjData made from it holds an `Arc` of this handle.
        let _ = guarded(|| unsafe { (self.api.delete_model)(self.as_ptr()) });
    }
}
