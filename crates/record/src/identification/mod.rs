//! What was identified, and how far to believe it.

mod account;
mod equation;
mod held_out;
mod model;
mod prediction;
mod quality;
mod stepping;

pub use account::{Account, NoiseSource, Offset, StateNoise};
pub use equation::{Equation, InsideTerm, SubsetOfSize, Summand};
pub use held_out::{FreeRun, HeldOut};
pub use model::{ModelFileError, read_model};
pub use prediction::{PredictionRow, PredictionTable};
pub use quality::{Quality, StateQuality};
pub use stepping::Stepping;
