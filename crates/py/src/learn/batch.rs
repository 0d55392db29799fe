//! Copies of a system in this program, stepped side by side.

use std::sync::{Arc, Mutex, PoisonError};

use ndarray::Array2;
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::prelude::*;
use sindyna::core::{Bounded, Dynamics, EnvError, Environment as _, Rng, Seed, Sensors, Simulated, Space, Spec, Task};
use sindyna_envs::System;
use sindyna_sindy::Expr;

use super::outside::Raised;
use super::system::{Declared, refused, sensors};
use super::task::{Functions, PyTask};
use crate::library::symbols;
use crate::model::Model;

/// Lanes that one thread steps at a time, at least: fewer are not worth another thread.
const TOGETHER: usize = 128;

/// One copy, in the middle of an episode or after one.
struct Lane {
    system: Simulated<Arc<dyn Dynamics>, Arc<dyn Task>, Sensors>,
    rng: Rng,
    /// Whether its episode is over.
    over: bool,
}

/// What a step of one lane gives.
#[derive(Clone, Copy, Default)]
struct Step {
    reward: f64,
    terminated: bool,
    truncated: bool,
    diverged: bool,
}

impl Lane {
    fn step(&mut self, action: &[f64], autoreset: bool) -> Result<Step, EnvError> {
        if self.over && autoreset {
            self.over = false;
            self.system.reset(&mut self.rng)?;
            return Ok(Step::default());
        }
        let step = match self.system.step(action, &mut self.rng) {
            Ok(o) => Step { reward: o.reward, terminated: o.terminated, truncated: o.truncated, diverged: false },
            // Equations that blow up say nothing of the value of what comes after.
            Err(EnvError::Diverged { .. } | EnvError::Reward { .. }) => {
                Step { truncated: true, diverged: true, ..Step::default() }
            }
            Err(other) => return Err(other),
        };
        self.over = step.terminated || step.truncated;
        Ok(step)
    }
}

/// Copies of one system, stepped side by side.
#[pyclass(frozen, module = "sindyna._sindyna")]
pub(crate) struct Batch {
    lanes: Mutex<Vec<Lane>>,
    spec: Spec,
    max_steps: usize,
    raised: Raised,
}

/// Observations (N, m), rewards, terminated, truncated, diverged (N).
type Stepped<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
);

impl Batch {
    pub(super) fn new(
        dynamics: Arc<dyn Dynamics>,
        task: Arc<dyn Task>,
        sensors: Sensors,
        copies: usize,
        raised: Raised,
    ) -> PyResult<Self> {
        if copies == 0 {
            return Err(refused("there must be at least 1 copy, got 0"));
        }
        let (spec, max_steps) = (task.spec().clone(), task.max_steps());
        let lane = |_| {
            let system = Simulated::new(dynamics.clone(), task.clone(), sensors.clone());
            Lane { system, rng: Seed::new(0).numpy(), over: false }
        };
        Ok(Self { lanes: Mutex::new((0..copies).map(lane).collect()), spec, max_steps, raised })
    }

