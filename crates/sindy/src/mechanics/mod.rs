//! Several joints: one Lagrangian, whose parameters are in the equations of all of them.
//!
//! Momenta are balanced over steps ([`balance`]), which is linear in the parameters; the fewest that nearly explain the steps are found by leaving one out after the
//! other ([`eliminated`]), and all of them are then fitted to the steps themselves ([`Fit`]), in which those that are not needed show: to rounding ([`mechanics`]), or as hypotheses of
//! the estimator where there is noise ([`proposals`]), which is taken out of the regression first ([`compensated`]).

mod balance;
mod choice;
mod compensated;
mod elimination;
mod equations;
mod fit;
mod mechanism;
mod noisy;
mod search;
mod tied;
mod weighing;
mod windows;

pub(crate) use balance::{Steps, balance};
pub(crate) use equations::{Equations, condition};
pub(crate) use noisy::{Proposal, proposals};
pub(crate) use search::{Mechanics, mechanics};
pub(crate) use tied::{Tied, tied};
