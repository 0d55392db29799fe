//! A robot arm of two links in a vertical plane.

use sindyna_core::{Channel, Kind, VectorField};

use super::set_up::SetUp;
use crate::system::System;

/// Acceleration of gravity \[m/s²\].
const GRAVITY: f64 = 9.81;
/// Masses of the links, uniform rods \[kg\].
const MASSES: [f64; 2] = [1.2, 0.6];
/// Their lengths \[m\].
const LENGTHS: [f64; 2] = [0.4, 0.3];
/// Viscous friction of shoulder and elbow \[N·m·s/rad\].
const FRICTION: [f64; 2] = [0.05, 0.02];
/// Largest torques either way \[N·m\].
const MAX_TORQUES: [f64; 2] = [6.0, 1.5];

/// a₁ = m₁ l₁²/3 + m₂ l₁²: both links about the shoulder, the second as a point in the elbow \[kg·m²\].
const SHOULDER: f64 = (MASSES[0] / 3.0 + MASSES[1]) * LENGTHS[0] * LENGTHS[0];
/// a₂ = m₂ l₂²/3: the second link about the elbow \[kg·m²\].
const ELBOW: f64 = MASSES[1] * LENGTHS[1] * LENGTHS[1] / 3.0;
/// a₃ = m₂ l₁ l₂/2: what couples them \[kg·m²\].
const COUPLING: f64 = MASSES[1] * LENGTHS[0] * LENGTHS[1] / 2.0;
/// Weight on shoulder and elbow: (m₁/2 + m₂) g l₁ and m₂ g l₂/2 \[N·m\].
const WEIGHTS: [f64; 2] =
    [(MASSES[0] / 2.0 + MASSES[1]) * GRAVITY * LENGTHS[0], MASSES[1] * GRAVITY * LENGTHS[1] / 2.0];

pub(super) fn system() -> System {
    let torque = |name: &str, most: f64| Channel::new(name, "N·m", Kind::Plain, most).within(-most, most);
    let set_up = SetUp {
        name: "two-link-arm",
        summary: "a robot arm of two links in a vertical plane, θ1 = 0 hanging, θ2 of the elbow, with two motors",
        true_equations: &[
            "θ̇1 = ω1",
            "θ̇2 = ω2",
            "(0.178 + 0.072 cos θ2) ω̇1 + (0.018 + 0.036 cos θ2) ω̇2 = \
             τ1 − 0.05 ω1 + 0.036 sin θ2 (2 ω1 ω2 + ω2²) − 4.7088 sin θ1 − 0.8829 sin(θ1 + θ2)",
            "(0.018 + 0.036 cos θ2) ω̇1 + 0.018 ω̇2 = τ2 − 0.02 ω2 − 0.036 sin θ2 ω1² − 0.8829 sin(θ1 + θ2)",
        ],
        state: vec![
            Channel::new("θ1", "rad", Kind::Angle, 1.0),
            Channel::new("θ2", "rad", Kind::Angle, 1.0),
            Channel::new("ω1", "rad/s", Kind::RateOf(0), 5.0),
            Channel::new("ω2", "rad/s", Kind::RateOf(1), 10.0),
        ],
        control: vec![torque("τ1", MAX_TORQUES[0]), torque("τ2", MAX_TORQUES[1])],
        start: vec![(-1.5, 1.5), (-1.5, 1.5), (-1.0, 1.0), (-1.0, 1.0)],
        dt: 0.02,
        substeps: 150,
    };
    set_up.system(TwoLinkArm)
}

/// M(θ₂) ω̇ = τ − friction − Coriolis − weight, θ₁ from hanging, θ₂ from the first link, with
///
/// - M = ((a₁ + a₂ + 2 a₃ cos θ₂, a₂ + a₃ cos θ₂), (a₂ + a₃ cos θ₂, a₂)),
/// - Coriolis = a₃ sin θ₂ (−2 ω₁ ω₂ − ω₂², ω₁²),
/// - weight = (g₁ sin θ₁ + g₂ sin(θ₁ + θ₂), g₂ sin(θ₁ + θ₂)).
///
/// # References
/// Spong, Hutchinson, Vidyasagar (2006), *Robot Modeling and Control*, §7.4, the planar elbow manipulator (there with
/// θ₁ = 0 level and no friction). Masses and lengths are ours.
#[derive(Clone, Copy)]
struct TwoLinkArm;

