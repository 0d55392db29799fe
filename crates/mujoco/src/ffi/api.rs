//! The functions of one loaded library.

#![allow(unsafe_code, reason = "a shared library is opened and its functions are given types")]

use std::error::Error as _;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::ptr;

use libloading::Library;

use super::guard::{self, Raised, guarded};

/// `mjModel`, only ever behind a pointer.
pub(super) type RawModel = c_void;
/// `mjData`, only ever behind a pointer.
pub(super) type RawData = c_void;
/// The parts of a state, a bit for each: what `mj_getState` calls its signature.
pub(crate) type Signature = c_uint;

/// The major versions whose functions have been compared with the types here.
const MAJORS: [&str; 2] = ["3", "4"];

/// Why a file is not a MuJoCo we can use.
#[derive(Debug)]
pub(crate) enum OpenError {
    /// The system cannot load it.
    Load(String),
    /// It has no function of this name.
    Missing(&'static str),
    /// Its version may have other functions.
    Unknown(String),
}

/// MuJoCo's functions, by their names without the prefix.
pub(crate) struct Api {
    /// Version, such as `3.17.0`.
    pub(crate) version: String,
    pub(super) load_xml: unsafe extern "C-unwind" fn(*const c_char, *const c_void, *mut c_char, c_int) -> *mut RawModel,
    pub(super) delete_model: unsafe extern "C-unwind" fn(*mut RawModel),
    pub(super) make_data: unsafe extern "C-unwind" fn(*const RawModel) -> *mut RawData,
    pub(super) delete_data: unsafe extern "C-unwind" fn(*mut RawData),
    pub(super) reset_data: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    pub(super) state_size: unsafe extern "C-unwind" fn(*const RawModel, Signature) -> c_int,
    pub(super) get_state: unsafe extern "C-unwind" fn(*const RawModel, *const RawData, *mut f64, Signature),
    pub(super) set_state: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData, *const f64, Signature),
    pub(super) forward: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    pub(super) step: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    pub(super) rne_post_constraint: unsafe extern "C-unwind" fn(*const RawModel, *mut RawData),
    pub(super) print_formatted_model: unsafe extern "C-unwind" fn(*const RawModel, *const c_char, *const c_char),
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
        // SAFETY: the types here and in `Self` are those of MuJoCo's header, the same in all versions from 3.0.0 to 4.0.0
        // but for the sign of the signature, which is passed alike; other major versions are refused before anything
        // else is called. `get` makes no use of the type beyond copying an address. The version is a C string that
        // belongs to the library, or null.
        unsafe {
            let version: unsafe extern "C-unwind" fn() -> *const c_char = symbol!("mj_versionString");
            let version = guard::read(version());
            if !version.split('.').next().is_some_and(|major| MAJORS.contains(&major)) {
                return Err(OpenError::Unknown(version));
            }
            guard::install(symbol!("mju_user_error"), symbol!("mju_user_warning"));
            Ok(Self {
                version,
                load_xml: symbol!("mj_loadXML"),
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
                print_formatted_model: symbol!("mj_printFormattedModel"),
                _library: ManuallyDrop::new(library),
            })
        }
    }

    /// Compiles the model in `file`. The text is a warning, or without a model the reason.
    pub(super) fn load(&self, file: &CStr) -> Result<(*mut RawModel, String), Raised> {
        const ROOM: usize = 2000;
        let mut text = [0 as c_char; ROOM];
        // SAFETY: the file's name is a C string, no virtual file system is allowed, and MuJoCo ends what it writes into
        // `text` within the length it is told.
        let model =
            guarded(|| unsafe { (self.load_xml)(file.as_ptr(), ptr::null(), text.as_mut_ptr(), ROOM as c_int) })?;
        text[ROOM - 1] = 0;
        // SAFETY: the last element is 0 in any case.
        let text = guard::tidy(unsafe { CStr::from_ptr(text.as_ptr()) });
        Ok((model, text))
    }
}
