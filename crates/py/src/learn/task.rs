//! Start states, reward and end of an episode, as Python gives them: formulas, or functions of arrays.

use std::sync::Arc;

use ndarray::ArrayView2;
use numpy::IntoPyArray as _;
use pyo3::prelude::*;
use serde::Deserialize;
use sindyna::core::{Observe as _, Rng, Seed, Sensors, Spec, Task};
use sindyna::problem::FormulaTask;

use super::outside::Raised;
use super::system::{Declared, refused, sensors};

/// Formulas of a task, and where its episodes begin.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Formulas {
    /// Range of each state.
    starts: Vec<(f64, f64)>,
    /// Samples from which each range was estimated; null where it is known, as all are by default.
    #[serde(default)]
    samples: Vec<Option<usize>>,
    /// Over states, inputs, states after the step (`next_x0`) and `terminated`.
    reward: String,
    /// A condition on states after the step.
    terminated: Option<String>,
}

/// Functions that take the place of formulas.
#[derive(Default)]
pub(crate) struct Functions {
    /// Rewards (N) of observations (N, m), actions (N, values) and next observations (N, m).
    pub(crate) reward: Option<Py<PyAny>>,
    /// Whether next observations (N, m) end an episode (N).
    pub(crate) terminated: Option<Py<PyAny>>,
}

/// A task of formulas and functions.
pub(crate) struct PyTask {
    formulas: FormulaTask,
    functions: Arc<Functions>,
    sensors: Sensors,
    raised: Raised,
}

impl PyTask {
    pub(crate) fn new(declared: &Declared, formulas: &str, functions: Functions, raised: Raised) -> PyResult<Self> {
        let spec = declared.spec()?;
        let Formulas { starts, samples, reward, terminated } = serde_json::from_str(formulas).map_err(refused)?;
        let finite = |(low, high): &(f64, f64)| low.is_finite() && high.is_finite() && low <= high;
        if starts.len() != spec.state_dim() || samples.len() > starts.len() || !starts.iter().all(finite) {
            return Err(refused(format!(
                "every one of the {} states needs a finite range of start values",
                spec.state_dim()
            )));
        }
        let sensors = sensors(&spec)?.without_noise();
        let formulas =
            FormulaTask::new(spec, declared.max_steps, starts, &reward, terminated.as_deref()).map_err(refused)?;
        let formulas = formulas.with_folded_angles().with_estimated_starts(samples);
        Ok(Self { formulas, functions: Arc::new(functions), sensors, raised })
    }

    /// What the sensors show of state `x`, as one row.
    fn shown(&self, x: &[f64]) -> Vec<f64> {
        let mut o = vec![0.0; self.formulas.spec().observation_dim()];
        // Sensors without noise draw nothing.
        self.sensors.observe(x, &mut Seed::new(0).numpy(), &mut o);
        o
    }

    /// The only value of what `function` gives for one row of each of `arguments`.
    fn call(&self, function: &Py<PyAny>, arguments: &[&[f64]]) -> Option<f64> {
        let called = Python::attach(|py| -> PyResult<f64> {
            let rows = arguments.iter().map(|values| {
                let row = ArrayView2::from_shape((1, values.len()), values).map_err(refused)?;
                Ok(row.to_owned().into_pyarray(py))
            });
            let rows = pyo3::types::PyTuple::new(py, rows.collect::<PyResult<Vec<_>>>()?)?;
            let given = function.bind(py).call1(rows)?;
            // An array of one row, or a number.
            if given.hasattr("item")? { given.call_method0("item")? } else { given }.extract()
        });
        called.map_err(|e| self.raised.keep(e)).ok()
    }
}

impl Task for PyTask {
    fn spec(&self) -> &Spec {
        self.formulas.spec()
    }

    fn max_steps(&self) -> usize {
        self.formulas.max_steps()
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        self.formulas.initial(rng, x);
    }

    fn reward(&self, x: &[f64], action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        match &self.functions.reward {
            None => self.formulas.reward(x, action, u, next),
            // An exception ends the run; until then no step pays anything.
            Some(function) => self.call(function, &[&self.shown(x), action, &self.shown(next)]).unwrap_or(0.0),
        }
    }

    fn draw(&self, rng: &mut Rng) -> Option<Arc<dyn Task>> {
        let Self { functions, sensors, raised, .. } = self;
        let (functions, sensors, raised) = (functions.clone(), sensors.clone(), raised.clone());
        Some(Arc::new(Self { formulas: self.formulas.drawn(rng)?, functions, sensors, raised }))
    }

    fn terminated(&self, next: &[f64]) -> bool {
        match &self.functions.terminated {
            None => self.formulas.terminated(next),
            Some(function) => self.call(function, &[&self.shown(next)]).is_some_and(|value| value != 0.0),
        }
    }
}
