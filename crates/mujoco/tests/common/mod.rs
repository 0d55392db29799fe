//! Finds MuJoCo and Python for the tests: in `.venv` at the root of the repository, which `scripts/mujoco_install`
//! makes, or in the virtual environment `SINDYNA_MUJOCO_VENV`.
//!
//! Where that variable is not set and there is no MuJoCo in `.venv`, tests that need it pass and say that they were not run.

#![allow(dead_code, reason = "no test uses all of it")]

use std::io::Write as _;
use std::panic::Location;
use std::path::{Path, PathBuf};
use std::process::Command;

use sindyna_core::{Channel, Kind, Precision, Rng, Sensors, Space, Spec, Task};
use sindyna_mujoco::{Attempt, Library, MujocoEnvironment, MujocoError, MujocoModel, Place, Search};

/// Names a virtual environment, in which MuJoCo must then be.
pub(crate) const VENV: &str = "SINDYNA_MUJOCO_VENV";

pub(crate) fn venv() -> PathBuf {
    let venv = std::env::var_os(VENV);
    let venv = venv.map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.venv"), PathBuf::from);
    std::path::absolute(&venv).unwrap_or(venv)
}

pub(crate) fn search() -> Search {
    Search::new(vec![Place::VirtualEnvironment(venv())])
}

/// MuJoCo, or `None` after a line on stderr that names the test, which the harness does not hold back.
#[track_caller]
pub(crate) fn library() -> Option<Library> {
    match Library::load(&search()) {
        Ok(library) => Some(library),
        Err(MujocoError::NotFound { tried }) if std::env::var_os(VENV).is_none() && tried.iter().all(absent) => {
            let thread = std::thread::current();
            // With one thread for all tests, it has not the test's name.
            let test = thread.name().filter(|name| *name != "main").map(str::to_owned);
            let test = test.unwrap_or_else(|| Location::caller().to_string());
            let line = format!("not run, as there is no MuJoCo (scripts/mujoco_install): {test}\n");
            std::io::stderr().write_all(line.as_bytes()).expect("stderr takes a line");
            None
        }
        Err(e) => panic!("{e}\n\nscripts/mujoco_install installs a MuJoCo for the tests"),
    }
}

/// Whether there is nothing, rather than something that does not work.
fn absent(attempt: &Attempt) -> bool {
    ["no such folder", "no package `mujoco` in it"].contains(&attempt.reason.as_str())
}

/// What `tests/python/<script>` prints, line by line.
pub(crate) fn python(script: &str, arguments: &[&str]) -> Vec<String> {
    let python = venv().join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python").join(script);
    // Python's MuJoCo writes its warnings to a file in the current folder.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = Command::new(&python).arg(&script).args(arguments).current_dir(&folder).output();
    let output = output.unwrap_or_else(|e| panic!("{}: {e}\n\nrun scripts/mujoco_install", python.display()));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{} failed:\n{errors}", script.display());
    String::from_utf8(output.stdout).expect("scripts print ASCII").lines().map(str::to_string).collect()
}

/// The float64 values of a line of hexadecimal words.
pub(crate) fn floats(line: &str) -> Vec<f64> {
    let float = |word| f64::from_bits(u64::from_str_radix(word, 16).unwrap_or_else(|e| panic!("{word}: {e}")));
    line.split_whitespace().map(float).collect()
}

pub(crate) fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// A task on any model: starts in `start`, pays nothing, never ends by itself.
pub(crate) struct Anything {
    spec: Spec,
    pub(crate) start: Vec<f64>,
}

impl Anything {
    pub(crate) fn on(model: &MujocoModel, frame_skip: usize) -> Self {
        let channel = |letter: &str, i| Channel::new(&format!("{letter}{i}"), "", Kind::Plain, 1.0);
        let state: Vec<_> = (0..model.state_dim()).map(|i| channel("x", i)).collect();
        let k = model.control_dim();
        let spec = Spec {
            name: "anything".into(),
            state: state.clone(),
            observation: state,
            control: (0..k).map(|i| channel("u", i).within(-1e3, 1e3)).collect(),
            action_space: Space::Box { low: vec![-1e3; k], high: vec![1e3; k] },
            precision: Precision::F64,
            noise: 0.0,
            dt: model.timestep() * frame_skip as f64,
        };
        Self { spec, start: model.rest().to_vec() }
    }
}

impl Task for Anything {
    fn spec(&self) -> &Spec {
        &self.spec
    }
    fn max_steps(&self) -> usize {
        usize::MAX
    }
    fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
        x.copy_from_slice(&self.start);
    }
    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
        0.0
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

/// `model` with nothing to be done on it.
pub(crate) fn environment(model: &MujocoModel, frame_skip: usize) -> MujocoEnvironment<Anything> {
    environment_of(model, frame_skip, Anything::on(model, frame_skip))
}

pub(crate) fn environment_of(model: &MujocoModel, frame_skip: usize, task: Anything) -> MujocoEnvironment<Anything> {
    let sensors = Sensors::new(task.spec()).expect("every observation is a state");
    MujocoEnvironment::new(model, frame_skip, task, sensors).expect("the task was made for the model")
}
