//! True systems with their specs, written out, and short rollouts of them.

#![allow(dead_code)]

use sindyna_core::{Channel, Dataset, Kind, Observe as _, Precision, Rng, Seed, Sensors, Space, Spec};

/// A system whose truth is known.
pub(crate) struct Truth {
    pub(crate) spec: Spec,
    pub(crate) step: fn(&[f64], &[f64]) -> Vec<f64>,
}

fn spec(name: &str, state: Vec<Channel>, observation: Vec<Channel>, u: f64, precision: Precision, dt: f64) -> Spec {
    Spec {
        name: name.into(),
        state,
        observation,
        control: vec![Channel::new("u", "N", Kind::Plain, u).within(-u, u)],
        action_space: Space::Box { low: vec![-u], high: vec![u] },
        precision,
        noise: 0.0,
        dt,
    }
}

/// ω' = clip(ω + 0.05 (15 sin θ + 3 u), ±8), θ' = θ + 0.05 ω'; cosine, sine and rate are seen as float32.
pub(crate) fn pendulum() -> Truth {
    let rate = || Channel::new("ω", "rad/s", Kind::RateOf(0), 8.0).within(-8.0, 8.0);
    let seen = |name: &str, kind| Channel::new(name, "", kind, 1.0).within(-1.0, 1.0);
    let state = vec![Channel::new("θ", "rad", Kind::Angle, 1.0), rate()];
    let observation = vec![seen("cos θ", Kind::CosOf(0)), seen("sin θ", Kind::SinOf(0)), rate()];
    Truth {
        spec: spec("pendulum", state, observation, 2.0, Precision::F32, 0.05),
        step: |x, u| {
            let rate = (x[1] + 0.05 * (15.0 * x[0].sin() + 3.0 * u[0])).clamp(-8.0, 8.0);
            vec![x[0] + 0.05 * rate, rate]
        },
    }
}

/// v' = clip(v + 0.0015 u − 0.0025 cos 3x, ±0.07), x' = clip(x + v', −1.2, 0.6), stopped at the left wall; all float32.
pub(crate) fn mountain_car() -> Truth {
    let position = Channel::new("x", "", Kind::Plain, 1.0).within(-1.2, 0.6);
    let speed = Channel::new("v", "", Kind::RateOf(0), 0.07).within(-0.07, 0.07);
    let state = vec![position, speed];
    Truth {
        spec: spec("mountain-car", state.clone(), state, 1.0, Precision::F32, 1.0),
        step: |x, u| {
            let (x, v) = (x[0] as f32, x[1] as f32);
            let v = (v + (0.0015 * u[0] - 0.0025 * f64::from(3.0 * x).cos()) as f32).clamp(-0.07, 0.07);
            let x = (x + v).clamp(-1.2, 0.6);
            let v = if x <= -1.2 && v < 0.0 { 0.0 } else { v };
            vec![f64::from(x), f64::from(v)]
        },
    }
}

fn four_states(name: &str, precision: Precision, u: f64, dt: f64, bounded: bool) -> Spec {
    let (rail, tilt) = if bounded { (4.8, 0.418_879) } else { (f64::INFINITY, f64::INFINITY) };
    let x = Channel::new("x", "m", Kind::Plain, if bounded { 2.4 } else { 1.0 }).within(-rail, rail);
    let angle = Channel::new("θ", "rad", Kind::Angle, 0.2).within(-tilt, tilt);
    let v = Channel::new("v", "m/s", Kind::RateOf(0), 2.0);
    let rate = Channel::new("ω", "rad/s", Kind::RateOf(if bounded { 2 } else { 1 }), 2.0);
    let state = if bounded { vec![x, v, angle, rate] } else { vec![x, angle, v, rate] };
    spec(name, state.clone(), state, u, precision, dt)
}

/// Gymnasium's cart-pole: explicit Euler, float32 observations.
pub(crate) fn cart_pole() -> Truth {
    Truth {
        spec: four_states("cart-pole", Precision::F32, 10.0, 0.02, true),
        step: |x, u| {
            let temp = (u[0] + 0.05 * x[3] * x[3] * x[2].sin()) / 1.1;
            let turn = (9.8 * x[2].sin() - x[2].cos() * temp) / (0.5 * (4.0 / 3.0 - 0.1 * x[2].cos().powi(2) / 1.1));
            let push = temp - 0.05 * turn * x[2].cos() / 1.1;
            vec![x[0] + 0.02 * x[1], x[1] + 0.02 * push, x[2] + 0.02 * x[3], x[3] + 0.02 * turn]
        },
    }
}

