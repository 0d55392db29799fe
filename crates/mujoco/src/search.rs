//! Where MuJoCo may be.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::OsString;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

/// Prints the folders that may hold the library, without importing the package: its own, and those of the two wheels it
/// has been split into since 4.0, should they be installed apart. A folder `mujoco` where we stand is not the package.
const ASK_PYTHON: &str = r#"
import sys
sys.path = [p for p in sys.path if p]
from importlib import metadata, util
spec = util.find_spec("mujoco")
found = list(spec.submodule_search_locations or []) if spec else []
for wheel in ("mujoco-core", "mujoco"):
    try:
        found.append(str(metadata.distribution(wheel).locate_file("mujoco")))
    except metadata.PackageNotFoundError:
        pass
print("\n".join(dict.fromkeys(found)))
"#;

/// How long an interpreter may take to answer, and how much it may print \[byte\]: what is called `python3` may be anything.
const LONGEST_WAIT: Duration = Duration::from_secs(5);
const LONGEST_ANSWER: u64 = 64 << 10;
const SILENT: &str = "it did not answer in time";

/// A place that may hold MuJoCo's shared library.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// The library itself.
    File(PathBuf),
    /// A folder with the library in it.
    Folder(PathBuf),
    /// A Python virtual environment with the package `mujoco`.
    VirtualEnvironment(PathBuf),
    /// The virtual environments called `.venv` in a folder and in all folders around it, from the inside out.
    VenvsAbove(PathBuf),
    /// The package `mujoco` of a Python interpreter, which is run once and asked.
    Interpreter(PathBuf),
    /// Wherever the system looks for shared libraries.
    SystemLoader,
}

/// An ordered list of places to look for MuJoCo in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Search {
    places: Vec<Place>,
}

impl Search {
    /// Looks in `places`, in this order.
    #[must_use]
    pub fn new(places: Vec<Place>) -> Self {
        Self { places }
    }

    /// Looks where this process's environment says. The only function of the crate that reads it.
    ///
    /// `MUJOCO_LIB` (a file; nothing else is tried then), `MUJOCO_DIR/lib`, `VIRTUAL_ENV`, a `.venv` in the current
    /// folder or around it, the package of the `python3` on the path, the system's loader.
    #[must_use]
    pub fn from_environment() -> Self {
        Self::from_variables(|name| std::env::var_os(name), std::env::current_dir().ok())
    }

    /// [`Self::from_environment`] for given variables and a given current folder.
    fn from_variables(variable: impl Fn(&str) -> Option<OsString>, here: Option<PathBuf>) -> Self {
        let set = |name| variable(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        if let Some(file) = set("MUJOCO_LIB") {
            return Self::new(vec![Place::File(file)]);
        }
        let mut places = Vec::new();
        if let Some(folder) = set("MUJOCO_DIR") {
            // MuJoCo's archives for Windows hold the library in `bin`.
            places.push(Place::Folder(folder.join(if cfg!(windows) { "bin" } else { "lib" })));
        }
        places.extend(set("VIRTUAL_ENV").map(Place::VirtualEnvironment));
        places.extend(here.map(Place::VenvsAbove));
        places.push(Place::Interpreter(PathBuf::from(if cfg!(windows) { "python" } else { "python3" })));
        places.push(Place::SystemLoader);
        Self::new(places)
    }

    /// The places, in order.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.places
    }
}

impl Place {
    /// Name of the place and the libraries in it, or why there are none.
    pub(crate) fn libraries(&self) -> Vec<(String, Result<Vec<PathBuf>, String>)> {
        match self {
            Self::File(file) => {
                let found = if file.is_file() { Ok(vec![file.clone()]) } else { Err("no such file".into()) };
                vec![(file.display().to_string(), found)]
            }
            Self::Folder(folder) => vec![in_folder(folder)],
            Self::VirtualEnvironment(venv) => vec![in_venv(venv)],
            Self::VenvsAbove(folder) => {
                let found: Vec<_> =
                    folder.ancestors().map(|f| f.join(".venv")).filter(|f| f.is_dir()).map(|f| in_venv(&f)).collect();
                if found.is_empty() {
                    let place = format!(".venv in {} and around it", folder.display());
                    return vec![(place, Err("no such folder".into()))];
                }
                found
            }
            Self::Interpreter(python) => match ask(python, LONGEST_WAIT) {
                Ok(folders) => folders.iter().map(|folder| in_folder(folder)).collect(),
                Err(reason) => vec![(format!("package `mujoco` of {}", python.display()), Err(reason))],
            },
            Self::SystemLoader => {
                let name = format!("{DLL_PREFIX}mujoco{DLL_SUFFIX}");
                vec![("the system's loader".into(), Ok(vec![PathBuf::from(name)]))]
            }
        }
    }
}

