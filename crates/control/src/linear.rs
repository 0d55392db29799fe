//! Dynamics near one point.

use ndarray::Array2;
use sindyna_core::{Diverged, Dynamics, Rng};

/// x⁺ − x₀ = A (x − x₀) + B (u − u₀): one control interval near an equilibrium (x₀, u₀).
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// A = ∂F/∂x (n, n).
    pub a: Array2<f64>,
    /// B = ∂F/∂u (n, k).
    pub b: Array2<f64>,
}

impl Linear {
    /// `dynamics` near the state `x` (n) under the control `u` (k): exact for identified equations, else by differences. `rng` is for stochastic
    /// systems, for which this is no more than a draw.
    ///
    /// That (x, u) is an equilibrium is the caller's claim: what F(x, u) − x is, is not part of the linear form.
    ///
    /// # Errors
    /// [`Diverged`] if a step near the point is not finite.
    pub fn around(dynamics: &dyn Dynamics, (x, u): (&[f64], &[f64]), rng: &mut Rng) -> Result<Self, Diverged> {
        let (a, b) = dynamics.linearize(x, u, rng)?;
        Ok(Self { a, b })
    }
}