impl VectorField for TwoLinkArm {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (shoulder, elbow) = (x[2], x[3]);
        let (sin, cos) = x[1].sin_cos();
        let (upper, lower) = (WEIGHTS[0] * x[0].sin(), WEIGHTS[1] * (x[0] + x[1]).sin());
        let torques = [
            u[0] - FRICTION[0] * shoulder + COUPLING * sin * elbow * (2.0 * shoulder + elbow) - upper - lower,
            u[1] - FRICTION[1] * elbow - COUPLING * sin * shoulder * shoulder - lower,
        ];
        let (both, mixed) = (SHOULDER + ELBOW + 2.0 * COUPLING * cos, ELBOW + COUPLING * cos);
        let determinant = both * ELBOW - mixed * mixed;
        x_dot[0] = shoulder;
        x_dot[1] = elbow;
        x_dot[2] = (ELBOW * torques[0] - mixed * torques[1]) / determinant;
        x_dot[3] = (both * torques[1] - mixed * torques[0]) / determinant;
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::{power, rates};
    use super::*;
    use proptest::prelude::*;

    /// From positions and velocities of the rods' centres, in x to the side and y upwards: nothing of it is shared with
    /// the equations of motion.
    fn energy([t1, t2, w1, w2]: [f64; 4]) -> f64 {
        let (l1, l2, w) = (LENGTHS[0], LENGTHS[1], w1 + w2);
        let centre_1 = (0.5 * l1 * w1).powi(2);
        let side = l1 * t1.cos() * w1 + 0.5 * l2 * (t1 + t2).cos() * w;
        let rise = l1 * t1.sin() * w1 + 0.5 * l2 * (t1 + t2).sin() * w;
        let spin = MASSES[0] * l1 * l1 / 12.0 * w1 * w1 + MASSES[1] * l2 * l2 / 12.0 * w * w;
        let heights = [-0.5 * l1 * t1.cos(), -l1 * t1.cos() - 0.5 * l2 * (t1 + t2).cos()];
        0.5 * (MASSES[0] * centre_1 + MASSES[1] * (side * side + rise * rise) + spin)
            + GRAVITY * (MASSES[0] * heights[0] + MASSES[1] * heights[1])
    }

    proptest! {
        #[test]
        fn energy_comes_from_the_motors_and_goes_into_friction(
            (t1, t2) in (-4.0..4.0, -4.0..4.0), (w1, w2) in (-5.0..5.0, -10.0..10.0), (a, b) in (-6.0..6.0, -1.5..1.5)
        ) {
            let gained = power(TwoLinkArm, energy, [t1, t2, w1, w2], &[a, b]);
            let expected = a * w1 + b * w2 - 0.05 * w1 * w1 - 0.02 * w2 * w2;
            prop_assert!((gained - expected).abs() < 1e-4, "{gained} is not {expected}");
        }

        #[test]
        fn the_printed_equations_hold(
            (t1, t2) in (-4.0_f64..4.0, -4.0_f64..4.0), (w1, w2) in (-5.0..5.0, -10.0..10.0), (a, b) in (-6.0..6.0, -1.5..1.5)
        ) {
            let [_, _, r1, r2] = rates(TwoLinkArm, [t1, t2, w1, w2], &[a, b]);
            let (sin, cos, lower) = (t2.sin(), t2.cos(), 0.8829 * (t1 + t2).sin());
            let first = (0.178 + 0.072 * cos) * r1 + (0.018 + 0.036 * cos) * r2
                - (a - 0.05 * w1 + 0.036 * sin * (2.0 * w1 * w2 + w2 * w2) - 4.7088 * t1.sin() - lower);
            let second = (0.018 + 0.036 * cos) * r1 + 0.018 * r2 - (b - 0.02 * w2 - 0.036 * sin * w1 * w1 - lower);
            prop_assert!(first.abs() < 1e-10 && second.abs() < 1e-10, "{first}, {second}");
        }
    }
}
