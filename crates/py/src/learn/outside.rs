//! A system that Python steps: Gymnasium's environments, hardware.

use std::sync::{Arc, Mutex, PoisonError};

use numpy::{IntoPyArray as _, PyReadonlyArray1};
use pyo3::prelude::*;
use rand::Rng as _;
use sindyna::core::{EnvError, Environment, Outcome, Rng, Spec};

/// The first exception that Python raised where the engine asked it something.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Keeps `error` if it is the first; what it says.
    pub(crate) fn keep(&self, error: PyErr) -> String {
        let told = error.to_string();
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        told
    }

    /// Whether there is one.
    pub(crate) fn is_there(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Takes it out.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// An object with `reset(seed)`, which gives the first observation (m), and `step(action)`, which gives observation (m), reward, terminated and truncated.
pub(crate) struct Outside {
    object: Py<PyAny>,
    spec: Spec,
    max_steps: usize,
    observation: Vec<f64>,
    steps: usize,
    running: bool,
    raised: Raised,
}

/// What a step gives.
type Step<'py> = (PyReadonlyArray1<'py, f64>, f64, bool, bool);

impl Outside {
    pub(crate) fn new(object: Py<PyAny>, spec: Spec, max_steps: usize, raised: Raised) -> Self {
        let observation = vec![0.0; spec.observation_dim()];
        Self { object, spec, max_steps, observation, steps: 0, running: false, raised }
    }

    fn failed(&self, error: PyErr) -> EnvError {
        EnvError::System { reason: self.raised.keep(error) }
    }

    fn observed(&mut self, values: &[f64]) -> Result<(), EnvError> {
        if values.len() != self.observation.len() {
            let (expected, got) = (self.observation.len(), values.len());
            return Err(EnvError::System { reason: format!("it shows {got} values where {expected} are declared") });
        }
        self.observation.copy_from_slice(values);
        Ok(())
    }
}

impl Environment for Outside {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        // Gymnasium takes seeds of 31 bits everywhere.
        let seed = rng.next_u32() >> 1;
        let first = Python::attach(|py| -> PyResult<Vec<f64>> {
            let first: PyReadonlyArray1<'_, f64> = self.object.bind(py).call_method1("reset", (seed,))?.extract()?;
            Ok(first.as_array().to_vec())
        });
        self.observed(&first.map_err(|e| self.failed(e))?)?;
        (self.steps, self.running) = (0, true);
        Ok(())
    }

    fn step(&mut self, action: &[f64], _rng: &mut Rng) -> Result<Outcome, EnvError> {
        if !self.running {
            return Err(EnvError::NeedsReset);
        }
        let mut control = vec![0.0; self.spec.control_dim()];
        if !self.spec.action_space.control_into(action, &mut control) {
            return Err(EnvError::NotAnAction { action: action.to_vec() });
        }
        self.running = false;
        let step = Python::attach(|py| -> PyResult<(Vec<f64>, f64, bool, bool)> {
            let action = action.to_vec().into_pyarray(py);
            let (next, reward, terminated, truncated): Step<'_> =
                self.object.bind(py).call_method1("step", (action,))?.extract()?;
            Ok((next.as_array().to_vec(), reward, terminated, truncated))
        });
        let (next, reward, terminated, truncated) = step.map_err(|e| self.failed(e))?;
        self.observed(&next)?;
        self.steps += 1;
        // Not every environment has a limit of its own.
        let truncated = truncated || self.steps >= self.max_steps;
        self.running = !(terminated || truncated);
        Ok(Outcome { reward, terminated, truncated })
    }
}
