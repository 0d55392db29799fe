//! Equations and policies as programs in other languages.

use pyo3::prelude::*;
use sindyna::export::{Names, program};

use crate::learn::Policy;
use crate::model::Model;

/// `model`, and the `policy` trained in it, as a program in a language; names of states, inputs and observed values stand in its comments.
#[pyfunction]
#[pyo3(signature = (model, policy, names, language))]
pub(crate) fn export(
    model: &Model,
    policy: Option<&Policy>,
    names: (Vec<String>, Vec<String>, Vec<String>),
    language: &str,
) -> PyResult<String> {
    let (states, controls, observed) = names;
    let names = Names { states, controls, observed };
    program(model.inner(), policy.map(Policy::inner), names, language)
        .map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))
}
