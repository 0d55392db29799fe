//! A two-link acrobot with the masses, lengths and reward of the one in dm_control, whose links are thin there.

use std::f64::consts::PI;
use std::sync::Arc;

use rand::RngExt as _;
use sindyna_core::{Channel, Dynamics, Held, Kind, Precision, Rng, Scheme, Space, Spec, Task, VectorField};

/// Angles from the upright position, the second relative to the first link; the second joint is driven.
pub(crate) struct Acrobot;

impl VectorField for Acrobot {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        const I: f64 = 1.0 / 12.0;
        let (s2, c2) = x[1].sin_cos();
        let h = 0.5 * s2;
        let (m11, m12, m22) = (2.0 * I + 0.25 + 1.0 + 0.25 + c2, I + 0.25 + 0.5 * c2, I + 0.25);
        let (g1, g2) = (14.715 * x[0].sin() + 4.905 * (x[0] + x[1]).sin(), 4.905 * (x[0] + x[1]).sin());
        let f1 = h * (2.0 * x[2] * x[3] + x[3] * x[3]) + g1 - 0.05 * x[2];
        let f2 = -h * x[2] * x[2] + g2 - 0.05 * x[3] + 2.0 * u[0];
        let d = m11 * m22 - m12 * m12;
        x_dot[0] = x[2];
        x_dot[1] = x[3];
        x_dot[2] = (m22 * f1 - m12 * f2) / d;
        x_dot[3] = (m11 * f2 - m12 * f1) / d;
    }
}

pub(crate) fn dynamics() -> Arc<dyn Dynamics> {
    Arc::new(Held::new(Acrobot, Scheme::Rk4 { substeps: 1 }, 0.01))
}

/// 10^−(d − 0.2)² beyond 0.2 m from tip to target, 1 within.
pub(crate) struct Swingup(Spec);

impl Swingup {
    pub(crate) fn new() -> Self {
        let angle = |name| Channel::new(name, "rad", Kind::Angle, 1.0);
        let rate = |name, i| Channel::new(name, "rad/s", Kind::RateOf(i), 1.0);
        let seen = |name, kind| Channel::new(name, "", kind, 1.0);
        let (w, v) = (rate("w1", 0), rate("w2", 1));
        Self(Spec {
            name: "acrobot".into(),
            state: vec![angle("th1"), angle("th2"), w.clone(), v.clone()],
            observation: vec![
                seen("c1", Kind::CosOf(0)),
                seen("s1", Kind::SinOf(0)),
                seen("c2", Kind::CosOf(1)),
                seen("s2", Kind::SinOf(1)),
                w,
                v,
            ],
            control: vec![Channel::new("u", "", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.01,
        })
    }
}

impl Task for Swingup {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn max_steps(&self) -> usize {
        1000
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x.fill(0.0);
        x[..2].iter_mut().for_each(|angle| *angle = rng.random_range(-PI..PI));
    }
    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
        let (first, second) = (next[0].sin_cos(), (next[0] + next[1]).sin_cos());
        let away = (first.0 + second.0).hypot(2.0 - first.1 - second.1);
        10_f64.powf(-(away - 0.2).max(0.0).powi(2))
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}
