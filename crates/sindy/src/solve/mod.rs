//! Sparse regressions, all of them on a [`Triangle`](crate::Triangle).

mod best_subset;
mod candidates;
mod constraints;
mod criterion;
mod exchange;
mod grouped;
mod least_squares;
mod path;
mod prepare;
mod problem;
mod reflect;
mod stlsq;
mod tree;

pub(crate) use best_subset::Candidates;
pub use best_subset::{BestSubset, Selected, Selection, SizeReport};
pub(crate) use candidates::binomial;
pub use constraints::{ConstraintError, Constraints};
pub(crate) use criterion::FLOOR_FACTOR;
pub(crate) use least_squares::{least_squares, truncated};
pub use path::{Path, SizeResult, Subset, SubsetPath};
pub(crate) use reflect::Reflected;
pub use stlsq::{Columns, Finish, SparseFit, Stlsq};
pub use tree::Bound;
