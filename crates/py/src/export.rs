//! Equations and policies as programs in other languages.

use pyo3::prelude::*;
use sindyna::export::{Contents, Names, program};

use crate::learn::Policy;
use crate::model::Model;

/// A file, and one for the policy where it cannot be in the same.
type Exported = (File, Option<Vec<u8>>);

/// Text, or bytes.
#[derive(IntoPyObject)]
pub(crate) enum File {
    Text(String),
    Bytes(Vec<u8>),
}

/// `model`, and the `policy` trained in it, as a program in a language; names of states, inputs and observed values stand in its comments.
#[pyfunction]
#[pyo3(signature = (model, policy, names, language))]
pub(crate) fn export(
    model: &Model,
    policy: Option<&Policy>,
    names: (Vec<String>, Vec<String>, Vec<String>),
    language: &str,
) -> PyResult<Exported> {
    let (states, controls, observed) = names;
    let names = Names { states, controls, observed };
    let written = program(model.inner(), policy.map(Policy::inner), names, language)
        .map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))?;
    let file = match written.contents {
        Contents::Text(text) => File::Text(text),
        Contents::Bytes(bytes) => File::Bytes(bytes),
    };
    Ok((file, written.policy))
}
