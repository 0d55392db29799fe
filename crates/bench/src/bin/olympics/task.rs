//! Swinging up and staying there, as a planner sees it: the score's criteria are paid for step by step, and the torque is a state, whose rate is chosen.

use std::f64::consts::PI;

use sindyna_core::{Channel, Diverged, Dynamics, Held, Kind, Precision, Rng, Scheme, Space, Spec, Task, VectorField};
use sindyna_sindy::Model;

use super::plant::{DT, LENGTHS, LIMIT, Robot, STEPS};
use super::score::{NORMS, height};

/// Steps of the simulator per step of the planner.
pub(crate) const EVERY: usize = 5;

/// Largest rate of the torque \[N m/s\].
const RATE: f64 = 100.0;

/// Width of the edge of what counts as up \[m\].
const EDGE: f64 = 0.01;

/// What a unit of each criterion takes from the score.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prices {
    each: [f64; 5],
    /// Smoothness at which its price holds.
    smoothness: f64,
}

impl Prices {
    /// The slopes of the score where criteria come to as much as these.
    pub(crate) fn near(criteria: &[f64; 5]) -> Self {
        let of = |i: usize| (1.0 - (PI * criteria[i] / NORMS[i]).tanh().powi(2)) * PI / NORMS[i] / NORMS.len() as f64;
        Self { each: std::array::from_fn(of), smoothness: criteria[3].max(1e-3) }
    }

    /// The same, but a run that is never up costs the whole score, as it does: by its slopes, not to move at all may be as good as to swing up.
    pub(crate) fn with_all_for_time(mut self) -> Self {
        self.each[0] = 1.0 / (STEPS as f64 * DT);
        self
    }
}

/// The task for a robot.
pub(crate) struct SwingUp {
    spec: Spec,
    joint: usize,
    prices: Prices,
}

impl SwingUp {
    pub(crate) fn new(robot: Robot, prices: Prices) -> Self {
        let torque = Channel::new("τ", "N m", Kind::Plain, LIMIT).within(-LIMIT, LIMIT);
        let state = vec![
            Channel::new("q1", "rad", Kind::Angle, PI),
            Channel::new("q2", "rad", Kind::Angle, PI),
            Channel::new("v1", "rad/s", Kind::RateOf(0), 10.0),
            Channel::new("v2", "rad/s", Kind::RateOf(1), 10.0),
            torque,
        ];
        let spec = Spec {
            name: robot.name().to_owned(),
            observation: state.clone(),
            state,
            control: vec![Channel::new("dτ/dt", "N m/s", Kind::Plain, RATE).within(-RATE, RATE)],
            action_space: Space::Box { low: vec![-RATE], high: vec![RATE] },
            precision: Precision::F64,
            noise: 0.0,
            dt: EVERY as f64 * DT,
        };
        Self { spec, joint: robot.joint(), prices }
    }
}

impl Task for SwingUp {
    fn spec(&self) -> &Spec {
        &self.spec
    }
    fn max_steps(&self) -> usize {
        STEPS / EVERY
    }
    fn initial(&self, _: &mut Rng, x: &mut [f64]) {
        x.fill(0.0);
    }
    fn reward(&self, x: &[f64], _: &[f64], u: &[f64], next: &[f64]) -> f64 {
        let ([time, energy, torque, smooth, velocity], dt) = (self.prices.each, self.spec.dt);
        let short = (0.9 * (LENGTHS[0] + LENGTHS[1]) - height(next[0], next[1])) / EDGE;
        let middle = 0.5 * (x[4] + next[4]);
        // s² = Σ (Δτ)²/T, and a change of s² changes s by a part 1/(2 s) of it.
        let rough = (u[0] * DT).powi(2) * EVERY as f64 / STEPS as f64 / (2.0 * self.prices.smoothness);
        -(time * dt / (1.0 + (-short).exp())
            + energy * ((next[self.joint] - x[self.joint]) * middle).abs()
            + torque * middle * middle * dt
            + smooth * rough
            + velocity * (next[2] * next[2] + next[3] * next[3]) * dt)
    }
    fn terminated(&self, _: &[f64]) -> bool {
        false
    }
}

/// The equations with a torque that changes at a rate.
pub(crate) struct Ramped(Held<WithTorque>);

struct WithTorque(Model);

impl Ramped {
    pub(crate) fn new(model: Model) -> Self {
        Self(Held::new(WithTorque(model), Scheme::Rk4 { substeps: 1 }, EVERY as f64 * DT))
    }
}

impl VectorField for WithTorque {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (own, torque) = x.split_at(4);
        let (of_own, of_torque) = x_dot.split_at_mut(4);
        self.0.eval(own, torque, of_own);
        of_torque[0] = u[0];
    }
}

impl Dynamics for Ramped {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        self.0.step(x, u, rng, next)?;
        next[4] = next[4].clamp(-LIMIT, LIMIT);
        Ok(())
    }
}