/// MuJoCo's inverted pendulum in closed form: two Runge–Kutta steps of 0.02 s, float64 observations (x, θ, v, ω).
pub(crate) fn inverted_pendulum() -> Truth {
    fn field(x: &[f64], u: f64) -> [f64; 4] {
        const CART: f64 = 10.471_975_5;
        const POLE: f64 = 5.018_591_6;
        const LENGTH: f64 = 0.300_000_42;
        const INERTIA: f64 = 0.188_749_77;
        let phi = x[1] + 0.001_666_67;
        let (a, b) = (CART + POLE, POLE * LENGTH * phi.cos());
        let d = INERTIA + POLE * LENGTH * LENGTH;
        let force = 100.0 * u.clamp(-3.0, 3.0) - x[2] + POLE * LENGTH * phi.sin() * x[3] * x[3];
        let torque = -x[3] + POLE * 9.81 * LENGTH * phi.sin();
        let det = a * d - b * b;
        [x[2], x[3], (d * force - b * torque) / det, (a * torque - b * force) / det]
    }
    Truth {
        spec: four_states("inverted-pendulum", Precision::F64, 3.0, 0.04, false),
        step: |x, u| {
            let mut x = x.to_vec();
            let h = 0.02;
            let at = |x: &[f64], k: &[f64; 4], c: f64| x.iter().zip(k).map(|(x, k)| x + c * k).collect::<Vec<_>>();
            for _ in 0..2 {
                let k1 = field(&x, u[0]);
                let k2 = field(&at(&x, &k1, 0.5 * h), u[0]);
                let k3 = field(&at(&x, &k2, 0.5 * h), u[0]);
                let k4 = field(&at(&x, &k3, h), u[0]);
                for i in 0..4 {
                    x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
                }
            }
            x
        },
    }
}

/// A number between `low` and `high`.
pub(crate) fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    use rand::RngExt as _;
    rng.random_range(low..=high)
}

/// Records `steps` steps; `start` gives start states, `control` controls, and `over` says where a rollout ends.
pub(crate) fn record(
    truth: &Truth,
    seed: u64,
    steps: usize,
    start: impl Fn(&mut Rng) -> Vec<f64>,
    control: impl Fn(&mut Rng, usize) -> f64,
    over: fn(&[f64]) -> bool,
) -> Dataset {
    let mut rng = Seed::new(seed).stream("record", 0);
    let spec = &truth.spec;
    let sensors = Sensors::new(spec).expect("every observation shows a state");
    let mut data = Dataset::new(spec.observation_dim(), 1, 1, spec.dt);
    let mut o = vec![0.0; spec.observation_dim()];
    let mut x = Vec::new();
    for i in 0..steps {
        if x.is_empty() || over(&x) {
            x = start(&mut rng);
            sensors.observe(&x, &mut rng, &mut o);
            data.begin(&o).expect("finite");
        }
        let u = control(&mut rng, i);
        x = (truth.step)(&x, &[u]);
        sensors.observe(&x, &mut rng, &mut o);
        data.push(&[u], &[u], 0.0, &o).expect("finite");
    }
    data
}

pub(crate) fn pendulum_data(seed: u64, steps: usize) -> Dataset {
    let start = |rng: &mut Rng| vec![uniform(rng, -3.1, 3.1), uniform(rng, -1.0, 1.0)];
    record(&pendulum(), seed, steps, start, |rng, _| uniform(rng, -2.0, 2.0), |_| false)
}

pub(crate) fn mountain_car_data(seed: u64, steps: usize) -> Dataset {
    let start = |rng: &mut Rng| vec![f64::from(uniform(rng, -0.6, -0.4) as f32), 0.0];
    record(&mountain_car(), seed, steps, start, |rng, _| uniform(rng, -1.0, 1.0), |_| false)
}

/// Pushes in opposite directions with occasional random ones, until the pole falls.
pub(crate) fn cart_pole_data(seed: u64, steps: usize) -> Dataset {
    let start = |rng: &mut Rng| (0..4).map(|_| uniform(rng, -0.05, 0.05)).collect();
    let control = |rng: &mut Rng, i: usize| {
        let sign = if uniform(rng, 0.0, 1.0) < 0.1 { uniform(rng, -1.0, 1.0).signum() } else { 1.0 };
        if i.is_multiple_of(2) { 10.0 * sign } else { -10.0 * sign }
    };
    record(&cart_pole(), seed, steps, start, control, |x| x[2].abs() > 0.209_439_51 || x[0].abs() > 2.4)
}

/// Alternating pushes of random size, until the pole falls.
pub(crate) fn inverted_pendulum_data(seed: u64, steps: usize) -> Dataset {
    let start = |rng: &mut Rng| (0..4).map(|_| uniform(rng, -0.01, 0.01)).collect();
    let control = |rng: &mut Rng, i: usize| {
        let size = uniform(rng, 0.0, 3.0);
        if i.is_multiple_of(2) { size } else { -size }
    };
    record(&inverted_pendulum(), seed, steps, start, control, |x| x[1].abs() > 0.2)
}
