//! Dynamics near one point.

use ndarray::Array2;
use sindyna_core::{Diverged, Dynamics, Rng, Spec};

/// Step of the differences, as part of a channel's scale: their own error is then about 1e-8, that of rounding 1e-12.
const STEP: f64 = 1e-4;

/// x⁺ − x₀ = A (x − x₀) + B (u − u₀): one control interval near an equilibrium (x₀, u₀).
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// A = ∂F/∂x (n, n).
    pub a: Array2<f64>,
    /// B = ∂F/∂u (n, k).
    pub b: Array2<f64>,
}

impl Linear {
    /// `dynamics` near the state `x` (n) under the control `u` (k), by central differences of one step. Channels of
    /// `spec` say how far a small distance is; `rng` is for stochastic systems, for which this is no more than a draw.
    ///
    /// That (x, u) is an equilibrium is the caller's claim: what F(x, u) − x is, is not part of the linear form.
    ///
    /// # Errors
    /// [`Diverged`] if a step near the point is not finite.
    pub fn around(
        dynamics: &dyn Dynamics,
        spec: &Spec,
        (x, u): (&[f64], &[f64]),
        rng: &mut Rng,
    ) -> Result<Self, Diverged> {
        let (n, k) = (x.len(), u.len());
        let mut linear = Self { a: Array2::zeros((n, n)), b: Array2::zeros((n, k)) };
        let mut z = [x, u].concat();
        let (mut ahead, mut behind) = (vec![0.0; n], vec![0.0; n]);
        for (j, channel) in spec.state.iter().chain(&spec.control).enumerate() {
            let (middle, h) = (z[j], STEP * channel.scale);
            z[j] = middle + h;
            dynamics.step(&z[..n], &z[n..], rng, &mut ahead)?;
            z[j] = middle - h;
            dynamics.step(&z[..n], &z[n..], rng, &mut behind)?;
            z[j] = middle;
            let mut column = if j < n { linear.a.column_mut(j) } else { linear.b.column_mut(j - n) };
            for (slope, (ahead, behind)) in column.iter_mut().zip(ahead.iter().zip(&behind)) {
                *slope = (ahead - behind) / (2.0 * h);
            }
        }
        Ok(linear)
    }
}
