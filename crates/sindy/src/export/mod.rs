//! Models as programs in other languages.
//!
//! [`System`] is all an exporter has to know of a model; each language is one function over it. Not here: files.

mod expression;
mod friction;
mod identifiers;
mod python;
mod system;

pub use crate::model::Joint;
pub use python::python;
pub use system::{Friction, Stepping, System};
