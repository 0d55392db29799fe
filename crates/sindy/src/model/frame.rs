//! Between the task's state and the space a model lives in.

use serde::{Deserialize, Serialize};
use sindyna_core::turning::unwrapped;

/// How one state of a model in observation space follows from the task's state x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reading {
    /// x itself at this position.
    Direct(usize),
    /// The cosine of x at this position.
    Cosine(usize),
    /// The sine of x at this position.
    Sine(usize),
}

impl Reading {
    pub(crate) fn index(self) -> usize {
        match self {
            Self::Direct(i) | Self::Cosine(i) | Self::Sine(i) => i,
        }
    }

    /// The reading of x.
    pub(crate) fn of(self, x: &[f64]) -> f64 {
        match self {
            Self::Direct(i) => x[i],
            Self::Cosine(i) => x[i].cos(),
            Self::Sine(i) => x[i].sin(),
        }
    }
}

/// Writes the state `next` whose readings are `z`; angles are taken as near to `x` as whole turns allow.
///
/// A cosine without its sine (or the reverse) leaves the angle as it is in `x`.
pub(crate) fn back(readings: &[Reading], z: &[f64], x: &[f64], next: &mut [f64]) {
    next.copy_from_slice(x);
    for (reading, &value) in readings.iter().zip(z) {
        match *reading {
            Reading::Direct(i) => next[i] = value,
            Reading::Cosine(i) => {
                if let Some(at) = readings.iter().position(|r| *r == Reading::Sine(i)) {
                    next[i] = unwrapped(z[at].atan2(value), x[i]);
                }
            }
            Reading::Sine(_) => {}
        }
    }
}