    fn with_lanes<T>(&self, f: impl FnOnce(&mut [Lane]) -> T) -> T {
        f(&mut self.lanes.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn observations(&self) -> Array2<f64> {
        let m = self.spec.observation_dim();
        self.with_lanes(|lanes| {
            let mut shown = Array2::zeros((lanes.len(), m));
            for (lane, mut row) in lanes.iter().zip(shown.rows_mut()) {
                row.iter_mut().zip(lane.system.observation()).for_each(|(slot, v)| *slot = *v);
            }
            shown
        })
    }

    fn failed(&self, error: &EnvError) -> PyErr {
        self.raised.take().unwrap_or_else(|| PyRuntimeError::new_err(error.to_string()))
    }
}

#[pymethods]
impl Batch {
    /// Seconds from step to step.
    #[getter]
    fn dt(&self) -> f64 {
        self.spec.dt
    }

    /// Steps after which an episode is truncated.
    #[getter]
    fn max_steps(&self) -> usize {
        self.max_steps
    }

    /// Range of each observed value.
    #[getter]
    fn bounds(&self) -> Vec<(f64, f64)> {
        self.spec.observation.iter().map(|channel| channel.prior.bounds).collect()
    }

    /// Whether observations are rounded to float32.
    #[getter]
    fn float32(&self) -> bool {
        self.spec.precision == sindyna::core::Precision::F32
    }

    /// Ranges of real actions; none where actions are numbered.
    #[getter]
    fn action_bounds(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        match &self.spec.action_space {
            Space::Box { low, high } => Some((low.clone(), high.clone())),
            Space::Discrete { .. } => None,
        }
    }

    /// How many actions there are, where they are numbered.
    #[getter]
    fn n_actions(&self) -> usize {
        match &self.spec.action_space {
            Space::Box { .. } => 0,
            Space::Discrete { controls } => controls.nrows(),
        }
    }

    /// Begins episodes, where `which` says so; copy i draws from NumPy's generator of `seed` + i from then on. Observations (N, m).
    #[pyo3(signature = (seed=None, which=None))]
    fn reset<'py>(
        &self,
        py: Python<'py>,
        seed: Option<u64>,
        which: Option<Vec<bool>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let begun = py.detach(|| {
            self.with_lanes(|lanes| -> Result<(), EnvError> {
                for (i, lane) in lanes.iter_mut().enumerate() {
                    if let Some(seed) = seed {
                        lane.rng = Seed::new(seed.wrapping_add(i as u64)).numpy();
                    }
                    if which.as_ref().is_none_or(|which| which.get(i).copied().unwrap_or(false)) {
                        lane.over = false;
                        lane.system.reset(&mut lane.rng)?;
                    }
                }
                Ok(())
            })
        });
        begun.map_err(|e| self.failed(&e))?;
        Ok(self.observations().into_pyarray(py))
    }

    /// Begins episodes in states (N, n). Observations (N, m).
    fn reset_to<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let states = states.as_array();
        self.with_lanes(|lanes| {
            if states.dim() != (lanes.len(), self.spec.state_dim()) {
                let expected = (lanes.len(), self.spec.state_dim());
                return Err(refused(format!("states must have the shape {expected:?}, got {:?}", states.dim())));
            }
            for (lane, x) in lanes.iter_mut().zip(states.rows()) {
                lane.over = false;
                lane.system.reset_to(&x.to_vec(), &mut lane.rng);
            }
            Ok(())
        })?;
        Ok(self.observations().into_pyarray(py))
    }

    /// The states (N, n).
    fn states<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let n = self.spec.state_dim();
        let states = self.with_lanes(|lanes| {
            let mut states = Array2::zeros((lanes.len(), n));
            for (lane, mut row) in lanes.iter().zip(states.rows_mut()) {
                row.iter_mut().zip(lane.system.state()).for_each(|(slot, v)| *slot = *v);
            }
            states
        });
        states.into_pyarray(py)
    }

    /// One step of every copy with actions (N, values). With `autoreset`, the step after the end of an episode begins the next one and pays nothing.
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
        autoreset: bool,
    ) -> PyResult<Stepped<'py>> {
        let (actions, values) = (actions.as_array(), self.spec.action_space.action_dim());
        let n = self.with_lanes(|lanes| lanes.len());
        if actions.dim() != (n, values) {
            return Err(refused(format!("actions must have the shape {:?}, got {:?}", (n, values), actions.dim())));
        }
        let actions: Vec<f64> = actions.iter().copied().collect();
        let steps: Result<Vec<Step>, EnvError> = py.detach(|| {
            self.with_lanes(|lanes| {
                lanes
                    .par_iter_mut()
                    .with_min_len(TOGETHER)
                    .zip(actions.par_chunks(values))
                    .map(|(lane, action)| lane.step(action, autoreset))
                    .collect()
            })
        });
        let steps = steps.map_err(|e| self.failed(&e))?;
        if let Some(raised) = self.raised.take() {
            return Err(raised);
        }
        let flags = |of: fn(&Step) -> bool| steps.iter().map(of).collect::<Vec<bool>>().into_pyarray(py);
        Ok((
            self.observations().into_pyarray(py),
            steps.iter().map(|s| s.reward).collect::<Vec<f64>>().into_pyarray(py),
            flags(|s| s.terminated),
            flags(|s| s.truncated),
            flags(|s| s.diverged),
        ))
    }
}

