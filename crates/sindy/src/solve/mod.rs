//! Sparse regressions, all of them on a [`Triangle`](crate::Triangle).

mod best_subset;
mod criterion;
mod least_squares;
mod search;
mod stlsq;

pub use best_subset::{BestSubset, Selected, Selection, SizeReport};
pub(crate) use least_squares::{least_squares, truncated};
pub(crate) use search::binomial;
pub use stlsq::{Columns, Finish, SparseFit, Stlsq};
