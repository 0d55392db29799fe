//! What the studies share: data from the true systems, and what an identification is worth.
//!
//! The programs (`exact`, `noise`) print one JSON line per seed; `scripts/` runs them and writes tables and figures.
//! Nothing here knows a term or a coefficient of any system: what is true is asked of [`sindyna_truth`].

mod measure;
mod rival;
mod warm_up;

pub use measure::{Measured, measure};
pub use rival::{Rivals, rivals};
pub use warm_up::{system, warm_up};
