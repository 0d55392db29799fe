//! The binary as a user runs it.

#![allow(dead_code, reason = "no test file needs all of it")]

pub(crate) mod programs;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The `sindyna` command with `args`, run in `directory`.
pub(crate) fn command(directory: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sindyna"));
    command.current_dir(directory).args(args);
    command
}

/// Runs `sindyna` with `args` in `directory`.
pub(crate) fn sindyna(directory: &Path, args: &[&str]) -> Output {
    command(directory, args).output().expect("the binary was built")
}

/// Exit code, stdout and stderr.
pub(crate) fn parts(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().expect("it was not killed"), text(&output.stdout), text(&output.stderr))
}

/// A JSON file.
pub(crate) fn json(path: &Path) -> Value {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).expect("a record is valid JSON")
}

/// The log in the repository.
pub(crate) fn example() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/logs/pendulum.csv");
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Runs `identify log.csv` on `log` with `args`; exit code, stdout, stderr.
pub(crate) fn identify(directory: &Path, log: &str, args: &[&str]) -> (i32, String, String) {
    fs::write(directory.join("log.csv"), log).unwrap();
    parts(&sindyna(directory, &[&["identify", "log.csv"], args].concat()))
}

/// What the columns of [`example`] are.
pub(crate) const COLUMNS: [&str; 4] = ["--states", "th,w", "--inputs", "u"];

/// What `script` prints, run in `directory` by the Python of `.venv`, which `scripts/mujoco_install` makes.
pub(crate) fn python(directory: &Path, script: &str) -> String {
    let venv = std::env::var_os("SINDYNA_MUJOCO_VENV");
    let venv = venv.map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.venv"), PathBuf::from);
    let interpreter =
        std::path::absolute(venv).unwrap().join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let output = Command::new(&interpreter).current_dir(directory).args(["-X", "utf8", "-c", script]).output();
    let output = output.unwrap_or_else(|e| panic!("{}: {e}\n\nrun scripts/mujoco_install", interpreter.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}
