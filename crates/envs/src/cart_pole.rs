//! A pole balanced on a cart that can only be pushed left or right (Gymnasium's `CartPole-v1`).

use ndarray::array;
use sindyna_core::{Channel, Held, Kind, Precision, Rng, Scheme, Space, Spec, Task, VectorField};

use crate::float32::rounded;
use crate::system::{Card, System};
use crate::uniform::uniform;

/// Acceleration of gravity \[m/s²\].
const GRAVITY: f64 = 9.8;
/// Mass of the pole \[kg\].
const POLE_MASS: f64 = 0.1;
/// Mass of cart and pole \[kg\].
const TOTAL_MASS: f64 = POLE_MASS + 1.0;
/// Half the length of the pole \[m\].
const HALF_LENGTH: f64 = 0.5;
/// Mass of the pole times the distance of its centre from the pivot \[kg·m\].
const MASS_MOMENT: f64 = POLE_MASS * HALF_LENGTH;
/// The push \[N\].
const FORCE: f64 = 10.0;
/// Control interval \[s\].
const DT: f64 = 0.02;
/// Distance from the middle at which the episode ends \[m\].
const MAX_DISTANCE: f64 = 2.4;
/// Lean at which the episode ends: 12° \[rad\].
const MAX_ANGLE: f64 = 12.0 * 2.0 * std::f64::consts::PI / 360.0;
/// Steps after which an episode is truncated.
const MAX_STEPS: usize = 500;
/// Mean return from which it counts as solved, as Gymnasium has it.
const SOLVED_AT: f64 = 475.0;

pub(crate) fn system() -> System {
    let card = Card {
        name: "cart-pole",
        gymnasium_id: Some("CartPole-v1"),
        solved_at: Some(SOLVED_AT),
        summary: "balance a pole on a cart with pushes of 10 N to the left or right",
        true_equations: &[
            "ẋ = v",
            "1.1 v̇ + 0.05 cos θ ω̇ = F + 0.05 sin θ ω²",
            "θ̇ = ω",
            "0.05 cos θ v̇ + 0.0333333 ω̇ = 0.49 sin θ",
        ],
    };
    let spec = spec(card.name);
    System::new(card, CartPoleTask { spec }, Held::new(CartPole, Scheme::Euler, DT), CartPole)
}

fn spec(name: &str) -> Spec {
    // Twice the thresholds, in float32, so that the observation that ends an episode still lies inside.
    let (x_bound, angle_bound) = (rounded(2.0 * MAX_DISTANCE), rounded(2.0 * MAX_ANGLE));
    let channels = vec![
        Channel::new("x", "m", Kind::Plain, 2.4).within(-x_bound, x_bound),
        Channel::new("v", "m/s", Kind::RateOf(0), 2.0),
        Channel::new("θ", "rad", Kind::Angle, 0.21).within(-angle_bound, angle_bound),
        Channel::new("ω", "rad/s", Kind::RateOf(2), 2.0),
    ];
    Spec {
        name: name.into(),
        state: channels.clone(),
        observation: channels,
        control: vec![Channel::new("F", "N", Kind::Plain, FORCE).within(-FORCE, FORCE)],
        action_space: Space::Discrete { controls: array![[-FORCE], [FORCE]] },
        precision: Precision::F32,
        noise: 0.0,
        dt: DT,
    }
}

/// Cart and pole without friction, θ = 0 upright; M is the total mass, m l the pole's mass moment:
///
/// - ω̇ = (g sin θ − cos θ·t) / (l (4/3 − m cos² θ / M)) with t = (F + m l ω² sin θ) / M,
/// - v̇ = t − m l ω̇ cos θ / M.
///
/// Stepped by explicit Euler, all four states from the old values.
///
/// # References
/// Barto, Sutton, Anderson (1983), IEEE Trans. SMC 13(5); corrected by Florian (2007), without friction.
/// Gymnasium 1.4, `gymnasium/envs/classic_control/cartpole.py`.
struct CartPole;

impl VectorField for CartPole {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (velocity, rate, force) = (x[1], x[3], u[0]);
        let (sin, cos) = x[2].sin_cos();
        let pushed = (force + MASS_MOMENT * (rate * rate) * sin) / TOTAL_MASS;
        let turned =
            (GRAVITY * sin - cos * pushed) / (HALF_LENGTH * (4.0 / 3.0 - POLE_MASS * (cos * cos) / TOTAL_MASS));
        x_dot[0] = velocity;
        x_dot[1] = pushed - MASS_MOMENT * turned * cos / TOTAL_MASS;
        x_dot[2] = rate;
        x_dot[3] = turned;
    }
}

/// One point for every step, the last one included, until the pole leans too far or the cart leaves the track.
struct CartPoleTask {
    spec: Spec,
}

impl Task for CartPoleTask {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn max_steps(&self) -> usize {
        MAX_STEPS
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        for value in x {
            *value = uniform(-0.05, 0.05, rng);
        }
    }

    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
        1.0
    }

    fn terminated(&self, next: &[f64]) -> bool {
        next[0].abs() > MAX_DISTANCE || next[2].abs() > MAX_ANGLE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// E = M v²/2 + m l cos θ v ω + (4/3) m l² ω²/2 + m g l cos θ.
    fn power(x: &[f64], x_dot: &[f64]) -> f64 {
        let (v, w) = (x[1], x[3]);
        let (sin, cos) = x[2].sin_cos();
        let inertia = 4.0 / 3.0 * MASS_MOMENT * HALF_LENGTH;
        (TOTAL_MASS * v + MASS_MOMENT * cos * w) * x_dot[1] + (MASS_MOMENT * cos * v + inertia * w) * x_dot[3]
            - MASS_MOMENT * sin * w * (v * w + GRAVITY)
    }

    proptest! {
        #[test]
        fn energy_comes_from_the_push_alone(
            v in -3.0..3.0, angle in -3.0..3.0, rate in -3.0..3.0, force in -10.0..10.0
        ) {
            let x = [0.0, v, angle, rate];
            let mut x_dot = [0.0; 4];
            CartPole.eval(&x, &[force], &mut x_dot);
            prop_assert!((power(&x, &x_dot) - force * v).abs() < 1e-10);
        }
    }

    #[test]
    fn a_fall_is_judged_on_the_new_state() {
        let task = CartPoleTask { spec: spec("cart-pole") };
        for (next, fallen) in [
            ([2.4, 0.0, 0.209, 0.0], false),
            ([2.401, 0.0, 0.0, 0.0], true),
            ([-2.401, 0.0, 0.0, 0.0], true),
            ([0.0, 9.0, -0.2095, 9.0], true),
        ] {
            assert_eq!(task.terminated(&next), fallen, "{next:?}");
        }
    }
}
