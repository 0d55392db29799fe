//! What the studies share: data from the true systems, and what an identification is worth.
//!
//! The programs print one JSON line per run; `scripts/` runs them and writes tables and figures. `exact` and `noise` take the
//! systems of [`sindyna_envs`] and know no term or coefficient of any: what is true is asked of [`sindyna_truth`]. `undeclared` and
//! `odebench` take systems of their own and know a method only by [`method::identify`].

pub mod child;
mod equations;
mod log;
mod measure;
pub mod method;
pub mod odebench;
mod points;
mod rival;
pub mod undeclared;
mod warm_up;

pub use equations::{Equations, NotASummand, Term, summands};
pub use log::{Log, Role, Trajectory};
pub use measure::{Measured, measure};
pub use points::{Points, Structure};
pub use rival::{Rivals, rivals};
pub use warm_up::{system, warm_up};
