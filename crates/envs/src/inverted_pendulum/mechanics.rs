//! Equations of motion of cart and pole.

use std::f64::consts::FRAC_PI_2;

use sindyna_core::VectorField;

use super::capsule::Capsule;
use super::stops::{Stops, resisted};

/// Acceleration of gravity \[m/s²\].
const GRAVITY: f64 = 9.81;
/// Force per unit of control \[N\].
const GEAR: f64 = 100.0;
/// Viscous damping of the slider \[N·s/m\] and of the hinge \[N·m·s/rad\].
const DAMPING: f64 = 1.0;
/// Where the pole ends, from the pivot, in the rest position: sideways and upwards \[m\].
const POLE_END: (f64, f64) = (0.001, 0.6);

/// A cart on a rail with a pole on a hinge, θ = 0 in MuJoCo's rest position, in which the pole leans by φ₀ = atan(1/600).
///
/// With φ = θ + φ₀, total mass M, the pole's mass m, centre of mass l from the hinge and inertia J about the hinge:
///
/// - M v̇ + m l cos φ ω̇ = 100 u − v + m l sin φ ω²,
/// - m l cos φ v̇ + J ω̇ = −ω + m g l sin φ,
///
/// and the stops at the ends of the rail (±1 m) and of the hinge (±90°). The state is (x, θ, v, ω).
pub(super) struct CartAndPole {
    /// M \[kg\].
    total_mass: f64,
    /// m l \[kg·m\].
    mass_moment: f64,
    /// J \[kg·m²\].
    inertia: f64,
    /// φ₀ \[rad\].
    tilt: f64,
    rail: Stops,
    hinge: Stops,
}

impl CartAndPole {
    /// The model Gymnasium ships: a cart 0.1 m thick and a pole of 0.6 m, solid capsules as heavy as water.
    pub(super) fn new() -> Self {
        let cart = Capsule { radius: 0.1, length: 0.2 };
        let pole = Capsule { radius: 0.049, length: POLE_END.0.hypot(POLE_END.1) };
        let (mass, to_centre) = (pole.mass(), 0.5 * pole.length);
        let (total_mass, mass_moment) = (cart.mass() + mass, mass * to_centre);
        let inertia = pole.inertia_across() + mass_moment * to_centre;
        let tilt = POLE_END.0.atan2(POLE_END.1);
        let at_rest = inverse(mass_matrix(total_mass, mass_moment, inertia, tilt.cos()));
        Self {
            total_mass,
            mass_moment,
            inertia,
            tilt,
            rail: Stops { limit: 1.0, mobility: at_rest[0][0] },
            hinge: Stops { limit: FRAC_PI_2, mobility: at_rest[1][1] },
        }
    }

    /// The same on an endless rail, with a hinge that turns all the way round.
    pub(super) fn without_stops(mut self) -> Self {
        self.rail.limit = f64::INFINITY;
        self.hinge.limit = f64::INFINITY;
        self
    }
}

impl VectorField for CartAndPole {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (position, angle, velocity, rate) = (x[0], x[1], x[2], x[3]);
        let (sin, cos) = (angle + self.tilt).sin_cos();
        let force = GEAR * u[0] - DAMPING * velocity + self.mass_moment * sin * rate * rate;
        let torque = self.mass_moment * GRAVITY * sin - DAMPING * rate;
        let mobility = inverse(mass_matrix(self.total_mass, self.mass_moment, self.inertia, cos));
        let free = [mobility[0][0] * force + mobility[0][1] * torque, mobility[1][0] * force + mobility[1][1] * torque];
        let contacts = [self.rail.contact(position, velocity), self.hinge.contact(angle, rate)];
        let accelerations = resisted(free, mobility, contacts);
        x_dot.copy_from_slice(&[velocity, rate, accelerations[0], accelerations[1]]);
    }
}

fn mass_matrix(total_mass: f64, mass_moment: f64, inertia: f64, cos: f64) -> [[f64; 2]; 2] {
    [[total_mass, mass_moment * cos], [mass_moment * cos, inertia]]
}

fn inverse([[a, b], [c, d]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let determinant = a * d - b * c;
    [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_printed_equations_have_these_constants() {
        let system = CartAndPole::new();
        let close =
            |value: f64, printed: f64| assert!((value / printed - 1.0).abs() < 5e-6, "{value} is not {printed}");
        close(system.total_mass, 15.4906);
        close(system.mass_moment, 1.50558);
        close(system.inertia, 0.640423);
        close(system.mass_moment * GRAVITY, 14.7697);
        close(system.tilt, 0.00166667);
    }

    #[test]
    fn mobilities_at_rest_are_mujocos() {
        // mujoco 4.0.0: dof_invweight0 of Gymnasium's inverted_pendulum.xml.
        let system = CartAndPole::new();
        assert!((system.rail.mobility - 0.08367433805859587).abs() < 1e-15);
        assert!((system.hinge.mobility - 2.023912919848819).abs() < 1e-14);
    }

    proptest! {
        /// E = M v²/2 + m l cos φ v ω + J ω²/2 + m g l cos φ.
        #[test]
        fn between_the_stops_energy_comes_from_the_motor_and_goes_into_damping(
            angle in -1.5..1.5, v in -3.0..3.0, w in -3.0..3.0, u in -3.0..3.0
        ) {
            let s = CartAndPole::new();
            let mut x_dot = [0.0; 4];
            s.eval(&[0.0, angle, v, w], &[u], &mut x_dot);
            let (sin, cos) = (angle + s.tilt).sin_cos();
            let power = (s.total_mass * v + s.mass_moment * cos * w) * x_dot[2]
                + (s.mass_moment * cos * v + s.inertia * w) * x_dot[3]
                - s.mass_moment * sin * w * (v * w + GRAVITY);
            prop_assert!((power - (100.0 * u * v - v * v - w * w)).abs() < 1e-9);
        }

        #[test]
        fn stops_only_push_back(x in 1.0..1.2, v in -3.0..3.0, angle in 1.58..1.7, w in -3.0..3.0, u in -3.0..3.0) {
            let s = CartAndPole::new();
            let (mut with, mut without) = ([0.0; 4], [0.0; 4]);
            s.eval(&[x, 0.0, v, w], &[u], &mut with);
            s.eval(&[0.0, 0.0, v, w], &[u], &mut without);
            prop_assert!(with[2] <= without[2], "the rail's end pushes to the left");
            s.eval(&[0.0, angle, v, w], &[u], &mut with);
            s.without_stops().eval(&[0.0, angle, v, w], &[u], &mut without);
            prop_assert!(with[3] <= without[3], "the hinge's end turns back");
        }
    }
}
