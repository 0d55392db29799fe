//! Collecting steps, and training a controller.

use std::sync::Arc;

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use sindyna::core::{Dataset, End, Environment, Explorer, Inverse, Seed, Task as _};
use sindyna::dyna::{Swings, Uniform};
use sindyna::{Trained, Training};

use super::data::Data;
use super::outside::{Outside, Raised};
use super::policy::Policy;
use super::problem::Asked;
use super::system::{Declared, refused, sensors};
use super::task::{Functions, PyTask};
use crate::identify::account;
use crate::interrupt::apart;
use crate::model::Model;

/// Makes `steps` steps on the system that `object` is, over as many episodes as it takes, by the explorer of every default; with `random` actions where many
/// are numbered, of which that one knows only two.
#[pyfunction]
pub(crate) fn collect(
    py: Python<'_>,
    object: Py<PyAny>,
    system: &str,
    steps: usize,
    seed: u64,
    random: bool,
) -> PyResult<Data> {
    let declared = Declared::read(system)?;
    let (spec, max_steps) = (declared.spec()?, declared.max_steps);
    let raised = Raised::default();
    let kept = raised.clone();
    let collected = apart(py, move |stop| -> Result<Dataset, String> {
        let mut explorer: Box<dyn Explorer> =
            if random { Box::new(Uniform::new(&spec)) } else { Box::new(Swings::new(&spec)) };
        let mut data =
            Dataset::new(spec.observation_dim(), spec.control_dim(), spec.action_space.action_dim(), spec.dt);
        let mut rng = Seed::new(seed).stream("warm-up", 0);
        let (mut action, mut control) = (vec![0.0; spec.action_space.action_dim()], vec![0.0; spec.control_dim()]);
        let mut env = Outside::new(object, spec, max_steps, kept);
        let mut running = false;
        for _ in 0..steps {
            if stop.is_set() {
                break;
            }
            if !running {
                env.reset(&mut rng).map_err(|e| e.to_string())?;
                data.begin(env.observation()).map_err(|e| e.to_string())?;
            }
            explorer.next(&data, &mut rng, &mut action);
            let outcome = env.step(&action, &mut rng).map_err(|e| e.to_string())?;
            env.spec().action_space.control_into(&action, &mut control);
            data.push(&action, &control, outcome.reward, env.observation()).map_err(|e| e.to_string())?;
            running = !(outcome.terminated || outcome.truncated);
            if !running {
                data.finish(if outcome.terminated { End::Terminated } else { End::Truncated });
            }
        }
        Ok(data)
    })?;
    collected.map(|inner| Data { inner }).map_err(|told| raised.take().unwrap_or_else(|| PyRuntimeError::new_err(told)))
}

/// The same data with the rewards and the ends that the task tells, for logs that have none.
#[pyfunction]
#[pyo3(signature = (system, task, data, reward=None, terminated=None))]
pub(crate) fn paid(
    system: &str,
    task: &str,
    data: &Data,
    reward: Option<Py<PyAny>>,
    terminated: Option<Py<PyAny>>,
) -> PyResult<Data> {
    let declared = Declared::read(system)?;
    let spec = declared.spec()?;
    let inverse = Inverse::of(&spec).map_err(refused)?;
    let raised = Raised::default();
    let task = PyTask::new(&declared, task, Functions { reward, terminated }, raised.clone())?;
    let (mut x, mut next) = (vec![0.0; spec.state_dim()], vec![0.0; spec.state_dim()]);
    let (m, k, values) = (spec.observation_dim(), spec.control_dim(), spec.action_space.action_dim());
    let mut told = Dataset::new(m, k, values, spec.dt);
    for rollout in data.inner.rollouts() {
        inverse.state(&rollout.observations.row(0).to_vec(), &vec![0.0; x.len()], &mut x);
        told.begin(&rollout.observations.row(0).to_vec()).map_err(refused)?;
        let mut ended = false;
        for (i, (action, control)) in rollout.actions.rows().into_iter().zip(rollout.controls.rows()).enumerate() {
            let (action, control, o) = (action.to_vec(), control.to_vec(), rollout.observations.row(i + 1).to_vec());
            inverse.state(&o, &x, &mut next);
            told.push(&action, &control, task.reward(&x, &action, &control, &next), &o).map_err(refused)?;
            ended = task.terminated(&next);
            std::mem::swap(&mut x, &mut next);
        }
        told.finish(if ended { End::Terminated } else { End::Cut });
    }
    match raised.take() {
        Some(raised) => Err(raised),
        None => Ok(Data { inner: told }),
    }
}

/// What training came to.
#[pyclass(frozen, module = "sindyna._sindyna")]
pub(crate) struct Outcome {
    inner: Trained,
}

impl Outcome {
    pub(super) fn new(inner: Trained) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl Outcome {
    /// The run in numbers, as JSON.
    #[getter]
    fn summary(&self) -> PyResult<String> {
        serde_json::to_string(&self.inner.summary).map_err(refused)
    }

    /// The equations and the account of their identification, as JSON.
    #[getter]
    fn identified(&self) -> Option<(Model, String)> {
        self.inner.identified.as_ref().map(|found| (Model::new(found.model.clone()), account(found)))
    }

    /// The policy; none if training came to none.
    #[getter]
    fn policy(&self) -> PyResult<Option<Policy>> {
        self.inner.policy.as_ref().map(|policy| Policy::read(policy.to_bytes())).transpose()
    }

    /// Every step and reset of the system but those of the evaluation.
    #[getter]
    fn data(&self) -> Data {
        Data { inner: self.inner.data.clone() }
    }
}

/// Trains a controller for the task on a system of which `data` are known already. `object` is stepped where more is needed, and for the evaluation.
#[pyfunction]
#[pyo3(signature = (system, task, data, seed, settings, max_real_steps=None, object=None, reward=None, terminated=None, evaluated=true))]
#[expect(clippy::too_many_arguments, reason = "Python's keywords")]
pub(crate) fn train(
    py: Python<'_>,
    system: &str,
    task: &str,
    data: &Data,
    seed: u64,
    settings: Vec<String>,
    max_real_steps: Option<usize>,
    object: Option<Py<PyAny>>,
    reward: Option<Py<PyAny>>,
    terminated: Option<Py<PyAny>>,
    evaluated: bool,
) -> PyResult<Outcome> {
    let declared = Declared::read(system)?;
    let (raised, sensors, away) = (Raised::default(), sensors(&declared.spec()?)?, object.is_none());
    let task = Arc::new(PyTask::new(&declared, task, Functions { reward, terminated }, raised.clone())?);
    let problem = Asked { task: task.clone(), sensors, solved_at: declared.threshold, object, raised: raised.clone() };
    let mut training = Training::of(problem).with_seed(seed).with_data(data.inner.clone());
    for setting in &settings {
        training = training.with(setting).map_err(refused)?;
    }
    if let Some(steps) = max_real_steps {
        training = training.with_max_real_steps(steps);
    }
    if away {
        training = training.without_system();
    } else if !evaluated {
        training = training.without_evaluation();
    }
    let trained = apart(py, move |stop| training.run_watched(&mut |_| {}, stop.flag()))?;
    if let Some(raised) = raised.take() {
        return Err(raised);
    }
    let inner = trained.map_err(|e| refused(told(&e)))?;
    if inner.summary.interrupted {
        return Err(PyKeyboardInterrupt::new_err("training was stopped"));
    }
    Ok(Outcome { inner })
}

/// An error with its causes.
pub(super) fn told(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
