//! Task files: observations, reward, end and limits of a system in TOML (`docs/task-files.md`), which is an MJCF model, equations, or
//! a log.

mod check;
mod definitions;
mod document;
mod drawn;
mod equations;
mod observed;
mod places;
#[cfg(test)]
mod rewards;
mod simulator;
mod spec;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use sindyna_core::{Computed, Dynamics, EnvError, Environment, Precision, Protocol, Sensors, Simulated, Spec, Task};
use sindyna_mujoco::MujocoEnvironment;
use sindyna_sindy::Expr;

use crate::Error;
use crate::problem::{FormulaTask, Problem};
use document::{Document, State, StateKind};
use simulator::{Compiled, Simulator};

/// Name of the task file in a run directory.
pub const RECORDED_TASK: &str = "task.toml";

/// A task read from a file, with its simulator if it has one.
#[derive(Clone)]
pub(crate) struct TaskFile {
    task: Arc<FormulaTask>,
    sensors: Sensors,
    /// Observed values that are formulas.
    formulas: Vec<(String, Expr)>,
    simulator: Simulator,
    text: String,
    path: PathBuf,
    dt: Option<f64>,
    solved_at: Option<f64>,
    /// States of which it is not said whether they are angles, and may be.
    open: Vec<usize>,
    /// Whether it is said of any.
    declares_kinds: bool,
}

impl TaskFile {
    /// Reads the task file at `path` and what it names, and finds MuJoCo if that is needed. `dt` \[s\] is the control interval where the file
    /// tells none.
    pub(crate) fn load(path: &Path, dt: Option<f64>) -> Result<Self, Error> {
        let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()));
        text.and_then(|text| Self::read(path, text, dt)).map_err(|e| wrong(path, e))
    }

    /// Reads the task file at `path`, which must have a simulator.
    pub(crate) fn with_simulator(path: &Path) -> Result<Self, Error> {
        // Whether there is a simulator does not depend on the control interval.
        let file = Self::load(path, Some(1.0))?;
        if file.has_simulator() {
            return Ok(file);
        }
        Err(wrong(
            path,
            anyhow::anyhow!(
                "there is neither a `model` nor [equations], so no simulator: use --data LOG, --model DIR or --pipe COMMAND"
            ),
        ))
    }

    /// Reads the task file at `path` of a system that is a program: it must have no simulator, and tell its control interval.
    pub(crate) fn without_simulator(path: &Path) -> Result<Self, Error> {
        let file = Self::load(path, None)?;
        if file.has_simulator() {
            let why = "it has a simulator of its own, a `model` or [equations]: with --pipe the program is the system";
            return Err(wrong(path, anyhow::anyhow!(why)));
        }
        Ok(file)
    }

    fn read(path: &Path, text: String, dt: Option<f64>) -> anyhow::Result<Self> {
        Self::read_with(path, text, dt, (&[], &[]))
    }

    /// The same where the states `angles`, of which it is not said what they are, are angles.
    pub(crate) fn with_angles(self, angles: &[usize]) -> Result<Self, Error> {
        if angles.is_empty() {
            return Ok(self);
        }
        let dt = Some(self.task.spec.dt);
        Self::read_with(&self.path, self.text, dt, (angles, &[])).map_err(|e| wrong(&self.path, e))
    }

    /// The same where the states `angles` are angles, as in [`Self::with_angles`], and what actuators of its controls deliver are its last states, with the names (k) and at rest at first.
    pub(crate) fn with_actuators(self, angles: &[usize], names: &[String]) -> Result<Self, Error> {
        let dt = Some(self.task.spec.dt);
        Self::read_with(&self.path, self.text, dt, (angles, names)).map_err(|e| wrong(&self.path, e))
    }

    fn read_with(
        path: &Path,
        text: String,
        dt: Option<f64>,
        (angles, actuators): (&[usize], &[String]),
    ) -> anyhow::Result<Self> {
        let mut document: Document = toml::from_str(&text)?;
        let declares_kinds = document.state.iter().any(|state| state.kind.is_some());
        angles.iter().for_each(|i| document.state[*i].kind = Some(StateKind::Angle));
        let may_turn = |s: &State| s.kind.is_none() && s.rate_of.is_none() && s.bounds.is_none();
        let open = (0..document.state.len()).filter(|i| may_turn(&document.state[*i])).collect();
        let document = document.with_drawn().with_actuators(actuators);
        document.check()?;
        let (simulator, task, document) = Simulator::of(document, path, dt)?;
        let formulas = document.observed(&task.spec.state)?.formulas;
        let sensors = sensors(&task.spec, &formulas).context("an observation shows no state")?;
        Ok(Self {
            task: Arc::new(task),
            sensors,
            formulas,
            simulator,
            text,
            path: path.to_owned(),
            dt: document.dt,
            solved_at: document.solved_at,
            open,
            declares_kinds,
        })
    }

    /// The same with noise on its sensors: `fraction` of every observation channel's scale.
    pub(crate) fn with_noise(mut self, fraction: f64) -> Self {
        Arc::make_mut(&mut self.task).spec.noise = fraction;
        self.sensors = sensors(&self.task.spec, &self.formulas).expect("noise changes no channel");
        self
    }

    /// The same with states as fine as `precision`.
    pub(crate) fn with_precision(mut self, precision: Precision) -> Self {
        Arc::make_mut(&mut self.task).spec.precision = precision;
        self
    }

    /// The control interval that the file itself tells \[s\].
    pub(crate) fn dt(&self) -> Option<f64> {
        self.dt
    }

    /// States without bounds, rates of no others, of which it is not said whether they are angles.
    pub(crate) fn open(&self) -> &[usize] {
        &self.open
    }

    /// Whether it is said of any state whether it is an angle.
    pub(crate) fn declares_kinds(&self) -> bool {
        self.declares_kinds
    }

    /// Whether MuJoCo is what moves.
    pub(crate) fn is_mujoco(&self) -> bool {
        matches!(self.simulator, Simulator::Mujoco(_))
    }

    /// Observed values that are formulas of the states, by the names of their channels.
    pub(crate) fn formulas(&self) -> &[(String, Expr)] {
        &self.formulas
    }

    /// Whether something moves.
    pub(crate) fn has_simulator(&self) -> bool {
        !matches!(self.simulator, Simulator::None)
    }
}

