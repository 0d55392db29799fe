//! A car in a valley, too weak to climb out in one go (Gymnasium's `MountainCarContinuous-v0`).

use sindyna_core::{Channel, Diverged, Dynamics, Kind, Precision, Rng, Space, Spec, Task, VectorField};

use crate::float32::{is_float32, rounded, rounded_if};
use crate::system::{Card, System};
use crate::uniform::uniform;

/// Acceleration at full throttle \[1/step²\].
const POWER: f64 = 0.0015;
/// Acceleration on the steepest slope \[1/step²\].
const GRAVITY: f64 = 0.0025;
/// Largest throttle either way.
const MAX_THROTTLE: f64 = 1.0;
/// Largest velocity either way \[1/step\].
const MAX_SPEED: f64 = 0.07;
/// Where the wall on the left stands.
const WALL: f64 = -1.2;
/// Where the track ends on the right.
const TRACK_END: f64 = 0.6;
/// Where the goal is.
const GOAL: f64 = 0.45;
/// Steps after which an episode is truncated.
const MAX_STEPS: usize = 999;
/// Mean return from which it counts as solved, as Gymnasium has it.
const SOLVED_AT: f64 = 90.0;

pub(crate) fn system() -> System {
    let card = Card {
        name: "mountain-car",
        gymnasium_id: Some("MountainCarContinuous-v0"),
        solved_at: Some(SOLVED_AT),
        summary: "rock a weak car out of a valley with as little throttle as possible",
        true_equations: &["x' = x + v'", "v' = v + 0.0015 u − 0.0025 cos 3x"],
    };
    let spec = spec(card.name);
    System::new(card, MountainCarTask { spec }, MountainCar, Hills)
}

fn spec(name: &str) -> Spec {
    // States are float32, and so are their limits: the float32 next to 0.07 is a little larger than 0.07.
    let channels = vec![
        Channel::new("x", "", Kind::Plain, 0.9).within(rounded(WALL), rounded(TRACK_END)),
        Channel::new("v", "1/step", Kind::RateOf(0), MAX_SPEED).within(-rounded(MAX_SPEED), rounded(MAX_SPEED)),
    ];
    Spec {
        name: name.into(),
        state: channels.clone(),
        observation: channels,
        control: vec![Channel::new("u", "", Kind::Plain, MAX_THROTTLE).within(-MAX_THROTTLE, MAX_THROTTLE)],
        action_space: Space::Box { low: vec![-MAX_THROTTLE], high: vec![MAX_THROTTLE] },
        precision: Precision::F32,
        noise: 0.0,
        dt: 1.0,
    }
}

/// A car on the hills sin 3x: v' = clip(v + 0.0015 u − 0.0025 cos 3x), x' = clip(x + v'). The wall on the left stops
/// the car, the end of the track on the right only holds it.
///
/// Gymnasium keeps the state in float64 after a reset and in float32 after a step, and NumPy computes every operation
/// in the type of its operands. So do we, and get the same bits: every intermediate result is rounded to float32
/// where NumPy 2 rounds it. (A sum or product of float32 numbers taken in float64 and then rounded is the float32 sum or
/// product.)
///
/// # Deviations
/// 1. A throttle of exactly ±1 is taken as one that was clipped, which makes it a float64; where Gymnasium is given
///    ±1 as float32 it may differ in the last bit of the velocity.
///
/// # References
/// Moore (1990), PhD thesis, Cambridge. Gymnasium 1.4, `gymnasium/envs/classic_control/continuous_mountain_car.py`.
struct MountainCar;

impl Dynamics for MountainCar {
    #[expect(clippy::float_cmp, reason = "the car stands at the wall because it was put exactly there")]
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        let (position, velocity, throttle) = (x[0], x[1], u[0]);
        let after_step = is_float32(position);
        let clipped = throttle.abs() >= MAX_THROTTLE;

        let slope = rounded_if(after_step, 3.0 * position).cos();
        let gain = if is_float32(throttle) && !clipped {
            rounded(rounded(throttle * rounded(POWER)) - rounded(GRAVITY * slope))
        } else {
            throttle * POWER - GRAVITY * slope
        };

        let mut narrow = after_step && is_float32(throttle);
        let mut velocity = rounded_if(narrow, velocity + rounded_if(narrow, gain));
        if velocity.abs() > rounded_if(narrow, MAX_SPEED) {
            // The limit is a Python float, which takes the type of what it is added to.
            narrow = after_step;
            velocity = rounded_if(narrow, MAX_SPEED).copysign(velocity);
        }
        let (wall, track_end) = (rounded_if(narrow, WALL), rounded_if(narrow, TRACK_END));
        let position = rounded_if(narrow, position + velocity).clamp(wall, track_end);
        if position == wall && velocity < 0.0 {
            velocity = 0.0;
        }
        next[0] = rounded(position);
        next[1] = rounded(velocity);
        Diverged::check(next)
    }
}

/// The increments (x⁺ − x, v⁺ − v) = (v⁺, 0.0015 u − 0.0025 cos 3x) of one step, without wall, limits and rounding.
struct Hills;

impl VectorField for Hills {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot[1] = POWER * u[0] - GRAVITY * (3.0 * x[0]).cos();
        x_dot[0] = x[1] + x_dot[1];
    }
}

/// 100 points for reaching the goal, −0.1 a² for every step; a is the action before it is clipped.
struct MountainCarTask {
    spec: Spec,
}

impl Task for MountainCarTask {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn max_steps(&self) -> usize {
        MAX_STEPS
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x[0] = uniform(-0.6, -0.4, rng);
        x[1] = 0.0;
    }

    fn reward(&self, _x: &[f64], action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
        let prize = if self.terminated(next) { 100.0 } else { 0.0 };
        prize - action[0] * action[0] * 0.1
    }

    fn terminated(&self, next: &[f64]) -> bool {
        next[0] >= rounded(GOAL) && next[1] >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::Seed;

    fn step(x: [f64; 2], u: f64) -> [f64; 2] {
        let mut next = [0.0; 2];
        MountainCar.step(&x, &[u], &mut Seed::new(0).numpy(), &mut next).expect("a car stays finite");
        next
    }

    #[test]
    fn the_wall_stops_the_car_and_the_track_end_only_holds_it() {
        assert_eq!(step([-1.19, -0.06], -1.0), [rounded(WALL), 0.0]);
        let [position, velocity] = step([0.59, 0.06], 1.0);
        assert_eq!(position, rounded(TRACK_END));
        assert!(velocity > 0.06);
    }

    #[test]
    fn speed_is_limited_both_ways() {
        assert_eq!(step([-1.0, 0.0699], 1.0)[1], rounded(MAX_SPEED));
        assert_eq!(step([0.0, -0.0699], -1.0)[1], -rounded(MAX_SPEED));
    }

    #[test]
    fn the_reward_charges_the_action_that_was_asked_for() {
        let task = MountainCarTask { spec: spec("mountain-car") };
        let reward = |next: [f64; 2]| task.reward(&[0.4, 0.05], &[2.0], &[1.0], &next);
        assert!((reward([0.44, 0.05]) + 0.4).abs() < 1e-15);
        assert!((reward([0.46, 0.05]) - 99.6).abs() < 1e-12);
        assert!((reward([0.46, -0.05]) + 0.4).abs() < 1e-15, "the goal is passed to the right");
    }
}
