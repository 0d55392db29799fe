//! One regression of known or differenced derivatives, as PySINDy makes it.

use ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyList, PyString};
use serde::Deserialize;
use serde_json::{Value, json};
use sindyna_core::Scheme;
use sindyna_sindy::{
    BestSubset, Columns, Differentiator, Finish, FiniteDifference, Library, Regressed, SavitzkyGolay, Selected, Sindy,
    SolverChoice, Stlsq, Target, Trajectory, Watch,
};

use crate::interrupt::apart;
use crate::library::{Recipe, symbols};
use crate::model::Model;
use crate::pair::Pair;

/// What Python's `json` would write of `value`.
fn document(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if value.is_none() {
        return Ok(Value::Null);
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.to_cow()?.into_owned()));
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Value::Bool(flag.is_true()));
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(json!(number.value()));
    }
    if let Ok(entries) = value.cast::<PyDict>() {
        let entry = |(key, value): (Bound<'_, PyAny>, _)| Ok((key.extract()?, document(&value)?));
        return Ok(Value::Object(entries.iter().map(entry).collect::<PyResult<_>>()?));
    }
    if let Ok(items) = value.cast::<PyList>() {
        return Ok(Value::Array(items.iter().map(|item| document(&item)).collect::<PyResult<_>>()?));
    }
    Ok(json!(value.extract::<i64>()?))
}

fn refused(e: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(e.to_string())
}

/// Samples of which a regression takes a few milliseconds.
const FEW: usize = 20_000;

/// A solver, written as `{"stlsq": {"threshold": 0.1, …}}`.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Solver {
    Stlsq { threshold: f64, ridge: f64, max_iterations: usize, normalised: bool, unbiased: bool },
    LeastSquares { ridge: f64 },
    BestSubset { max_size: Option<usize> },
}

