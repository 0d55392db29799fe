//! What moves as a task file says: MuJoCo, equations, or nothing.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, ensure};
use sindyna_core::{Bounded, Dynamics, Held, Scheme};
use sindyna_mujoco::{Library, MujocoModel, Search, Tree};

use super::document::Document;
use super::equations::Equations;
use crate::problem::FormulaTask;

/// Name of a model in a run directory.
const RECORDED_MODEL: &str = "model.xml";

/// Runge–Kutta steps of fourth order in one control interval.
const SUBSTEPS: usize = 16;

/// Names and contents of files beside a task file.
type Files = Vec<(&'static str, Vec<u8>)>;

/// What moves.
#[derive(Clone)]
pub(super) enum Simulator {
    /// An MJCF model.
    Mujoco(Compiled),
    /// Equations: a ground-truth simulator.
    Equations { dynamics: Arc<dyn Dynamics>, lines: Vec<String> },
    /// Nothing: data come from a log.
    None,
}

/// An MJCF model, compiled, and what it was read from.
#[derive(Clone)]
pub(super) struct Compiled {
    pub(super) library: Library,
    pub(super) model: MujocoModel,
    pub(super) frame_skip: usize,
    /// Where in the text of the task file the model is named, quotes included.
    name: Range<usize>,
    path: PathBuf,
    text: Vec<u8>,
}

impl Simulator {
    /// The simulator of the task file `document`, which lies at `path`, and its task; `dt` \[s\] is the control interval where the file tells none.
    /// The document comes back with what the simulator tells of it.
    pub(super) fn of(
        document: Document,
        path: &Path,
        dt: Option<f64>,
    ) -> anyhow::Result<(Self, FormulaTask, Document)> {
        if let (Some(model), Some(frame_skip)) = (&document.model, document.frame_skip) {
            let compiled = Compiled::new(model.get_ref(), model.span(), frame_skip, path)?;
            compiled.check(&document)?;
            let document = document.placed(&Tree::of(&compiled.model)?, compiled.model.position_dim())?;
            let rest = [compiled.model.rest(), &vec![0.0; document.state.len() - document.moving()]].concat();
            let task = document.task(frame_skip as f64 * compiled.model.timestep(), &rest)?;
            return Ok((Self::Mujoco(compiled), task, document));
        }
        let dt = document.dt.or(dt).context("there is no `dt`: the seconds of one control interval")?;
        let task = document.task(dt, &vec![0.0; document.state.len()])?;
        let simulator = match Equations::of(&document)? {
            Some(equations) => {
                let lines = equations.lines().to_vec();
                let held = Held::new(equations, Scheme::Rk4 { substeps: SUBSTEPS }, dt);
                Self::Equations { dynamics: Arc::new(Bounded::new(held, &task.spec.state)), lines }
            }
            None => Self::None,
        };
        Ok((simulator, task, document))
    }

    /// The text of a task file for a record, `text` as it was, and the files beside it.
    pub(super) fn recorded(&self, text: &str) -> anyhow::Result<(String, Files)> {
        match self {
            Self::Mujoco(compiled) => compiled.recorded(text),
            _ => Ok((text.to_owned(), Vec::new())),
        }
    }
}

impl Compiled {
    fn new(name: &str, place: Range<usize>, frame_skip: usize, task_file: &Path) -> anyhow::Result<Self> {
        let path = task_file.parent().unwrap_or(Path::new("")).join(name);
        let text = fs::read(&path).with_context(|| format!("cannot read its model {}", path.display()))?;
        let library = Library::load(&Search::from_environment())?;
        let model = MujocoModel::from_file(&library, &path)?;
        Ok(Self { library, model, frame_skip, name: place, path, text })
    }

    /// Refuses a model that has other states or controls than are declared.
    fn check(&self, document: &Document) -> anyhow::Result<()> {
        let (nq, nv, nu) = (self.model.position_dim(), self.model.velocity_dim(), self.model.control_dim());
        let (states, controls) = (document.moving(), document.control.len());
        let needed = nq + nv;
        ensure!(
            states == needed,
            "its model has {nq} positions and {nv} velocities and needs {needed} [[state]] tables in that order, got \
             {states}"
        );
        ensure!(controls == nu, "its model has {nu} actuators and needs {nu} [[control]] tables, got {controls}");
        Ok(())
    }

    /// A model that needs other files (meshes, included models) does not compile apart from them; the record then names the
    /// original.
    fn recorded(&self, text: &str) -> anyhow::Result<(String, Files)> {
        let apart = tempfile::tempdir().context("cannot make a temporary directory")?;
        let copy = apart.path().join(RECORDED_MODEL);
        fs::write(&copy, &self.text).with_context(|| format!("cannot write {}", copy.display()))?;
        let model = match MujocoModel::from_file(&self.library, &copy) {
            Ok(_) => RECORDED_MODEL.into(),
            Err(_) => std::path::absolute(&self.path)?.display().to_string(),
        };
        let mut text = text.to_owned();
        text.replace_range(self.name.clone(), &toml::Value::String(model).to_string());
        Ok((text, vec![(RECORDED_MODEL, self.text.clone())]))
    }
}
