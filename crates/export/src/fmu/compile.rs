//! The C of an FMU as a library for this machine.

use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::fs;
use std::process::Command;

/// A library, and its place in an FMU.
pub(super) struct Library {
    pub(super) path: String,
    pub(super) bytes: Vec<u8>,
}

/// `source` compiled by `cc`, or why there is none.
pub(super) fn compiled(source: &str, identifier: &str) -> Result<Library, String> {
    // FMI 2.0 has names for these alone.
    let platform = match (OS, ARCH) {
        ("linux", "x86_64") => "linux64",
        ("linux", "x86") => "linux32",
        ("macos", _) => "darwin64",
        ("windows", "x86_64") => "win64",
        ("windows", "x86") => "win32",
        _ => return Err(format!("FMI 2.0 has no name for {OS} on {ARCH}")),
    };
    let failed = |e: std::io::Error| format!("cc could not be run: {e}");
    let directory = tempfile::tempdir().map_err(failed)?;
    let library = format!("{identifier}{DLL_SUFFIX}");
    fs::write(directory.path().join("model.c"), source).map_err(failed)?;
    let output = Command::new("cc")
        .current_dir(directory.path())
        .args(["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "model.c", "-o", &library, "-lm"])
        .output()
        .map_err(
            |e| if e.kind() == std::io::ErrorKind::NotFound { "cc was not found".to_owned() } else { failed(e) },
        )?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("cc failed: {}", said.lines().next().unwrap_or_default()));
    }
    let bytes = fs::read(directory.path().join(&library)).map_err(failed)?;
    Ok(Library { path: format!("binaries/{platform}/{library}"), bytes })
}
