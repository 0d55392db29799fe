//! What the studies share: data from the true systems, what an identification is worth, and how results become files.
//!
//! Each program in `src/bin` is a study: it measures, writes `results/NAME.json` and makes its page of it ([`study`]). `exact` and `noise` take the
//! systems of [`sindyna_envs`] and know no term or coefficient of any: what is true is asked of [`sindyna_truth`]. `undeclared`, `coverage` and
//! `odebench` take systems of their own and know a method only by [`method::identify`]. The others run the command `sindyna`.

pub mod child;
mod equations;
mod log;
mod measure;
pub mod method;
pub mod odebench;
mod points;
mod rival;
pub mod study;
pub mod undeclared;
mod warm_up;

pub use equations::{Equations, NotASummand, Term, summands};
pub use log::{Log, Role, Trajectory};
pub use measure::{Measured, Off, measure};
pub use points::{Points, Structure};
pub use rival::{Rivals, rivals};
pub use warm_up::{system, warm_up};
