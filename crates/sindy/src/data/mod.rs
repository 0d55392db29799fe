//! Recorded trajectories, their noise, and the signals behind it.

mod differences;
mod filter;
mod glitches;
mod segment;
mod smoother;
mod stretches;
mod variance;

pub use filter::LONGEST_CHAIN;
pub(crate) use glitches::without_glitches;
pub(crate) use segment::{Ramp, Segment, measures};
pub(crate) use smoother::{Signals, Smoother};
pub(crate) use stretches::{sample_of, stretches};
pub(crate) use variance::with_variances;
