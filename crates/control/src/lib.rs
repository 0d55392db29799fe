//! Controllers nobody has to train.
//!
//! [`Linear`] is any [`Dynamics`](sindyna_core::Dynamics) near one point, [`regulate`] finds the gain that is best for it
//! under quadratic costs, and [`Lqr`] acts by that gain: a [`Policy`](sindyna_core::Policy) like every other, for the true
//! system and the learned one alike.
//!
//! [`Planner`] looks for the best controls in any dynamics and for any task, step by step: by differential dynamic programming, by
//! path integrals, or by the regulator of the state of rest that pays most.
//!
//! [`ByHand`] holds feedback laws that people wrote for the tasks: the marks of what is attainable.
//!
//! ```
//! use sindyna_control::ByHand;
//! use sindyna_core::{Mode, Policy as _, Seed};
//!
//! let law = ByHand::new("pendulum").expect("somebody has written one");
//! let mut action = [0.0];
//! // Upright and still: nothing is to be done.
//! law.act(&[1.0, 0.0, 0.0], Mode::Exploit, &mut Seed::new(0).stream("any", 0), &mut action);
//! assert!(action[0].abs() < 1e-9);
//! ```
//!
//! Not here: anything trained; any knowledge of a particular system but in `by_hand`.

mod by_hand;
mod error;
mod linear;
mod lqr;
mod matrix;
mod plan;
mod riccati;

pub use by_hand::ByHand;
pub use error::ControlError;
pub use linear::Linear;
pub use lqr::Lqr;
pub use plan::{Method, Planner, Planners, Rollout, improved};
pub use riccati::{Costs, Regulator, regulate};
