//! Controllers thought out by people who know the system: what is attainable without learning.

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{Mode, Policy, Rng};

/// A feedback law for one of the tasks, written by hand with full knowledge of its equations.
///
/// Acts alike in both modes. The bounds of the action space clip what a law asks for.
#[derive(Debug, Clone, Copy)]
pub struct ByHand {
    law: fn(&[f64]) -> f64,
}

impl ByHand {
    /// The controller for the task called `task`; `None` where nobody has written one.
    #[must_use]
    pub fn new(task: &str) -> Option<Self> {
        let law = match task {
            "cart-pole" => cart_pole,
            "inverted-pendulum" => inverted_pendulum,
            "mountain-car" => mountain_car,
            "pendulum" => pendulum,
            _ => return None,
        };
        Some(Self { law })
    }
}

impl Policy for ByHand {
    fn act_batch(
        &self,
        observations: ArrayView2<'_, f64>,
        _mode: Mode,
        _rng: &mut Rng,
        mut actions: ArrayViewMut2<'_, f64>,
    ) {
        let mut row = vec![0.0; observations.ncols()];
        for (o, mut action) in observations.rows().into_iter().zip(actions.rows_mut()) {
            row.iter_mut().zip(o).for_each(|(slot, value)| *slot = *value);
            action[0] = (self.law)(&row);
        }
    }
}

/// Pushes to the side the pole falls to, leaning a little against a cart that runs away. Observed are x, v, θ, ω.
fn cart_pole(o: &[f64]) -> f64 {
    f64::from(u8::from(0.1 * o[0] + 0.25 * o[1] + 5.0 * o[2] + 1.2 * o[3] > 0.0))
}

/// Proportional and derivative feedback of all four states, the pole's tilt of 1/600 rad taken off. Observed are x, θ, v, ω.
fn inverted_pendulum(o: &[f64]) -> f64 {
    (0.5 * o[0] + 5.0 * (o[1] + 1.0 / 600.0) + 0.6 * o[2] + o[3]).clamp(-3.0, 3.0)
}

/// Pumps energy: pushes gently the way the car moves. Observed are x, v.
fn mountain_car(o: &[f64]) -> f64 {
    0.4 * 1_f64.copysign(o[1])
}

/// Brings the energy ½ω² + 15 (cos θ − 1) to that of the upright rest, and holds the pendulum there once it is near. Observed
/// are cos θ, sin θ, ω.
///
/// # References
/// Åström, Furuta (2000), Automatica 36(2), swinging up a pendulum by energy control.
fn pendulum(o: &[f64]) -> f64 {
    let (angle, rate) = (o[1].atan2(o[0]), o[2]);
    let energy = 0.5 * rate * rate + 15.0 * (o[0] - 1.0);
    let near = angle.abs() < 0.6 && (12.0 * angle + 3.5 * rate).abs() < 6.0;
    let u = if near { -(12.0 * angle + 3.5 * rate) } else { -energy * 1_f64.copysign(rate) };
    u.clamp(-2.0, 2.0)
}
