//! One regression of known or differenced derivatives, as PySINDy makes it.

use ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::Deserialize;
use serde_json::json;
use sindyna_core::Scheme;
use sindyna_sindy::{
    BestSubset, Columns, Differentiator, Finish, FiniteDifference, Library, SavitzkyGolay, Selected, Sindy, SindyFit,
    SolverChoice, Stlsq, Target, Trajectory, Triangle, Watch,
};

use crate::interrupt::apart;
use crate::library::{Recipe, symbols};
use crate::model::Model;
use crate::pair::Pair;

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
    dt: f64,
}

/// States, inputs and derivatives of one trajectory.
type Owned = (Array2<f64>, Array2<f64>, Option<Array2<f64>>);

/// The same as Python's.
type Rows<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>, Option<PyReadonlyArray2<'py, f64>>);

/// Regresses derivatives (T, n), or next states, on the terms of a library over states (T, n) and inputs (T, k).
#[pyfunction]
pub(crate) fn regress(py: Python<'_>, trajectories: Vec<Rows<'_>>, settings: &str) -> PyResult<(Model, Regression)> {
    let settings: Settings = serde_json::from_str(settings).map_err(refused)?;
    let target = if settings.discrete {
        Target::Discrete
    } else {
        let differentiator = Differentiator::default();
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
        let fit = sindy.fit_watched(&trajectories, settings.dt, &Watch::going_on(go_on));
        fit.map(|fit| {
            let SindyFit { names, targets, equations, triangle, model, .. } = fit;
            (Regression { names, n_rows: targets.nrows(), equations, triangle }, model)
        })
    };
    // Handing it to another thread would take longer than a small regression.
    let fit = if searches || n_values > FEW {
        apart(py, move |stop| fit(&|| !stop.is_set()))?
    } else {
        py.detach(|| fit(&|| true))
    };
    let (regression, model) = fit.map_err(refused)?;
    Ok((Model::new(model), regression))
}

/// What a regression found, from which standard errors and conditions are computed when somebody asks.
#[pyclass(frozen, module = "sindyna._sindyna")]
pub(crate) struct Regression {
    names: Vec<String>,
    n_rows: usize,
    equations: Vec<Selected>,
    triangle: Triangle,
}

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

    /// The account, in the form of that of an identification.
    fn account(&self) -> String {
        account(self)
    }
}

impl Regression {
    fn without(&self, good: impl Fn(&Selected) -> bool) -> Vec<usize> {
        (0..self.equations.len()).filter(|&i| !good(&self.equations[i])).collect()
    }
}

fn account(fit: &Regression) -> String {
    let n_features = fit.names.len();
    let equations: Vec<_> = fit
        .equations
        .iter()
        .enumerate()
        .map(|(i, e)| {
            let errors: Vec<f64> = fit.triangle.spread(&e.support).into_iter().map(|s| s * e.residual).collect();
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
    let all: Vec<usize> = (0..n_features).collect();
    let report = json!({
        "rows": fit.n_rows,
        "rows_at_limit": 0,
        "rows_astray": 0,
        "features": fit.names,
        "condition": fit.triangle.condition(&all),
        "noise": "NotEstimated",
        "noise_deviations": [],
        "noise_growing": [],
        "fit": [],
        "search_complete": true,
        "warnings": [],
        "equations": equations,
    });
    let doubts = vec![None::<String>; fit.equations.len()];
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
