//! Equations of motion from little data, and controllers trained in them.
//!
//! - [`identify`]: equations from arrays or from a log ([`logs`]);
//! - [`training`]: a controller for a built-in task or for your own system ([`problem`]);
//! - [`export`]: equations and policies as programs in other languages;
//! - [`record`], [`report`]: files of runs, pages of runs and comparisons;
//! - [`core`], [`control`], [`rl`], [`dyna`], [`sindy`]: the parts, for other combinations.
//!
//! ```
//! use sindyna::identify::{Recording, Signals, arrays};
//! use sindyna::ndarray::Array2;
//!
//! // A decay, ẋ = −2 x, sampled every 0.01 s.
//! let x = Array2::from_shape_fn((200, 1), |(i, _)| (-2.0 * 0.01 * i as f64).exp());
//! let found = arrays(&Signals::new(&["x"], &[]), 0.01, &[Recording::even(0.01, x, None)])?;
//! assert_eq!(found.equations(), ["x\u{307} = −2 x"]);
//! # Ok::<(), sindyna::Error>(())
//! ```
//!
//! The command `sindyna` uses the same parts; `examples/` has a program for each of them.

mod cli;
pub mod identify;

pub use cli::main;
pub use sindyna_training::{Error, Trained, Training, Verdict, problem::Problem};

/// Systems with a task: what a controller can be trained for.
pub mod problem {
    pub use crate::identify::of_log;
    pub use sindyna_training::problem::{
        FormulaTask, Names, OwnSystem, OwnTask, Plant, PlantError, Problem, Start, TaskBuilder,
    };
    pub use sindyna_training::problem::{declared, named, names, ode, of_file, of_model, stepped};
}

/// Training a controller in identified equations.
pub mod training {
    pub use sindyna_training::{Trained, Training, Verdict};
}

/// Equations and policies as programs in other languages.
pub mod export {
    pub use sindyna_export::{Contents, ExportError, Names, Written, program};
}

#[doc(no_inline)]
pub use {
    ndarray, sindyna_control as control, sindyna_core as core, sindyna_dyna as dyna, sindyna_logs as logs,
    sindyna_record as record, sindyna_report as report, sindyna_rl as rl, sindyna_sindy as sindy,
};

/// The examples of the pages, compiled.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
#[doc = include_str!("../../../docs/logs.md")]
struct Pages;