fn in_folder(folder: &Path) -> (String, Result<Vec<PathBuf>, String>) {
    (folder.display().to_string(), files(folder))
}

/// MuJoCo's libraries in `folder`, the one with the highest version first.
fn files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| e.to_string())?;
    let mut found: Vec<_> =
        entries.flatten().filter(|e| is_library(&e.file_name().to_string_lossy())).map(|e| e.path()).collect();
    found.sort_by_key(|path| std::cmp::Reverse(numbers(path)));
    if found.is_empty() { Err(format!("no {DLL_PREFIX}mujoco{DLL_SUFFIX} in it")) } else { Ok(found) }
}

/// `libmujoco.so`, `libmujoco.so.3.17.0`, `libmujoco.3.17.0.dylib`, `mujoco.dll`.
fn is_library(name: &str) -> bool {
    name == "mujoco.dll"
        || name.strip_prefix("libmujoco.").is_some_and(|rest| {
            let version = |v: &str| v.split('.').all(|part| part.parse::<u32>().is_ok());
            rest == "so"
                || rest == "dylib"
                || rest.strip_prefix("so.").is_some_and(version)
                || rest.strip_suffix(".dylib").is_some_and(version)
        })
}

fn numbers(path: &Path) -> Vec<u32> {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    name.split('.').filter_map(|part| part.parse().ok()).collect()
}

/// `lib/python3.*/site-packages/mujoco` of a virtual environment, `Lib/site-packages/mujoco` on Windows.
fn in_venv(venv: &Path) -> (String, Result<Vec<PathBuf>, String>) {
    let mut packages: Vec<PathBuf> = std::fs::read_dir(venv.join("lib"))
        .into_iter()
        .flat_map(|entries| entries.flatten().map(|e| e.path().join("site-packages")))
        .chain([venv.join("Lib").join("site-packages")])
        .map(|site| site.join("mujoco"))
        .filter(|package| package.is_dir())
        .collect();
    packages.sort();
    let place = format!("virtual environment {}", venv.display());
    if packages.is_empty() {
        let reason = if venv.is_dir() { "no package `mujoco` in it" } else { "no such folder" };
        return (place, Err(reason.into()));
    }
    let (found, refused): (Vec<_>, Vec<_>) = packages.iter().map(|p| files(p)).partition(Result::is_ok);
    let found: Vec<_> = found.into_iter().flatten().flatten().collect();
    let refused = refused.into_iter().find_map(Result::err);
    (place, refused.filter(|_| found.is_empty()).map_or(Ok(found), Err))
}

/// The folders `python` names, if it answers within `limit`.
fn ask(python: &Path, limit: Duration) -> Result<Vec<PathBuf>, String> {
    let until = Instant::now() + limit;
    let mut child = Command::new(python)
        .args(["-X", "utf8", "-c", ASK_PYTHON])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|e| format!("it cannot be run: {e}"))?;
    let answer = answer(&mut child, until);
    let status = ended(&mut child, until);
    if status.is_none() {
        let _ = child.kill();
        let _ = child.wait();
    }
    let folders: Vec<_> =
        String::from_utf8_lossy(&answer?).lines().filter(|l| !l.is_empty()).map(PathBuf::from).collect();
    match (folders.is_empty(), status) {
        (false, _) => Ok(folders),
        (true, None) => Err(SILENT.into()),
        (true, Some(status)) if status.success() => Err("not installed".into()),
        (true, Some(status)) => Err(format!("it could not be asked ({status})")),
    }
}

/// What `child` prints until it closes its output.
fn answer(child: &mut Child, until: Instant) -> Result<Vec<u8>, String> {
    let output = child.stdout.take().ok_or(SILENT)?;
    let (sender, receiver) = mpsc::channel();
    // The thread outlives the answer only where a program that `child` started keeps the output open.
    let reader = move || {
        let mut bytes = Vec::new();
        let read = output.take(LONGEST_ANSWER + 1).read_to_end(&mut bytes);
        let _ = sender.send(read.map(|_| bytes));
    };
    thread::Builder::new().spawn(reader).map_err(|e| format!("no thread to read its answer: {e}"))?;
    match receiver.recv_timeout(until.saturating_duration_since(Instant::now())) {
        Ok(Ok(bytes)) if bytes.len() as u64 > LONGEST_ANSWER => {
            let _ = child.kill();
            Err(format!("it printed more than {LONGEST_ANSWER} bytes"))
        }
        Ok(read) => read.map_err(|e| format!("its answer cannot be read: {e}")),
        Err(_) => Err(SILENT.into()),
    }
}

