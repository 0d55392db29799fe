//! Several joints: one Lagrangian, whose parameters are in the equations of all of them.
//!
//! Momenta are balanced over steps ([`balance`]), which is linear in the parameters; the fewest that nearly explain the steps are found by leaving one out after the
//! other ([`eliminated`]), and all of them are then fitted to the steps themselves ([`Fit`]), in which those that are not needed show.

mod balance;
mod elimination;
mod fit;
mod mechanism;
mod search;
mod weighing;

pub(crate) use balance::{Steps, balance};
pub(crate) use search::{Mechanics, mechanics};
pub(crate) use weighing::weighed;
