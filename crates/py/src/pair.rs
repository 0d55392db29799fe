//! Two arrays for Python.

use numpy::PyArray2;
use pyo3::Bound;

/// Two matrices.
pub(crate) type Pair<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);
