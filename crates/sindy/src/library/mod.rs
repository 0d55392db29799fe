//! Candidate terms Θ: what an equation may be made of.

mod auto;
mod build;
mod complexity;
mod general;
mod lagrangian;
mod mechanical;
mod paper;
mod quotients;
mod role;
mod shape;
mod shaped;

pub(crate) use auto::auto;
pub use build::{Library, LibraryError};
pub(crate) use complexity::complexity;
pub(crate) use general::general;
pub(crate) use lagrangian::{Joints, Key, Lagrangian};
pub(crate) use mechanical::{Tiers, mechanical, term};
pub(crate) use paper::{paper, paper_degree2};
pub(crate) use quotients::{divisor, quotients};
pub use role::{Input, Role};
pub(crate) use shape::Shape;
pub(crate) use shaped::{Extent, shaped};

use crate::expr::Expr;
use serde::{Deserialize, Serialize};

/// One candidate term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// The term as a function of z = (x; u).
    pub expr: Expr,
    /// Its name in PySINDy's notation, such as `x0^2` or `sin(1 x0)`.
    pub name: String,
    /// How far-fetched it is: among equally good equations the one with the smaller sum is chosen.
    pub complexity: u32,
    /// The state whose derivative the term is multiplied by, if any.
    pub rate: Option<usize>,
    /// Its parameters, if it has any inside; `expr` is the term with the values at which fits start.
    pub(crate) shape: Option<Shape>,
}
