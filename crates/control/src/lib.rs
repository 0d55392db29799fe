//! Controllers nobody has to train.
//!
//! [`Linear`] is any [`Dynamics`](sindyna_core::Dynamics) near one point, [`regulate`] finds the gain that is best for it
//! under quadratic costs, and [`Lqr`] acts by that gain: a [`Policy`](sindyna_core::Policy) like every other, for the true
//! system and the learned one alike.
//!
//! Not here: anything trained, any reward, any knowledge of a particular system.

mod error;
mod linear;
mod lqr;
mod matrix;
mod riccati;

pub use error::ControlError;
pub use linear::Linear;
pub use lqr::Lqr;
pub use riccati::{Costs, Regulator, regulate};
