//! A damped pendulum on a motor.

use sindyna_core::{Channel, Kind, VectorField};

use super::set_up::SetUp;
use crate::system::System;

/// Acceleration of gravity over the pendulum's length of 1 m \[1/s²\].
const GRAVITY: f64 = 9.81;
/// Viscous damping over the inertia of 1 kg·m² \[1/s\].
const DAMPING: f64 = 0.2;
/// Largest torque either way \[N·m\]: too weak to lift the pendulum at one go.
const MAX_TORQUE: f64 = 5.0;

pub(super) fn system() -> System {
    let set_up = SetUp {
        name: "driven-pendulum",
        summary: "a damped pendulum on a motor, θ = 0 hanging",
        true_equations: &["θ̇ = ω", "ω̇ = −9.81 sin θ − 0.2 ω + u"],
        state: vec![Channel::new("θ", "rad", Kind::Angle, 1.0), Channel::new("ω", "rad/s", Kind::RateOf(0), 4.0)],
        control: vec![Channel::new("u", "N·m", Kind::Plain, MAX_TORQUE).within(-MAX_TORQUE, MAX_TORQUE)],
        start: vec![(-2.0, 2.0), (-2.0, 2.0)],
        dt: 0.05,
        substeps: 20,
    };
    set_up.system(DrivenPendulum)
}

/// A point of 1 kg on a rod of 1 m, θ = 0 hanging: ω̇ = −g/l sin θ − c ω + u / (m l²).
///
/// # References
/// Baker, Gollub (1996), *Chaotic Dynamics*, chapter 3: the pendulum, damped and driven.
#[derive(Clone, Copy)]
struct DrivenPendulum;

impl VectorField for DrivenPendulum {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot[0] = x[1];
        x_dot[1] = -GRAVITY * x[0].sin() - DAMPING * x[1] + u[0];
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::power;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn energy_comes_from_the_motor_and_goes_into_damping(angle in -7.0..7.0, w in -8.0..8.0, u in -5.0..5.0) {
            let energy = |[angle, w]: [f64; 2]| 0.5 * w * w - 9.81 * angle.cos();
            let gained = power(DrivenPendulum, energy, [angle, w], &[u]);
            prop_assert!((gained - (u * w - 0.2 * w * w)).abs() < 1e-6);
        }
    }
}
