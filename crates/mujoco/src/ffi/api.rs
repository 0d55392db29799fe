//! The functions of one loaded library.

#![allow(unsafe_code, reason = "a shared library is opened and its functions are given types")]

use std::error::Error as _;
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
    /// The system cannot load it.
    Load(String),
    /// It has no function of this name.
    Missing(&'static str),
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
        let library = unsafe { Library::new(file) }.map_err(|e| {
            // The reason is in the source alone.
            OpenError::Load(e.source().map_or_else(|| e.to_string(), ToString::to_string))
        })?;
        macro_rules! symbol {
            ($name:literal) => {
                *library.get(concat!($name, "\0").as_bytes()).map_err(|_| OpenError::Missing($name))?
            };
        }
        // SAFETY: the types here and in `Self` are those of MuJoCo's header, the same in all versions with a row but for
        // the sign of `sig`, which is passed alike. `get` makes no use of the type beyond copying an address.
        unsafe {
            let version: unsafe extern "C-unwind" fn() -> c_int = symbol!("mj_version");
            let number = version();
            let layout = layout::find(number).ok_or_else(|| OpenError::Unknown(layout::release(number)))?;
            guard::install(symbol!("mju_user_error"), symbol!("mju_user_warning"));
            Ok(Self {
                layout,
                load_xml: symbol!("mj_loadXML"),
                default_vfs: symbol!("mj_defaultVFS"),
                add_buffer_vfs: symbol!("mj_addBufferVFS"),
                delete_vfs: symbol!("mj_deleteVFS"),
                delete_model: symbol!("mj_deleteModel"),
                make_data: symbol!("mj_makeData"),
                delete_data: symbol!("mj_deleteData"),
                reset_data: symbol!("mj_resetData"),
                state_size: symbol!("mj_stateSize"),
                get_state: symbol!("mj_getState"),
                set_state: symbol!("mj_setState"),
                forward: symbol!("mj_forward"),
                step: symbol!("mj_step"),
                rne_post_constraint: symbol!("mj_rnePostConstraint"),
                _library: ManuallyDrop::new(library),
            })
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
