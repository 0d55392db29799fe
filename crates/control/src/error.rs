//! Why there is no controller.

use sindyna_core::{Diverged, Unseen};

/// Why there is no controller.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// Matrices that do not fit each other.
    #[error("{what} is {got:?}, expected {expected:?}")]
    Shape {
        /// Which matrix or list.
        what: &'static str,
        /// Rows and columns wanted.
        expected: (usize, usize),
        /// Rows and columns found.
        got: (usize, usize),
    },
    /// A cost that is not a finite, positive number.
    #[error("the cost of {what} {index} is {value}, it must be finite and positive")]
    Cost {
        /// State or control.
        what: &'static str,
        /// Its number.
        index: usize,
        /// The cost.
        value: f64,
    },
    /// The dynamics have no linear form at the point asked for.
    #[error("the model cannot be linearised there")]
    NotLinear(#[from] Diverged),
    /// No gain keeps the system at rest.
    #[error(
        "no stabilising gain after {doublings} doublings: the controls do not reach every unstable part of this model"
    )]
    NotStabilisable {
        /// Doublings made.
        doublings: usize,
    },
    /// A state no observation shows.
    #[error(transparent)]
    Unseen(#[from] Unseen),
}