fn builtin_system(name: &str) -> PyResult<System> {
    let unknown = || refused(format!("no system named `{name}`; known: {}", sindyna::problem::names().join(", ")));
    sindyna_envs::find(name).ok_or_else(unknown)
}

/// Copies of the system that comes along as `name`.
#[pyfunction]
pub(crate) fn builtin(name: &str, copies: usize) -> PyResult<Batch> {
    let system = builtin_system(name)?;
    Batch::new(system.dynamics(), system.task(), system.sensors(), copies, Raised::default())
}

/// Copies of a system as learned equations tell it.
#[pyfunction]
#[pyo3(signature = (system, task, model, copies, reward=None, terminated=None))]
pub(crate) fn learned(
    system: &str,
    task: &str,
    model: &Model,
    copies: usize,
    reward: Option<Py<PyAny>>,
    terminated: Option<Py<PyAny>>,
) -> PyResult<Batch> {
    let declared = Declared::read(system)?;
    let spec = declared.spec()?;
    let dynamics = Arc::new(Bounded::new(model.inner().clone(), &spec.state));
    let (raised, sensors) = (Raised::default(), sensors(&spec)?);
    let task = PyTask::new(&declared, task, Functions { reward, terminated }, raised.clone())?;
    Batch::new(dynamics, Arc::new(task), sensors, copies, raised)
}

/// Copies of the system that comes along as `name`, moving as the equations of a run of the command tell.
#[pyfunction]
pub(crate) fn learned_builtin(name: &str, model: &Model, copies: usize) -> PyResult<Batch> {
    let system = builtin_system(name)?;
    let dynamics = Arc::new(Bounded::new(model.inner().clone(), &system.spec().state));
    Batch::new(dynamics, system.task(), system.sensors(), copies, Raised::default())
}

/// Copies of a system of one's own: right-hand sides as formulas over states and inputs, of rates, or of the next states of a map.
#[pyfunction]
#[pyo3(signature = (system, task, equations, map, copies, reward=None, terminated=None))]
pub(crate) fn written(
    system: &str,
    task: &str,
    equations: Vec<String>,
    map: bool,
    copies: usize,
    reward: Option<Py<PyAny>>,
    terminated: Option<Py<PyAny>>,
) -> PyResult<Batch> {
    let declared = Declared::read(system)?;
    let spec = declared.spec()?;
    let names = symbols(spec.state_dim(), spec.control_dim());
    let read = |text: &String| sindyna_sindy::parse(text, &names).map_err(refused);
    let equations: Vec<Expr> = equations.iter().map(read).collect::<PyResult<_>>()?;
    if equations.len() != spec.state_dim() {
        return Err(refused(format!("{} states need as many equations, got {}", spec.state_dim(), equations.len())));
    }
    let values = move |x: &[f64], u: &[f64], out: &mut [f64]| {
        let z = [x, u].concat();
        out.iter_mut().zip(&equations).for_each(|(slot, equation)| *slot = equation.eval(&z));
    };
    let dynamics: Arc<dyn Dynamics> = if map {
        let next = move |x: &[f64], u: &[f64]| {
            let mut next = vec![0.0; x.len()];
            values(x, u, &mut next);
            next
        };
        Arc::new(sindyna::problem::stepped(next))
    } else {
        Arc::new(sindyna::problem::ode(spec.dt, values))
    };
    let (raised, sensors) = (Raised::default(), sensors(&spec)?);
    let task = PyTask::new(&declared, task, Functions { reward, terminated }, raised.clone())?;
    Batch::new(dynamics, Arc::new(task), sensors, copies, raised)
}
