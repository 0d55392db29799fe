//! Identified equations, ready to be evaluated and followed.

use ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyArithmeticError, PyValueError};
use pyo3::prelude::*;
use sindyna_core::{Dynamics as _, Scheme, Seed};
use sindyna_sindy::{AnalysisError, Form};

use crate::integrate::{Failure, Input, Tolerance, follow};
use crate::interrupt::{Look, apart};
use crate::pair::Pair;

/// Rows between two looks for signals.
const LOOK: usize = 4096;

/// Rows whose right-hand sides take a few microseconds.
const FEW: usize = 64;

/// Identified equations over states x0, x1, … and inputs u0, u1, ….
#[pyclass(frozen, module = "sindyna._sindyna")]
#[derive(Debug)]
pub(crate) struct Model {
    inner: sindyna_sindy::Model,
}

impl Model {
    pub(crate) fn new(inner: sindyna_sindy::Model) -> Self {
        Self { inner }
    }

    pub(crate) fn inner(&self) -> &sindyna_sindy::Model {
        &self.inner
    }

    fn check(&self, states: usize, controls: usize) -> PyResult<()> {
        let (n, k) = (self.inner.states().len(), self.inner.controls().len());
        if (states, controls) == (n, k) {
            return Ok(());
        }
        Err(PyValueError::new_err(format!("expected {n} states and {k} inputs, got {states} and {controls}")))
    }
}

