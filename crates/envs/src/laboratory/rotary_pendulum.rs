//! Furuta's pendulum: a pole on the end of an arm that a motor turns about a vertical axis.

use sindyna_core::{Channel, Kind, VectorField};

use super::set_up::SetUp;
use crate::system::System;

/// Acceleration of gravity \[m/s²\].
const GRAVITY: f64 = 9.81;
/// Mass of the arm, a uniform rod \[g\].
const ARM_MASS: f64 = 95.0;
/// Length of the arm \[m\].
const ARM_LENGTH: f64 = 0.085;
/// Mass of the pole, a uniform rod \[g\].
const POLE_MASS: f64 = 24.0;
/// Length of the pole \[m\].
const POLE_LENGTH: f64 = 0.129;
/// Viscous friction of the arm \[mN·m·s/rad\].
const ARM_FRICTION: f64 = 1.5;
/// Viscous friction of the pole \[mN·m·s/rad\].
const POLE_FRICTION: f64 = 0.5;
/// Largest torque either way \[mN·m\].
const MAX_TORQUE: f64 = 50.0;

/// J₁ = M r²/3 + m r²: the arm and, as a point on its end, the pole \[g·m²\].
const ARM_INERTIA: f64 = (ARM_MASS / 3.0 + POLE_MASS) * ARM_LENGTH * ARM_LENGTH;
/// J₂ = m L²/3: the pole about the end of the arm \[g·m²\].
const POLE_INERTIA: f64 = POLE_MASS * POLE_LENGTH * POLE_LENGTH / 3.0;
/// K = m r L/2 \[g·m²\].
const COUPLING: f64 = POLE_MASS * ARM_LENGTH * POLE_LENGTH / 2.0;
/// G = m g L/2 \[mN·m\].
const WEIGHT: f64 = POLE_MASS * GRAVITY * POLE_LENGTH / 2.0;

pub(super) fn system() -> System {
    let set_up = SetUp {
        name: "rotary-pendulum",
        summary: "Furuta's pendulum: a pole on the end of a motor-driven arm, θ = 0 upright",
        true_equations: &[
            "φ̇ = Ω",
            "θ̇ = ω",
            "(0.402192 + 0.133128 sin² θ) Ω̇ + 0.13158 cos θ ω̇ = \
             u − 1.5 Ω − 0.266256 sin θ cos θ Ω ω + 0.13158 sin θ ω²",
            "0.13158 cos θ Ω̇ + 0.133128 ω̇ = 15.1859 sin θ − 0.5 ω + 0.133128 sin θ cos θ Ω²",
        ],
        state: vec![
            Channel::new("φ", "rad", Kind::Angle, 1.0),
            Channel::new("θ", "rad", Kind::Angle, 1.0),
            Channel::new("Ω", "rad/s", Kind::RateOf(0), 10.0),
            Channel::new("ω", "rad/s", Kind::RateOf(1), 10.0),
        ],
        control: vec![Channel::new("u", "mN·m", Kind::Plain, MAX_TORQUE).within(-MAX_TORQUE, MAX_TORQUE)],
        start: vec![(-1.0, 1.0), (-3.0, 3.0), (-2.0, 2.0), (-2.0, 2.0)],
        dt: 0.01,
        substeps: 40,
    };
    set_up.system(RotaryPendulum)
}

/// φ the turn of the arm, θ that of the pole, 0 upright; torques in mN·m and inertias in g·m²:
///
/// - (J₁ + J₂ sin² θ) Ω̇ + K cos θ ω̇ = u − b₁ Ω − 2 J₂ sin θ cos θ Ω ω + K sin θ ω²,
/// - K cos θ Ω̇ + J₂ ω̇ = G sin θ − b₂ ω + J₂ sin θ cos θ Ω².
///
/// # References
/// Furuta, Yamakita, Kobayashi (1992), Proceedings IMechE 206(4). Cazzolato, Prime (2011), Journal of Control Science and
/// Engineering, doi:10.1155/2011/528341 (equations of motion). Masses and lengths are those of Quanser's Qube-Servo 2; friction
/// is ours, of the size that is published for it.
#[derive(Clone, Copy)]
struct RotaryPendulum;

impl VectorField for RotaryPendulum {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (arm, pole) = (x[2], x[3]);
        let (sin, cos) = x[1].sin_cos();
        let turning =
            u[0] - ARM_FRICTION * arm - 2.0 * POLE_INERTIA * sin * cos * arm * pole + COUPLING * sin * pole * pole;
        let falling = WEIGHT * sin - POLE_FRICTION * pole + POLE_INERTIA * sin * cos * arm * arm;
        let (inertia, coupling) = (ARM_INERTIA + POLE_INERTIA * sin * sin, COUPLING * cos);
        let determinant = inertia * POLE_INERTIA - coupling * coupling;
        x_dot[0] = arm;
        x_dot[1] = pole;
        x_dot[2] = (POLE_INERTIA * turning - coupling * falling) / determinant;
        x_dot[3] = (inertia * falling - coupling * turning) / determinant;
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::{power, rates};
    use super::*;
    use proptest::prelude::*;

    /// The pole as 3 points, (1/6, 4/6, 1/6) of its mass at its ends and its middle, which have its mass, centre and
    /// inertia (Simpson's rule is exact for squares); each moves along the arm's circle, inwards and upwards.
    fn energy([_, angle, arm, pole]: [f64; 4]) -> f64 {
        let point = |along: f64, share: f64| {
            let s = along * POLE_LENGTH;
            let around = ARM_LENGTH * arm + s * angle.cos() * pole;
            let (inwards, up) = (s * angle.sin() * arm, -s * angle.sin() * pole);
            let square = around * around + inwards * inwards + up * up;
            share * POLE_MASS * (0.5 * square + GRAVITY * s * angle.cos())
        };
        let own = ARM_MASS * ARM_LENGTH * ARM_LENGTH / 6.0 * arm * arm;
        own + point(0.0, 1.0 / 6.0) + point(0.5, 4.0 / 6.0) + point(1.0, 1.0 / 6.0)
    }

    proptest! {
        #[test]
        fn energy_comes_from_the_motor_and_goes_into_friction(
            angle in -7.0..7.0, (arm, pole) in (-20.0..20.0, -20.0..20.0), u in -50.0..50.0
        ) {
            let gained = power(RotaryPendulum, energy, [0.3, angle, arm, pole], &[u]);
            let expected = u * arm - 1.5 * arm * arm - 0.5 * pole * pole;
            prop_assert!((gained - expected).abs() < 1e-2, "{gained} is not {expected}");
        }

        #[test]
        fn the_printed_equations_hold_to_their_six_digits(
            angle in -7.0_f64..7.0, (arm, pole) in (-20.0..20.0, -20.0..20.0), u in -50.0..50.0
        ) {
            let [_, _, a, b] = rates(RotaryPendulum, [0.3, angle, arm, pole], &[u]);
            let (sin, cos) = angle.sin_cos();
            let first = (0.402192 + 0.133128 * sin * sin) * a + 0.13158 * cos * b
                - (u - 1.5 * arm - 0.266256 * sin * cos * arm * pole + 0.13158 * sin * pole * pole);
            let second = 0.13158 * cos * a + 0.133128 * b
                - (15.1859 * sin - 0.5 * pole + 0.133128 * sin * cos * arm * arm);
            // Every coefficient is off by half of its last digit.
            let size = 1.0 + a.abs() + b.abs() + u.abs() + arm * arm + pole * pole;
            prop_assert!(first.abs() < 2e-6 * size && second.abs() < 2e-6 * size, "{first}, {second} of {size}");
        }
    }
}
