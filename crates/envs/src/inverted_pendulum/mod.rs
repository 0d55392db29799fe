//! A pole balanced on a motor-driven cart: MuJoCo's inverted pendulum (Gymnasium's `InvertedPendulum-v5`), without
//! MuJoCo.
//!
//! Nothing in that model collides and nothing rubs but the joints' viscous damping, so its equations of motion have a
//! closed form ([`mechanics`]); what remains of the physics engine is the soft ends of the joints' travel ([`stops`]) and
//! its integrator, two Runge–Kutta steps of 0.02 s per control interval.

mod capsule;
mod integrator;
mod mechanics;
mod stops;

use sindyna_core::{Channel, Held, Kind, Precision, Rng, Scheme, Space, Spec, Task};

use crate::system::{Card, System};
use crate::uniform::uniform;
use integrator::{DT, SUBSTEPS};
use mechanics::CartAndPole;

/// Largest control either way, in units of 100 N.
const MAX_CONTROL: f64 = 3.0;
/// Lean at which the episode ends \[rad\].
const MAX_ANGLE: f64 = 0.2;
/// Steps after which an episode is truncated.
const MAX_STEPS: usize = 1000;
/// Mean return from which it counts as solved, as Gymnasium has it.
const SOLVED_AT: f64 = 950.0;

pub(crate) fn system() -> System {
    let card = Card {
        name: "inverted-pendulum",
        gymnasium_id: Some("InvertedPendulum-v5"),
        solved_at: Some(SOLVED_AT),
        summary: "balance a pole on a motor-driven cart, on a rail with soft ends",
        true_equations: &[
            "ẋ = v",
            "θ̇ = ω",
            "15.4906 v̇ + 1.50558 cos(θ + 0.00166667) ω̇ = 100 u − v + 1.50558 sin(θ + 0.00166667) ω²",
            "1.50558 cos(θ + 0.00166667) v̇ + 0.640423 ω̇ = −ω + 14.7697 sin(θ + 0.00166667)",
        ],
    };
    let spec = spec(card.name);
    let scheme = Scheme::Rk4 { substeps: SUBSTEPS };
    let held = Held::new(CartAndPole::new(), scheme, DT);
    System::new(card, InvertedPendulumTask { spec }, held, CartAndPole::new().without_stops())
}

fn spec(name: &str) -> Spec {
    let channels = vec![
        Channel::new("x", "m", Kind::Plain, 1.0),
        Channel::new("θ", "rad", Kind::Angle, 0.2),
        Channel::new("v", "m/s", Kind::RateOf(0), 1.0),
        Channel::new("ω", "rad/s", Kind::RateOf(1), 1.0),
    ];
    Spec {
        name: name.into(),
        state: channels.clone(),
        observation: channels,
        control: vec![Channel::new("u", "100 N", Kind::Plain, MAX_CONTROL).within(-MAX_CONTROL, MAX_CONTROL)],
        action_space: Space::Box { low: vec![-MAX_CONTROL], high: vec![MAX_CONTROL] },
        precision: Precision::F64,
        noise: 0.0,
        dt: DT,
    }
}

/// One point for every step after which the pole still stands; where the cart is does not matter.
struct InvertedPendulumTask {
    spec: Spec,
}

impl Task for InvertedPendulumTask {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn max_steps(&self) -> usize {
        MAX_STEPS
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        for value in x {
            *value = uniform(-0.01, 0.01, rng);
        }
    }

    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
        f64::from(u8::from(!self.terminated(next)))
    }

    fn terminated(&self, next: &[f64]) -> bool {
        next[1].abs() > MAX_ANGLE || next.iter().any(|v| !v.is_finite())
    }
}
