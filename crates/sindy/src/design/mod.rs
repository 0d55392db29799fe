//! Rows of the regression of each equation: terms averaged over each step along a path, whitened.

mod path;
mod whiten;

pub(crate) use path::{LOBATTO, Path, averages};
pub(crate) use whiten::whiten;