impl Solver {
    fn choice(self) -> PyResult<SolverChoice> {
        Ok(match self {
            Self::Stlsq { threshold, ridge, max_iterations, normalised, unbiased } => SolverChoice::Stlsq(
                Stlsq::new(threshold, ridge)
                    .and_then(|s| s.with_max_iterations(max_iterations))
                    .map_err(refused)?
                    .with_columns(if normalised { Columns::Normalised } else { Columns::AsTheyAre })
                    .with_finish(if unbiased { Finish::Unbiased } else { Finish::Ridge }),
            ),
            Self::LeastSquares { ridge } => SolverChoice::LeastSquares { ridge },
            Self::BestSubset { max_size } => SolverChoice::BestSubset(
                max_size.map_or_else(BestSubset::default, |n| BestSubset::default().with_max_size(n)),
            ),
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    library: Recipe,
    solver: Solver,
    /// Whether the next state is regressed, not the derivative.
    discrete: bool,
    /// Order of the finite differences that give derivatives where there are none.
    order: usize,
    dt: f64,
}

/// States, inputs and derivatives of one trajectory.
type Owned = (Array2<f64>, Array2<f64>, Option<Array2<f64>>);

/// The same as Python's.
type Rows<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>, Option<PyReadonlyArray2<'py, f64>>);

/// Regresses derivatives (T, n), or next states, on the terms of a library over states (T, n) and inputs (T, k).
#[pyfunction]
pub(crate) fn regress(
    py: Python<'_>,
    trajectories: Vec<Rows<'_>>,
    settings: &Bound<'_, PyAny>,
) -> PyResult<Regression> {
    let settings: Settings = serde_json::from_value(document(settings)?).map_err(refused)?;
    let target = if settings.discrete {
        Target::Discrete
    } else {
        let differentiator = Differentiator::Finite(FiniteDifference::new(settings.order).map_err(refused)?);
        Target::Continuous { differentiator, scheme: Scheme::Rk4 { substeps: 1 } }
    };
    let searches = matches!(settings.solver, Solver::BestSubset { .. });
    let n_values: usize = trajectories.iter().map(|(x, u, _)| x.as_array().len() + u.as_array().len()).sum();
    let sindy = Sindy::new(settings.library.into(), target, settings.solver.choice()?);
    let owned: Vec<Owned> = trajectories
        .iter()
        .map(|(x, u, x_dot)| {
            let x_dot = x_dot.as_ref().map(|x_dot| x_dot.as_array().to_owned());
            (x.as_array().to_owned(), u.as_array().to_owned(), x_dot)
        })
        .collect();
    let fit = move |go_on: &dyn Fn() -> bool| {
        let trajectories: Vec<Trajectory<'_>> = owned
            .iter()
            .map(|(x, u, x_dot)| Trajectory {
                x: x.view(),
                u: Some(u.view()),
                x_dot: x_dot.as_ref().map(|x_dot| x_dot.view()),
            })
            .collect();
        sindy.regress_watched(&trajectories, settings.dt, &Watch::going_on(go_on))
    };
    // Handing it to another thread would take longer than a small regression.
    let fit = if searches || n_values > FEW {
        apart(py, move |stop| fit(&|| !stop.is_set()))?
    } else {
        py.detach(|| fit(&|| true))
    };
    fit.map(Regression).map_err(refused)
}

/// What a regression found, from which the model, standard errors and conditions are computed when somebody asks.
#[pyclass(frozen, module = "sindyna._sindyna")]
pub(crate) struct Regression(Regressed);

#[pymethods]
impl Regression {
    /// Numbers of the states whose equations have no term.
    #[getter]
    fn empty(&self) -> Vec<usize> {
        self.without(|e| !e.support.is_empty())
    }

    /// Numbers of the states for whose equations the solver came to no rest.
    #[getter]
    fn unsettled(&self) -> Vec<usize> {
        self.without(|e| e.converged)
    }

    /// The equations, ready to step.
    fn model(&self) -> PyResult<Model> {
        self.0.model().map(Model::new).map_err(refused)
    }

    /// The account, in the form of that of an identification.
    fn account(&self) -> String {
        account(&self.0)
    }
}

impl Regression {
    fn without(&self, good: impl Fn(&Selected) -> bool) -> Vec<usize> {
        let equations = self.0.equations().iter().enumerate();
        equations.filter(|(_, equation)| !good(equation)).map(|(i, _)| i).collect()
    }
}

fn account(fit: &Regressed) -> String {
    let names: Vec<&str> = fit.names().collect();
    let equations: Vec<_> = fit
        .equations()
        .iter()
        .enumerate()
        .map(|(i, e)| {
            let errors: Vec<f64> = fit.triangle().spread(&e.support).into_iter().map(|s| s * e.residual).collect();
            json!({
                "state": format!("x{i}"),
                "residual": e.residual,
                "floor": 0.0,
                "reached_floor": false,
                "doubt": null,
                "proved": e.proved,
                "support": e.support,
                "coefficients": e.coefficients,
                "n_known": 0,
                "standard_errors": errors,
                "parameters": [],
                "path": e.path,
                "equally_good": e.ties,
            })
        })
        .collect();
    let all: Vec<usize> = (0..names.len()).collect();
    let report = json!({
        "rows": fit.n_rows(),
        "rows_at_limit": 0,
        "rows_astray": 0,
        "features": names,
        "condition": fit.triangle().condition(&all),
        "noise": "NotEstimated",
        "noise_deviations": [],
        "noise_growing": [],
        "fit": [],
        "search_complete": true,
        "warnings": [],
        "equations": equations,
    });
    let doubts = vec![None::<String>; fit.equations().len()];
    json!({ "certainty": "doubted", "doubts": doubts, "report": report }).to_string()
}

/// Derivatives (T, n) of samples (T, n) every `dt` \[s\], by finite differences.
#[pyfunction]
pub(crate) fn differentiate<'py>(
    py: Python<'py>,
    x: PyReadonlyArray2<'py, f64>,
    dt: f64,
    order: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let finite = FiniteDifference::new(order).map_err(refused)?;
    Ok(finite.differentiate(x.as_array(), dt).map_err(refused)?.into_pyarray(py))
}

/// Samples (T, n) every `dt` \[s\], smoothed, and their derivatives.
#[pyfunction]
pub(crate) fn smoothed<'py>(
    py: Python<'py>,
    x: PyReadonlyArray2<'py, f64>,
    dt: f64,
    window: usize,
    degree: usize,
) -> PyResult<Pair<'py>> {
    let filter = SavitzkyGolay::new(window, degree).map_err(refused)?;
    let found = Differentiator::Smoothed(filter).differentiate(x.as_array(), dt).map_err(refused)?;
    Ok((found.x.into_pyarray(py), found.x_dot.into_pyarray(py)))
}

/// The terms (N, F) of a library at variables (N, m), states first, then `n_controls` inputs.
#[pyfunction]
pub(crate) fn features<'py>(
    py: Python<'py>,
    library: &str,
    z: PyReadonlyArray2<'py, f64>,
    n_controls: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let recipe: Recipe = serde_json::from_str(library).map_err(refused)?;
    let z = z.as_array();
    let names = symbols(z.ncols().saturating_sub(n_controls), n_controls);
    let terms = Library::from(recipe).terms(&names).map_err(refused)?;
    Ok(Array2::from_shape_fn((z.nrows(), terms.len()), |(i, j)| terms[j].expr.eval(&z.row(i).to_vec()))
        .into_pyarray(py))
}

/// Names of the terms of a library.
#[pyfunction]
pub(crate) fn feature_names(library: &str, n_states: usize, n_controls: usize) -> PyResult<Vec<String>> {
    let recipe: Recipe = serde_json::from_str(library).map_err(refused)?;
    let terms = Library::from(recipe).terms(&symbols(n_states, n_controls)).map_err(refused)?;
    Ok(terms.into_iter().map(|t| t.name).collect())
}
