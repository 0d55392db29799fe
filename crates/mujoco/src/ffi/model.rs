//! A compiled model.

#![allow(unsafe_code, reason = "owns MuJoCo's mjModel")]

use std::ffi::{CStr, c_int};
use std::ptr::{self, NonNull};
use std::sync::Arc;

use super::api::{Api, RawModel, RawVfs};
use super::guard::{Raised, guarded, take_warning};
use crate::layout::Field;

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
    /// Lengths of qpos, qvel and ctrl.
    sizes: [usize; 3],
    timestep: f64,
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
        take_warning();
        // SAFETY: null is allowed.
        let loaded = unsafe { api.load(file, ptr::null()) }?;
        Self::own(api, loaded)
    }

    /// Compiles the MJCF `xml`; other files it names are looked for in the current folder.
    pub(crate) fn from_xml(api: &Arc<Api>, xml: &str) -> Result<Self, LoadError> {
        const NAME: &CStr = c"model.xml";
        /// Far larger than the one pointer that mjVFS has been since 3.0.
        const ROOM: usize = 64;
        let mut vfs = [0_u64; ROOM];
        if api.layout.vfs_bytes > size_of_val(&vfs) {
            return Err(LoadError(format!("its file system takes {} bytes", api.layout.vfs_bytes)));
        }
        let Ok(len) = c_int::try_from(xml.len()) else {
            return Err(LoadError("the text is longer than 2 GiB".into()));
        };
        let vfs: *mut RawVfs = vfs.as_mut_ptr().cast();
        take_warning();
        // SAFETY: `vfs` has room for an mjVFS and is initialised before its other uses; MuJoCo copies the text, which
        // is `len` bytes long.
        unsafe {
            guarded(|| (api.default_vfs)(vfs))?;
            let added = guarded(|| (api.add_buffer_vfs)(vfs, NAME.as_ptr(), xml.as_ptr().cast(), len))?;
            let loaded = if added == 0 {
                api.load(NAME, vfs)
            } else {
                Err(Raised(format!("the text could not be handed over (code {added})")))
            };
            guarded(|| (api.delete_vfs)(vfs))?;
            Self::own(api, loaded?)
        }
    }

    /// Takes ownership of what [`Api::load`] returned.
    fn own(api: &Arc<Api>, (model, text): (*mut RawModel, String)) -> Result<Self, LoadError> {
        let warned = take_warning();
        let Some(model) = NonNull::new(model) else {
            return Err(LoadError(Some(text).filter(|t| !t.is_empty()).or(warned).unwrap_or("no reason given".into())));
        };
        let warning = Some(text).filter(|t| !t.is_empty()).or(warned);
        let mut handle = Self { model, sizes: [0; 3], timestep: f64::NAN, warning, api: Arc::clone(api) };
        let layout = &api.layout;
        let mut sizes = [0; 3];
        for (size, signature) in sizes.iter_mut().zip([layout.state_qpos, layout.state_qvel, layout.state_ctrl]) {
            *size = handle.state_size(signature)?;
        }
        handle.sizes = sizes;
        // SAFETY: the offset lies inside the struct; `SelfCheck` compares what is read there with what was compiled.
        handle.timestep = unsafe { handle.read(layout.timestep) };
        Ok(handle)
    }

    /// Number of values `mj_getState` writes for `signature`.
    fn state_size(&self, signature: u32) -> Result<usize, Raised> {
        // SAFETY: the model is alive.
        let size = guarded(|| unsafe { (self.api.state_size)(self.as_ptr(), signature) })?;
        usize::try_from(size).map_err(|_| Raised(format!("a state of {size} values")))
    }

    /// A copy of `field`.
    ///
    /// # Safety
    /// `field` must lie in `mjModel` and hold a `V`.
    unsafe fn read<V: Copy>(&self, field: Field) -> V {
        // SAFETY: as demanded of the caller.
        unsafe { self.as_ptr().byte_add(field.offset).cast::<V>().read_unaligned() }
    }

    /// The numbers of positions, velocities and controls as the struct holds them, for comparison with [`Self::sizes`].
    pub(crate) fn counts(&self) -> [i64; 3] {
        let layout = &self.api.layout;
        [layout.nq, layout.nv, layout.nu].map(|field| {
            // SAFETY: any bytes inside the struct are a valid integer.
            unsafe { if field.bytes == 8 { self.read::<i64>(field) } else { i64::from(self.read::<i32>(field)) } }
        })
    }

    /// Lengths of qpos, qvel and ctrl.
    pub(crate) fn sizes(&self) -> [usize; 3] {
        self.sizes
    }

    /// Step of the simulation \[s\].
    pub(crate) fn timestep(&self) -> f64 {
        self.timestep
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
