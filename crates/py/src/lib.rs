//! The compiled part of the Python package `sindyna`: arrays in, models and accounts out.
//!
//! Every long call releases the interpreter's lock and asks for signals. Variables are called x0, x1, …, u0, u1, … here; the names people
//! gave their signals, and everything else about how the package looks, are Python's (`python/sindyna`).

mod export;
mod identify;
mod integrate;
mod interrupt;
mod learn;
mod library;
mod model;
mod pair;
mod regress;
mod samples;

use pyo3::prelude::pymodule;

/// The compiled part of `sindyna`.
#[pymodule]
mod _sindyna {
    #[pymodule_export]
    use crate::export::export;
    #[pymodule_export]
    use crate::identify::identify;
    #[pymodule_export]
    use crate::learn::{
        Batch, Data, Outcome, Policy, builtin, collect, learned, learned_builtin, learned_file, paid, states, train,
        train_file, written,
    };
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::regress::{Regression, differentiate, feature_names, features, regress, smoothed};
    #[pymodule_export]
    use crate::samples::{finite, increasing, interval};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
