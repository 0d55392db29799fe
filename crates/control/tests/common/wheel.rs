//! A pendulum that is moved by a reaction wheel alone: a smooth plan swings it up late, a shorter one soon.

use std::sync::Arc;

use rand::RngExt as _;
use sindyna_core::{Channel, Diverged, Dynamics, Kind, Precision, Rng, Space, Spec, Task};

const DT: f64 = 0.04;
const SUBSTEPS: usize = 4;

pub(crate) struct Swingup(Spec);

impl Swingup {
    pub(crate) fn new() -> Self {
        let states = vec![
            Channel::new("angle", "rad", Kind::Angle, 1.0),
            Channel::new("rate", "rad/s", Kind::RateOf(0), 1.0),
            Channel::new("wheel", "rad/s", Kind::Plain, 1.0),
        ];
        Self(Spec {
            name: "reaction wheel".into(),
            observation: states.clone(),
            state: states,
            control: vec![Channel::new("torque", "N m", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-1.5], high: vec![1.5] },
            precision: Precision::F64,
            noise: 0.0,
            dt: DT,
        })
    }

    pub(crate) fn dynamics() -> Arc<dyn Dynamics> {
        Arc::new(Motion)
    }
}

struct Motion;

impl Dynamics for Motion {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        next.copy_from_slice(x);
        let h = DT / SUBSTEPS as f64;
        let slope = |x: [f64; 3]| [x[1], 25.0 * x[0].sin() - 0.08 * x[1] - 4.5 * u[0], 35.0 * u[0] - 0.2 * x[2]];
        let moved = |x: [f64; 3], by: [f64; 3], h: f64| [x[0] + h * by[0], x[1] + h * by[1], x[2] + h * by[2]];
        for _ in 0..SUBSTEPS {
            let x = [next[0], next[1], next[2]];
            let (k1, h2) = (slope(x), 0.5 * h);
            let k2 = slope(moved(x, k1, h2));
            let k3 = slope(moved(x, k2, h2));
            let k4 = slope(moved(x, k3, h));
            (0..3).for_each(|i| next[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        Diverged::check(next)
    }
}

impl Task for Swingup {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn max_steps(&self) -> usize {
        200
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x.copy_from_slice(&[rng.random_range(3.0..3.28), 0.0, 0.0]);
    }
    fn reward(&self, x: &[f64], _action: &[f64], u: &[f64], _next: &[f64]) -> f64 {
        x[0].cos() - 0.01 * x[1] * x[1] - 1e-4 * x[2] * x[2] - 0.01 * u[0] * u[0]
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}
