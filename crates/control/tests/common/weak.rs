//! The pendulum of dm_control, whose motor lifts it by a fifth of the way, and its best returns by value iteration.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use rand::RngExt as _;
use sindyna_core::{Channel, Diverged, Dynamics, Kind, Precision, Rng, Space, Spec, Task};

const DT: f64 = 0.02;
/// 8 degrees from upright.
const PAID: f64 = 0.990_268_068_741_570_4;
const STEPS: usize = 1000;

/// A ball of 1 kg on a massless rod of 0.5 m with damping, stepped as MuJoCo does; angle from upright.
pub(crate) struct Weak;

fn step([th, w]: [f64; 2], u: f64) -> [f64; 2] {
    let w = w + DT * (u - 0.1 * w + 4.905 * th.sin()) / (0.251 + 0.1 * DT);
    [th + DT * w, w]
}

impl Dynamics for Weak {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        next.copy_from_slice(&step([x[0], x[1]], u[0]));
        Diverged::check(next)
    }
}

/// Pays 1 for a step that ends within 8 degrees of upright.
pub(crate) struct Swingup(Spec);

impl Swingup {
    pub(crate) fn new() -> Self {
        let rate = Channel::new("w", "rad/s", Kind::RateOf(0), 1.0);
        let seen = |name, kind| Channel::new(name, "", kind, 1.0);
        Self(Spec {
            name: "weak pendulum".into(),
            state: vec![Channel::new("th", "rad", Kind::Angle, 1.0), rate.clone()],
            observation: vec![seen("c", Kind::CosOf(0)), seen("s", Kind::SinOf(0)), rate],
            control: vec![Channel::new("u", "N m", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: DT,
        })
    }

    pub(crate) fn dynamics() -> Arc<dyn Dynamics> {
        Arc::new(Weak)
    }
}

impl Task for Swingup {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn max_steps(&self) -> usize {
        STEPS
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x[0] = rng.random_range(-PI..PI);
        x[1] = 0.0;
    }
    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
        paid(next[0])
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

fn paid(th: f64) -> f64 {
    f64::from(u8::from(th.cos() >= PAID))
}

/// Steps that are not paid from each state on, at best, on a grid over a turn and over rates within 12 rad/s: J(x) = min_u (1 − r(x⁺) + J(x⁺)).
pub(crate) struct Lost(Vec<f32>);

impl Lost {
    const ANGLES: usize = 1080;
    const RATES: usize = 1201;
    const FASTEST: f64 = 12.0;

    pub(crate) fn at_best() -> Self {
        let state = |at: usize| {
            let rate = (at % Self::RATES) as f64 / (Self::RATES - 1) as f64;
            [(at / Self::RATES) as f64 / Self::ANGLES as f64 * TAU - PI, (2.0 * rate - 1.0) * Self::FASTEST]
        };
        let of = |(at, u): (usize, f64)| {
            let next = step(state(at), u);
            (Self::place(next), 1.0 - paid(next[0]) as f32)
        };
        let size = Self::ANGLES * Self::RATES;
        let steps: Vec<_> = (0..size).flat_map(|at| [-1.0, 0.0, 1.0].map(|u| of((at, u)))).collect();
        let mut lost = Self(vec![0.0; size]);
        loop {
            let best = |of: &[((usize, f32, f32), f32)]| {
                of.iter().map(|(place, lost_now)| lost_now + lost.at(*place)).fold(f32::INFINITY, f32::min)
            };
            let next: Vec<f32> = steps.chunks_exact(3).map(best).collect();
            let change = next.iter().zip(&lost.0).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            lost = Self(next);
            if change < 0.05 {
                return lost;
            }
        }
    }

    /// The cell of a state, and where it is in it.
    fn place([th, w]: [f64; 2]) -> (usize, f32, f32) {
        let angle = (th + PI).rem_euclid(TAU) / TAU * Self::ANGLES as f64;
        let rate = (0.5 + 0.5 * w / Self::FASTEST).clamp(0.0, 1.0) * (Self::RATES - 1) as f64;
        let (i, j) = ((angle as usize).min(Self::ANGLES - 1), (rate as usize).min(Self::RATES - 2));
        (i * Self::RATES + j, (angle - i as f64) as f32, (rate - j as f64) as f32)
    }

    fn at(&self, (at, a, r): (usize, f32, f32)) -> f32 {
        let along = |at: usize| (1.0 - r) * self.0[at] + r * self.0[at + 1];
        (1.0 - a) * along(at) + a * along((at + Self::RATES) % self.0.len())
    }

    /// What the best control of each step earns in an episode from `x`.
    pub(crate) fn earned(&self, x: &[f64]) -> f64 {
        let (mut x, mut earned) = ([x[0], x[1]], 0.0);
        for _ in 0..STEPS {
            let value = |next: [f64; 2]| 1.0 - paid(next[0]) + f64::from(self.at(Self::place(next)));
            let all = (-10..=10).map(|u| step(x, f64::from(u) / 10.0));
            x = all.min_by(|a, b| value(*a).total_cmp(&value(*b))).expect("there are some");
            earned += paid(x[0]);
        }
        earned
    }
}
