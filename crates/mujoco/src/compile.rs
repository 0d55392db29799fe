//! MJCF files and texts, compiled by a library.

use std::ffi::CString;
use std::path::Path;
use std::sync::Arc;

use crate::ffi::{Api, LoadError, ModelHandle};

/// Compiles the MJCF file at `path`.
pub(crate) fn compile(api: &Arc<Api>, path: &Path) -> Result<ModelHandle, LoadError> {
    let text = path.to_str().ok_or_else(|| LoadError("the path is not UTF-8".into()))?;
    let file = CString::new(text).map_err(|e| LoadError(e.to_string()))?;
    ModelHandle::from_file(api, &file)
}

/// Compiles the MJCF text `xml` from a file of its own, which lies in a folder alone: `mjVFS`, MuJoCo's files in memory, has
/// had several sizes, and the function that fills it is younger than 3.0.
pub(crate) fn compile_text(api: &Arc<Api>, xml: &str) -> Result<ModelHandle, LoadError> {
    let written = |e: std::io::Error| LoadError(format!("it cannot be written to a temporary file: {e}"));
    let folder = tempfile::tempdir().map_err(written)?;
    let file = folder.path().join("model.xml");
    std::fs::write(&file, xml).map_err(written)?;
    let here = format!("{}{}", folder.path().display(), std::path::MAIN_SEPARATOR);
    compile(api, &file).map_err(|LoadError(message)| LoadError(message.replace(&here, "")))
}
