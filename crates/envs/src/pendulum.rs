//! A torque-driven pendulum, to be swung up and held (Gymnasium's `Pendulum-v1`).

use std::f64::consts::PI;

use sindyna_core::turning::wrapped;
use sindyna_core::{Channel, Diverged, Dynamics, Kind, Precision, Rng, Space, Spec, Task, VectorField};

use crate::float32::{is_float32, rounded_if};
use crate::system::{Card, System};
use crate::uniform::uniform;

/// Acceleration of gravity \[m/s²\].
const GRAVITY: f64 = 10.0;
/// Mass of the rod \[kg\].
const MASS: f64 = 1.0;
/// Length of the rod \[m\].
const LENGTH: f64 = 1.0;
/// Largest torque either way \[N·m\].
const MAX_TORQUE: f64 = 2.0;
/// Largest angular velocity either way \[rad/s\].
const MAX_SPEED: f64 = 8.0;
/// Control interval \[s\].
const DT: f64 = 0.05;
/// Steps after which an episode is truncated.
const MAX_STEPS: usize = 200;
/// Mean return from which it counts as solved. Gymnasium names none; this one is ours: the best known policies average about −150.
const SOLVED_AT: f64 = -180.0;

pub(crate) fn system() -> System {
    let card = Card {
        name: "pendulum",
        gymnasium_id: Some("Pendulum-v1"),
        solved_at: Some(SOLVED_AT),
        summary: "swing a pendulum up with a motor too weak to lift it, and hold it there",
        true_equations: &["θ̇ = ω", "ω̇ = 15 sin θ + 3 u"],
    };
    let spec = spec(card.name);
    System::new(card, PendulumTask { spec }, Pendulum, Rod)
}

fn spec(name: &str) -> Spec {
    let rate = || Channel::new("ω", "rad/s", Kind::RateOf(0), MAX_SPEED).within(-MAX_SPEED, MAX_SPEED);
    Spec {
        name: name.into(),
        state: vec![Channel::new("θ", "rad", Kind::Angle, 1.0), rate()],
        observation: vec![
            Channel::new("cos θ", "", Kind::CosOf(0), 1.0).within(-1.0, 1.0),
            Channel::new("sin θ", "", Kind::SinOf(0), 1.0).within(-1.0, 1.0),
            rate(),
        ],
        control: vec![Channel::new("u", "N·m", Kind::Plain, MAX_TORQUE).within(-MAX_TORQUE, MAX_TORQUE)],
        action_space: Space::Box { low: vec![-MAX_TORQUE], high: vec![MAX_TORQUE] },
        precision: Precision::F32,
        noise: 0.0,
        dt: DT,
    }
}

/// A rod on a pivot, θ = 0 upright: ω̇ = 3g/(2l) sin θ + 3/(m l²) u, with |ω| limited.
///
/// Stepped semi-implicitly: ω' = clip(ω + ω̇ Δt), θ' = θ + ω' Δt. The angle is never wrapped.
///
/// # References
/// Gymnasium 1.4, `gymnasium/envs/classic_control/pendulum.py`.
struct Pendulum;

impl Dynamics for Pendulum {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        let (angle, rate, torque) = (x[0], x[1], u[0]);
        let push = rounded_if(is_float32(torque), 3.0 / (MASS * LENGTH * LENGTH) * torque);
        let acceleration = 3.0 * GRAVITY / (2.0 * LENGTH) * angle.sin() + push;
        next[1] = (rate + acceleration * DT).clamp(-MAX_SPEED, MAX_SPEED);
        next[0] = angle + next[1] * DT;
        Diverged::check(next)
    }
}

/// (ω, ω̇) at one instant, without the speed limit.
struct Rod;

impl VectorField for Rod {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot[0] = x[1];
        x_dot[1] = 3.0 * GRAVITY / (2.0 * LENGTH) * x[0].sin() + 3.0 / (MASS * LENGTH * LENGTH) * u[0];
    }
}

/// Upright, still and without effort: r = −(θ² + 0.1 ω² + 0.001 u²) of the state before the step, θ in [−π, π).
struct PendulumTask {
    spec: Spec,
}

impl Task for PendulumTask {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn max_steps(&self) -> usize {
        MAX_STEPS
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x[0] = uniform(-PI, PI, rng);
        x[1] = uniform(-1.0, 1.0, rng);
    }

    fn reward(&self, x: &[f64], action: &[f64], u: &[f64], _next: &[f64]) -> f64 {
        let (angle, rate, torque) = (wrapped(x[0]), x[1], u[0]);
        let effort =
            if is_float32(action[0]) { f64::from(0.001_f32 * squared(torque as f32)) } else { 0.001 * torque * torque };
        -(angle * angle + 0.1 * (rate * rate) + effort)
    }

    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

/// The square of a float32 as NumPy takes it, by C's `powf`: now and then the last bit is not that of a product.
fn squared(value: f32) -> f32 {
    // A compiler that sees the exponent makes a product of it.
    value.powf(std::hint::black_box(2.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use sindyna_core::Seed;

    fn step(x: [f64; 2], u: f64) -> [f64; 2] {
        let mut next = [0.0; 2];
        Pendulum.step(&x, &[u], &mut Seed::new(0).numpy(), &mut next).expect("a pendulum stays finite");
        next
    }

    #[test]
    fn a_free_pendulum_neither_gains_nor_loses_energy_in_the_long_run() {
        // The semi-implicit scheme is symplectic: the energy ω²/2 + 15 cos θ swings around its start for ever.
        let energy = |x: [f64; 2]| 0.5 * x[1] * x[1] + 15.0 * x[0].cos();
        let mut x = [2.0, 0.0];
        let start = energy(x);
        for _ in 0..20_000 {
            x = step(x, 0.0);
            assert!((energy(x) - start).abs() < 0.1 * 30.0, "{x:?}");
        }
    }

    #[test]
    fn speed_is_limited_and_moves_the_angle_by_the_limited_speed() {
        assert_eq!(step([1.0, 7.9], 2.0), [1.0 + 8.0 * DT, 8.0]);
    }

    #[test]
    fn the_reward_is_of_the_state_before_the_step_and_knows_no_turns() {
        let task = PendulumTask { spec: spec("pendulum") };
        let reward = |x: [f64; 2], action, u| task.reward(&x, &[action], &[u], &[9.0, 9.0]);
        assert!(reward([TAU, 0.0], 0.0, 0.0).abs() < 1e-15);
        assert!((reward([-PI, 8.0], 5.0, 2.0) + PI * PI + 6.4 + 0.004).abs() < 1e-9, "the clipped torque is charged");
        assert!((reward([1.0, 2.0], 0.1, 0.1) + 1.0 + 0.4 + 0.00001).abs() < 1e-12);
    }
}
