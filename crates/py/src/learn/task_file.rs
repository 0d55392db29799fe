//! Tasks that a file describes: training, and what was learned stepped in batches.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use sindyna::core::{Bounded, Channel};
use sindyna::problem::{declared, of_file, of_log, of_model};
use sindyna::{Error, Problem, Trained, Training};
use sindyna_sindy::Watch;

use super::batch::Batch;
use super::outside::Raised;
use super::system::refused;
use super::training::{Outcome, told};
use crate::interrupt::apart;
use crate::model::Model;

/// Files of a task, by name: the task itself, and the model that it names.
type Files = Vec<(String, Vec<u8>)>;

/// Names of states, of inputs and of observed values.
type Names = (Vec<String>, Vec<String>, Vec<String>);

/// Name of a task among its files.
const TASK: &str = "task.toml";

/// Files of a problem that are not its task.
const DATA: [&str; 2] = ["data.csv", "posterior.bin"];

/// What came of training, and what its environments are made of again: files and the control interval.
struct Run {
    trained: Trained,
    files: Files,
    names: Names,
    dt: f64,
}

/// Trains a controller for the task in the file `path`: on its own simulator; in equations that are found in `logs` first; or in what `sindyna identify` left in `model`.
/// The outcome, the files of the task, the names of states, inputs and observed values, the control interval.
#[pyfunction]
#[pyo3(signature = (path, logs, model, seed, settings, max_real_steps=None))]
pub(crate) fn train_file(
    py: Python<'_>,
    path: PathBuf,
    logs: Vec<PathBuf>,
    model: Option<PathBuf>,
    seed: u64,
    settings: Vec<String>,
    max_real_steps: Option<usize>,
) -> PyResult<(Outcome, Files, Names, f64)> {
    let ran = apart(py, move |stop| -> Result<Option<Run>, Error> {
        let go_on = || !stop.is_set();
        let problem: Arc<dyn Problem> = match &model {
            Some(directory) => of_model(&path, directory)?,
            None if logs.is_empty() => of_file(&path)?,
            None => match of_log(&path, &logs, &settings, &Watch::going_on(&go_on)) {
                Err(_) if stop.is_set() => return Ok(None),
                problem => problem?,
            },
        };
        if problem.delay() > 0.0 || problem.lag() > 0.0 {
            let why = "its inputs act late, by a delay or a lag, and policies here do not predict: the commands `sindyna train` and `sindyna evaluate` do";
            return Err(Error::System { name: problem.spec().name.clone(), why: why.into() });
        }
        let mut training = Training::shared(problem.clone()).with_seed(seed);
        for setting in &settings {
            training = training.with(setting)?;
        }
        if let Some(steps) = max_real_steps {
            training = training.with_max_real_steps(steps);
        }
        let trained = training.run_watched(&mut |_| {}, stop.flag())?;
        let files = problem.files()?.into_iter().filter(|(name, _)| !DATA.contains(name));
        let spec = problem.spec();
        let names = |channels: &[Channel]| channels.iter().map(|channel| channel.name.clone()).collect();
        Ok(Some(Run {
            trained,
            files: files.map(|(name, bytes)| (name.to_owned(), bytes)).collect(),
            names: (names(&spec.state), names(&spec.control), names(&spec.observation)),
            dt: spec.dt,
        }))
    })?;
    let stopped = || PyKeyboardInterrupt::new_err("training was stopped");
    let Run { trained, files, names, dt } = ran.map_err(|e| refused(told(&e)))?.ok_or_else(stopped)?;
    if trained.summary.interrupted {
        return Err(stopped());
    }
    Ok((Outcome::new(trained), files, names, dt))
}

/// Copies of the system of the task in `files`, moving as learned equations tell, a step every `dt` \[s\].
#[pyfunction]
pub(crate) fn learned_file(files: Files, dt: f64, model: &Model, copies: usize) -> PyResult<Batch> {
    let folder = tempfile::tempdir().map_err(refused)?;
    for (name, bytes) in &files {
        // A file is what it is called, nothing beyond the folder.
        let plain = Path::new(name).file_name().ok_or_else(|| refused(format!("`{name}` is no name of a file")))?;
        std::fs::write(folder.path().join(plain), bytes).map_err(refused)?;
    }
    let problem = declared(&folder.path().join(TASK), dt).map_err(|e| refused(told(&e)))?;
    let dynamics = Arc::new(Bounded::new(model.inner().clone(), &problem.spec().state));
    Batch::new(dynamics, problem.task(), problem.sensors(), copies, Raised::default())
}