fn refused(error: &AnalysisError) -> PyErr {
    match error {
        AnalysisError::Diverged { .. } | AnalysisError::Singular => PyArithmeticError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

#[pymethods]
impl Model {
    /// Reads a model from JSON.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        sindyna_sindy::Model::from_json(text).map(Self::new).map_err(|e| PyValueError::new_err(e.to_string()))
    }

    /// The model as JSON, with every digit.
    fn to_json(&self) -> String {
        self.inner.to_json()
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (String,))> {
        Ok((py.get_type::<Self>().getattr("from_json")?.unbind(), (self.to_json(),)))
    }

    /// What the equations are: `continuous`, stepped by `euler` or `semi_implicit` Euler, or a `discrete` map.
    #[getter]
    fn form(&self) -> &'static str {
        match self.inner.form() {
            Form::Increment | Form::Continuous(Scheme::Euler) => "euler",
            Form::Discrete => "discrete",
            Form::Continuous(_) => "continuous",
            Form::SemiImplicit { .. } => "semi_implicit",
        }
    }

    /// The sampling interval in seconds.
    #[getter]
    fn dt(&self) -> f64 {
        self.inner.dt()
    }

    /// The right-hand sides (N, n) at states (N, n) and inputs (N, k).
    fn right_side<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'py, f64>,
        u: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (x, u) = (x.as_array(), u.as_array());
        self.check(x.ncols(), u.ncols())?;
        let (n, k) = (x.ncols(), u.ncols());
        if x.nrows() != u.nrows() {
            return Err(PyValueError::new_err(format!("{} states need as many inputs, got {}", x.nrows(), u.nrows())));
        }
        let (x, u) = (x.as_standard_layout(), u.as_standard_layout());
        let (Some(states), Some(inputs)) = (x.as_slice(), u.as_slice()) else {
            unreachable!("standard layout was made")
        };
        let rows = |out: &mut Vec<f64>| -> PyResult<()> {
            let look = Look::new();
            for (i, out) in out.chunks_mut(LOOK * n.max(1)).enumerate() {
                if i > 0 {
                    look.check()?;
                }
                let of = |width: usize| i * LOOK * width..(i * LOOK + out.len() / n.max(1)) * width;
                self.inner.eval_rows(&states[of(n)], &inputs[of(k)], out);
            }
            Ok(())
        };
        let mut out = vec![0.0; states.len()];
        // The lock is not worth giving back for a few microseconds.
        if x.nrows() < FEW {
            rows(&mut out)?;
        } else {
            py.detach(|| rows(&mut out))?;
        }
        let out = Array2::from_shape_vec(x.raw_dim(), out).map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(out.into_pyarray(py))
    }

    /// The next states (N, n) after one interval `dt` in which inputs (N, k) are held.
    fn step<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'py, f64>,
        u: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (x, u) = (x.as_array(), u.as_array());
        self.check(x.ncols(), u.ncols())?;
        let mut out = Array2::from_elem(x.raw_dim(), f64::NAN);
        py.detach(|| -> PyResult<()> {
            let look = Look::new();
            let mut rng = Seed::new(0).stream("no randomness", 0);
            let mut next = vec![0.0; x.ncols()];
            for (i, ((x, u), mut out)) in x.rows().into_iter().zip(u.rows()).zip(out.rows_mut()).enumerate() {
                if i % LOOK == LOOK - 1 {
                    look.check()?;
                }
                // A step out of the finite numbers leaves them.
                let _ = self.inner.step(&x.to_vec(), &u.to_vec(), &mut rng, &mut next);
                out.iter_mut().zip(&next).for_each(|(slot, v)| *slot = *v);
            }
            Ok(())
        })?;
        Ok(out.into_pyarray(py))
    }

    /// The states (T + 1, n) from `x0` on under inputs (T, k), stepped as the equations were identified.
    fn stepped<'py>(
        &self,
        py: Python<'py>,
        x0: PyReadonlyArray1<'py, f64>,
        u: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (model, x0, u) = (self.inner.clone(), x0.as_array().to_vec(), u.as_array().to_owned());
        let states = apart(py, move |_| model.simulate(&x0, u.view()))?.map_err(|e| refused(&e))?;
        Ok(states.into_pyarray(py))
    }

    /// The solution (T, n) at times (T) of equations in continuous time. `u` is one of: values (T, k), each held until the next time;
    /// with `linear` those between which it is a straight line; a callable of time.
    #[pyo3(signature = (x0, t, u, call, linear, rtol, atol))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        x0: PyReadonlyArray1<'py, f64>,
        t: PyReadonlyArray1<'py, f64>,
        u: PyReadonlyArray2<'py, f64>,
        call: Option<Py<PyAny>>,
        linear: bool,
        rtol: f64,
        atol: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (x0, t, u) = (x0.as_array().to_vec(), t.as_array().to_vec(), u.as_array());
        let k = self.inner.controls().len();
        self.check(x0.len(), if call.is_some() { k } else { u.ncols() })?;
        let input = match &call {
            Some(call) => Input::Call(call, k),
            None if linear => Input::Linear(u),
            None => Input::Held(u),
        };
        let solved = py.detach(|| {
            let look = Look::new();
            follow(&self.inner, &x0, &t, &input, Tolerance { rtol, atol }, &look)
        });
        let solved = solved.map_err(|failure| match failure {
            Failure::Python(e) => e,
            other => PyArithmeticError::new_err(other.to_string()),
        })?;
        Ok(solved.into_pyarray(py))
    }

    /// Predictions of samples (T + 1, n), each `horizon` steps ahead; from the first sample on without a horizon. Under inputs (T, k), `dt` (T) apart.
    #[pyo3(signature = (x, u, dt, horizon=None))]
    fn ahead<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'py, f64>,
        u: PyReadonlyArray2<'py, f64>,
        dt: PyReadonlyArray1<'py, f64>,
        horizon: Option<usize>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (model, dt) = (self.inner.clone(), dt.as_array().to_vec());
        let (x, u) = (x.as_array().to_owned(), u.as_array().to_owned());
        let predicted =
            apart(py, move |_| model.predict(x.view(), u.view(), &dt, horizon))?.map_err(|e| refused(&e))?;
        Ok(predicted.into_pyarray(py))
    }

    /// ∂f/∂x (n, n) and ∂f/∂u (n, k) of the right-hand sides f at a state (n) and an input (k).
    fn jacobians<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'py, f64>,
        u: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Pair<'py>> {
        let (a, b) = self.inner.jacobians(&x.as_array().to_vec(), &u.as_array().to_vec()).map_err(|e| refused(&e))?;
        Ok((a.into_pyarray(py), b.into_pyarray(py)))
    }
}
