//! The functions of one loaded library.

#![allow(unsafe_code, reason = "a shared library is opened and its functions are given types")]

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::mem::ManuallyDrop;
use std::path::Path;

use libloading::Library;

use super::guard::{self, Raised, guarded};
use crate::layout::{self, Layout};

/// `mjModel`, only ever behind a pointer.
pub(super) type RawModel = c_void;
/// `mjData`, only ever behind a pointer.
pub(super) type RawData = c_void;
/// `mjVFS`, only ever behind a pointer.
pub(super) type RawVfs = c_void;

/// Why a file is not a MuJoCo we can use.
#[derive(Debug)]
pub(crate) enum OpenError {
    /// The system cannot load it, or a function is missing.
    Load(libloading::Error),
    /// There is no table of offsets for its version.
    Unknown(String),
}

/// MuJoCo's functions, by their names without the prefix.
pub(crate) struct Api {
    /// What the structs of this version look like.
    pub(crate) layout: Layout,
    pub(super) load_xml: unsafe extern "C-unwind" fn(*const c_char, *const RawVfs, *mut c_char, c_int) -> *mut RawModel,
    pub(super) default_vfs: unsafe extern "C-unwind" fn(*mut RawVfs),
    pub(super) add_buffer_vfs: unsafe extern "C-unwind" fn(*mut RawVfs, *const c_char, *const c_void, c_int) -> c_int,
    pub(super) delete_vfs: unsafe extern "C-unwind" fn(*mut RawVfs),
    pub(super) delete_model: unsafe extern "C-unwind" fn(*mut RawModel),
    pub(super) make_data: unsafe extern "C-unwind" fn(*const RawModel) -> *mut RawData,
    pub(super) delete_data: unsafe extern "C-unwind" fn(*mut RawData),
    pub(super) reset_data: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    pub(super) state_size: unsafe extern "C-unwind" fn(*const RawModel, c_uint) -> c_int,
    pub(super) get_state: unsafe extern "C-unwind" fn(*const RawModel, *const RawData, *mut f64, c_uint),
    pub(super) set_state: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData, *const f64, c_uint),
    pub(super) forward: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    pub(super) step: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    pub(super) rne_post_constraint: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    /// Never unloaded: MuJoCo keeps caches and thread-local values whose clean-up would be code that is gone.
    _library: ManuallyDrop<Library>,
}

impl Api {
    /// Opens `file`, a path or a name for the system's loader, and finds the functions in it.
    pub(crate) fn open(file: &Path) -> Result<Self, OpenError> {
        // SAFETY: loading runs the library's initialisers. The file was named by the user or by the folder of a package
        // called mujoco; there is no other way to tell that it is MuJoCo.
        let library = unsafe { Library::new(file) }.map_err(OpenError::Load)?;
        // SAFETY: the types here and in the macro are those of MuJoCo's header, the same in all versions with a row but
        // for the sign of `sig`, which is passed alike. `get` makes no use of the type beyond copying an address.
        unsafe {
            let version: unsafe extern "C-unwind" fn() -> c_int =
                *library.get(b"mj_version\0").map_err(OpenError::Load)?;
            let number = version();
            let layout = layout::find(number).ok_or_else(|| OpenError::Unknown(layout::release(number)))?;
            macro_rules! function {
                ($name:literal) => {
                    *library.get(concat!($name, "\0").as_bytes()).map_err(OpenError::Load)?
                };
            }
            let api = Self {
                layout,
                load_xml: function!("mj_loadXML"),
                default_vfs: function!("mj_defaultVFS"),
                add_buffer_vfs: function!("mj_addBufferVFS"),
                delete_vfs: function!("mj_deleteVFS"),
                delete_model: function!("mj_deleteModel"),
                make_data: function!("mj_makeData"),
                delete_data: function!("mj_deleteData"),
                reset_data: function!("mj_resetData"),
                state_size: function!("mj_stateSize"),
                get_state: function!("mj_getState"),
                set_state: function!("mj_setState"),
                forward: function!("mj_forward"),
                step: function!("mj_step"),
                rne_post_constraint: function!("mj_rnePostConstraint"),
                _library: ManuallyDrop::new(library),
            };
            let slot = |name: &[u8]| api._library.get::<*mut *mut ()>(name).map(|s| *s).map_err(OpenError::Load);
            guard::install(slot(b"mju_user_error\0")?, slot(b"mju_user_warning\0")?);
            Ok(api)
        }
    }

    /// Compiles the model in `file`, looked for in `vfs` first unless that is null. The text is a warning.
    ///
    /// # Safety
    /// `vfs` must be null or initialised by this library.
    pub(super) unsafe fn load(&self, file: &CStr, vfs: *const RawVfs) -> Result<(*mut RawModel, String), Raised> {
        const ROOM: usize = 2000;
        let mut text = [0 as c_char; ROOM];
        // SAFETY: both pointers are valid, and MuJoCo ends what it writes into `text` within its length.
        let model = guarded(|| unsafe { (self.load_xml)(file.as_ptr(), vfs, text.as_mut_ptr(), ROOM as c_int) })?;
        text[ROOM - 1] = 0;
        // SAFETY: the last element is 0 in any case.
        let text = guard::tidy(unsafe { CStr::from_ptr(text.as_ptr()) });
        Ok((model, text))
    }
}
