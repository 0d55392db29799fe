//! Dynamics kept inside the range its channels declare.

use crate::{Channel, Diverged, Dynamics, Jacobians, Rng};

/// Dynamics whose next state is clamped to the declared bounds of its channels.
///
/// A sensor that is declared to show no more than ±8 rad/s will not show more, whatever the equations say. What is
/// declared is known to the agent; a wall or an end stop inside the bounds is not, and has to be learned.
#[derive(Debug, Clone)]
pub struct Bounded<D> {
    dynamics: D,
    bounds: Vec<(f64, f64)>,
}

impl<D: Dynamics> Bounded<D> {
    /// Clamps `dynamics` to the bounds of the state `channels`.
    pub fn new(dynamics: D, channels: &[Channel]) -> Self {
        Self { dynamics, bounds: channels.iter().map(|c| c.prior.bounds).collect() }
    }
}

impl<D: Dynamics> Dynamics for Bounded<D> {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        self.dynamics.step(x, u, rng, next)?;
        for (value, &(low, high)) in next.iter_mut().zip(&self.bounds) {
            *value = value.clamp(low, high);
        }
        Ok(())
    }

    fn linearize(&self, x: &[f64], u: &[f64], rng: &mut Rng) -> Result<Jacobians, Diverged> {
        let (mut a, mut b) = self.dynamics.linearize(x, u, rng)?;
        let mut next = vec![0.0; x.len()];
        self.dynamics.step(x, u, rng, &mut next)?;
        // What stays at a limit does not depend on anything nearby.
        for (i, (value, (low, high))) in next.iter().zip(&self.bounds).enumerate() {
            if value < low || value > high {
                a.row_mut(i).fill(0.0);
                b.row_mut(i).fill(0.0);
            }
        }
        Ok((a, b))
    }
}