/// The sensors of `spec` where some channels are formulas of the states.
fn sensors(spec: &Spec, formulas: &[(String, Expr)]) -> Option<Sensors> {
    let computed = |formula: &Expr| -> Computed {
        let formula = formula.clone();
        Arc::new(move |x: &[f64]| formula.eval(x))
    };
    let functions: Vec<_> = formulas.iter().map(|(name, formula)| (name.clone(), computed(formula))).collect();
    Sensors::computing(spec, &functions)
}

fn wrong(path: &Path, e: anyhow::Error) -> Error {
    Error::TaskFile { path: path.to_owned(), source: e.into() }
}

impl Problem for TaskFile {
    fn spec(&self) -> &Spec {
        &self.task.spec
    }

    fn protocol(&self) -> Protocol {
        Protocol { max_steps: self.task.max_steps(), solved_at: self.solved_at }
    }

    fn task(&self) -> Arc<dyn Task> {
        self.task.clone()
    }

    fn sensors(&self) -> Sensors {
        self.sensors.clone()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        let (task, sensors) = (self.task(), self.sensors());
        Ok(match &self.simulator {
            Simulator::Mujoco(compiled) => {
                let still = task.spec().state_dim() - compiled.model.state_dim();
                let Compiled { model, frame_skip, .. } = compiled;
                Box::new(MujocoEnvironment::with_still_states(model, *frame_skip, task, sensors, still)?)
            }
            Simulator::Equations { dynamics, .. } => Box::new(Simulated::new(dynamics.clone(), task, sensors)),
            Simulator::None => {
                let reason = format!("{} has neither a `model` nor [equations]", self.path.display());
                return Err(EnvError::System { reason }.into());
            }
        })
    }

    fn dynamics(&self) -> Option<Arc<dyn Dynamics>> {
        match &self.simulator {
            Simulator::Equations { dynamics, .. } => Some(dynamics.clone()),
            _ => None,
        }
    }

    fn true_equations(&self) -> Vec<String> {
        match &self.simulator {
            Simulator::Equations { lines, .. } => lines.clone(),
            _ => Vec::new(),
        }
    }

    /// The task and what it names as files of a run directory, where they are enough to run it again.
    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        let (text, mut files) = self.simulator.recorded(&self.text).map_err(|e| wrong(&self.path, e))?;
        files.push((RECORDED_TASK, text.into_bytes()));
        Ok(files)
    }
}