/// How `child` ended, if it does until then.
fn ended(child: &mut Child, until: Instant) -> Option<ExitStatus> {
    loop {
        if let Some(status) = child.try_wait().ok()? {
            return Some(status);
        }
        if Instant::now() >= until {
            return None;
        }
        thread::sleep(Duration::from_millis(2));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(variables: &[(&str, &str)]) -> Vec<Place> {
        let variable = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| OsString::from(v));
        Search::from_variables(variable, Some("/home/me/project".into())).places
    }

    #[test]
    fn the_environment_is_searched_from_the_explicit_to_the_general() {
        let always =
            [Place::VenvsAbove("/home/me/project".into()), Place::Interpreter("python3".into()), Place::SystemLoader];
        if cfg!(not(windows)) {
            assert_eq!(search(&[]), always);
            assert_eq!(search(&[("VIRTUAL_ENV", ""), ("MUJOCO_LIB", "")]), always);
            let set = search(&[("VIRTUAL_ENV", "/venv"), ("MUJOCO_DIR", "/opt/mujoco")]);
            assert_eq!(set[..2], [Place::Folder("/opt/mujoco/lib".into()), Place::VirtualEnvironment("/venv".into())]);
            assert_eq!(set[2..], always);
        }
        let file = search(&[("VIRTUAL_ENV", "/venv"), ("MUJOCO_LIB", "/a/libmujoco.so")]);
        assert_eq!(file, [Place::File("/a/libmujoco.so".into())]);
    }

    #[test]
    fn libraries_are_told_from_what_lies_beside_them() {
        for name in ["libmujoco.so", "libmujoco.so.3.17.0", "libmujoco.dylib", "libmujoco.3.17.0.dylib", "mujoco.dll"] {
            assert!(is_library(name), "{name}");
        }
        for name in ["libmujoco.so.3.17.0.txt", "libmujoco_plugin.so", "libmujoco.a", "libmujoco", "mujoco.lib"] {
            assert!(!is_library(name), "{name}");
        }
    }

    #[test]
    fn the_highest_version_of_a_folder_is_tried_first() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["libmujoco.so.3.3.7", "libmujoco.so.3.17.0", "readme.txt"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let found = files(folder.path()).unwrap();
        assert_eq!(found, ["libmujoco.so.3.17.0", "libmujoco.so.3.3.7"].map(|name| folder.path().join(name)));
    }

    #[test]
    fn virtual_environments_around_a_folder_are_found() {
        let root = tempfile::tempdir().unwrap();
        let package = root.path().join(".venv/lib/python3.99/site-packages/mujoco");
        let inside = root.path().join("a/b");
        std::fs::create_dir_all(&package).unwrap();
        std::fs::create_dir_all(&inside).unwrap();
        std::fs::write(package.join("libmujoco.so.3.17.0"), "").unwrap();
        let found = Place::VenvsAbove(inside).libraries();
        assert_eq!(found[0].1, Ok(vec![package.join("libmujoco.so.3.17.0")]));
    }

    #[cfg(unix)]
    #[test]
    fn an_interpreter_that_does_not_end_or_does_not_stop_printing_is_not_waited_for() {
        use std::os::unix::fs::PermissionsExt as _;

        let folder = tempfile::tempdir().unwrap();
        let limit = Duration::from_millis(500);
        let long = format!("no more than {}", "x".repeat(64));
        for (script, expected) in [
            ("echo /a/mujoco; echo; echo /b", Ok(vec![PathBuf::from("/a/mujoco"), PathBuf::from("/b")])),
            ("echo /a/mujoco; exec >&-; exec sleep 60", Ok(vec![PathBuf::from("/a/mujoco")])),
            ("exit 0", Err("not installed")),
            ("exit 3", Err("it could not be asked (exit status: 3)")),
            ("exec sleep 60", Err(SILENT)),
            ("exec >&-; exec sleep 60", Err(SILENT)),
            (&format!("while :; do echo {long}; done"), Err("it printed more than 65536 bytes")),
        ] {
            let python = folder.path().join("python");
            std::fs::write(&python, format!("#!/bin/sh\n{script}\n")).unwrap();
            std::fs::set_permissions(&python, std::fs::Permissions::from_mode(0o755)).unwrap();
            let begun = Instant::now();
            assert_eq!(ask(&python, limit), expected.map_err(String::from), "{script}");
            assert!(begun.elapsed() < Duration::from_secs(30), "{script} was waited for");
        }
    }
}
