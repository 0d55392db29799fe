//! What the studies share: data from the true systems, and how far from the truth a model is.
//!
//! The programs (`exact`, `noise`) print one JSON line per seed; `scripts/` runs them and writes tables and figures.
//! Nothing here knows a term or a coefficient of any system: what is true is asked of [`sindyna_envs::System::rates`].

mod measure;
mod rival;
mod structure;
mod truth;
mod warm_up;

pub use measure::{Measured, measure};
pub use rival::{Rivals, rivals};
pub use structure::{Structure, structure};
pub use truth::{Deviation, Truth};
pub use warm_up::{system, warm_up};
