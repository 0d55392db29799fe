//! Derivatives of sampled trajectories. Nothing here ever crosses the border of a rollout.

mod finite;
mod smooth;

use ndarray::{Array2, ArrayView2};

pub use finite::{FiniteDifference, TooShort};
pub use smooth::SavitzkyGolay;

/// How ẋ is estimated from samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Differentiator {
    /// Finite differences.
    Finite(FiniteDifference),
    /// Savitzky–Golay smoothing, then central differences of order 2; the library sees the smoothed samples.
    Smoothed(SavitzkyGolay),
}

impl Default for Differentiator {
    fn default() -> Self {
        Self::Finite(FiniteDifference::default())
    }
}

/// What a differentiator makes of one trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Differentiated {
    /// The samples the library is to see (T, n).
    pub x: Array2<f64>,
    /// Their derivative (T, n).
    pub x_dot: Array2<f64>,
}

impl Differentiator {
    /// Differentiates one trajectory `x` (T, n) of samples `dt` \[s\] apart.
    ///
    /// # Errors
    /// [`TooShort`] if there are too few samples.
    pub fn differentiate(&self, x: ArrayView2<'_, f64>, dt: f64) -> Result<Differentiated, TooShort> {
        match self {
            Self::Finite(scheme) => Ok(Differentiated { x: x.to_owned(), x_dot: scheme.differentiate(x, dt)? }),
            Self::Smoothed(filter) => {
                let x = filter.smooth(x)?;
                let x_dot = FiniteDifference::default().differentiate(x.view(), dt)?;
                Ok(Differentiated { x, x_dot })
            }
        }
    }
}
