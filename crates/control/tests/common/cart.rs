//! A cart of 1 kg with poles of 1 m and 0.1 kg, one on the other, that are thin, and rewards as in dm_control.

use std::f64::consts::PI;
use std::sync::Arc;

use rand::RngExt as _;
use sindyna_core::{Bounded, Channel, Dynamics, Held, Kind, Precision, Rng, Scheme, Space, Spec, Task, VectorField};

const MOST: usize = 3;
const G: f64 = 9.81;
const CART: f64 = 1.0;
const POLE: f64 = 0.1;
const LENGTH: f64 = 1.0;

/// So many poles; angles from upright, each relative to the one below.
struct Cart(usize);

impl VectorField for Cart {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (poles, size) = (self.0, self.0 + 1);
        // From the foot of pole j to the middle of pole i, along pole j.
        let arm = |i: usize, j: usize| LENGTH * [1.0, 0.5, 0.0][usize::from(j >= i) + usize::from(j > i)];
        let sum = |of: &dyn Fn(usize) -> f64| (0..poles).map(|i| POLE * of(i)).sum::<f64>();
        let (mut angle, mut rate) = ([0.0; MOST], [0.0; MOST]);
        for j in 0..poles {
            angle[j] = x[1 + j] + if j > 0 { angle[j - 1] } else { 0.0 };
            rate[j] = x[size + 1 + j] + if j > 0 { rate[j - 1] } else { 0.0 };
        }
        // Masses, with forces in the last column.
        let mut m = [[0.0; MOST + 2]; MOST + 1];
        (m[0][0], m[0][size]) = (CART + poles as f64 * POLE, 10.0 * u[0]);
        for j in 0..poles {
            let one = sum(&|i| arm(i, j));
            (m[0][1 + j], m[1 + j][0]) = (one * angle[j].cos(), one * angle[j].cos());
            m[0][size] += one * angle[j].sin() * rate[j].powi(2);
            m[1 + j][size] = one * G * angle[j].sin();
            for k in 0..poles {
                let both = sum(&|i| arm(i, j) * arm(i, k));
                let own = if j == k { POLE * LENGTH * LENGTH / 12.0 } else { 0.0 };
                m[1 + j][1 + k] = both * (angle[j] - angle[k]).cos() + own;
                m[1 + j][size] -= both * (angle[j] - angle[k]).sin() * rate[k].powi(2);
            }
        }
        for c in 0..size {
            for r in (0..size).filter(|r| *r != c) {
                let part = m[r][c] / m[c][c];
                (c..=size).for_each(|k| m[r][k] -= part * m[c][k]);
            }
        }
        let absolute = |j: usize| m[j][size] / m[j][j];
        for j in 0..size {
            x_dot[j] = x[size + j];
            x_dot[size + j] = absolute(j) - if j > 1 { absolute(j - 1) } else { 0.0 };
        }
    }
}

/// Poles up from hanging at rest; paid for each by how upright it is, or only where all of them and the cart are in place.
pub(crate) struct Upright {
    spec: Spec,
    poles: usize,
    sparse: bool,
}

impl Upright {
    pub(crate) fn new(poles: usize, sparse: bool) -> Self {
        let plain = |name: &str, kind| Channel::new(name, "", kind, 1.0);
        let each = |of: &dyn Fn(usize) -> Channel| (1..=poles).map(of).collect::<Vec<_>>();
        let cart = plain("x", Kind::Plain).within(-1.8, 1.8);
        let rates = [vec![plain("v", Kind::RateOf(0))], each(&|j| plain(&format!("w{j}"), Kind::RateOf(j)))].concat();
        let angles = each(&|j| plain(&format!("th{j}"), Kind::Angle));
        let cosines = each(&|j| plain(&format!("c{j}"), Kind::CosOf(j)));
        let sines = each(&|j| plain(&format!("s{j}"), Kind::SinOf(j)));
        let spec = Spec {
            name: "poles".into(),
            state: [vec![cart.clone()], angles, rates.clone()].concat(),
            observation: [vec![cart], cosines, sines, rates].concat(),
            control: vec![plain("u", Kind::Plain)],
            action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.01,
        };
        Self { spec, poles, sparse }
    }

    pub(crate) fn dynamics(&self) -> Arc<dyn Dynamics> {
        let held = Held::new(Cart(self.poles), Scheme::Rk4 { substeps: 1 }, self.spec.dt);
        Arc::new(Bounded::new(held, &self.spec.state))
    }
}

impl Task for Upright {
    fn spec(&self) -> &Spec {
        &self.spec
    }
    fn max_steps(&self) -> usize {
        1000
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x.iter_mut().for_each(|x| *x = rng.random_range(-0.0173..0.0173));
        x[1] += PI;
        x[2..=self.poles].iter_mut().for_each(|angle| *angle *= 10.0);
    }
    fn reward(&self, _x: &[f64], _action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        let near = |x: f64, margin: f64| 0.1_f64.powf((x / margin).powi(2));
        let mut angle = 0.0;
        let up: Vec<f64> = next[1..=self.poles]
            .iter()
            .map(|relative| {
                angle += relative;
                angle.cos()
            })
            .collect();
        if self.sparse {
            return f64::from(u8::from(up.iter().all(|up| *up >= 0.995) && next[0].abs() <= 0.25));
        }
        let upright = up.iter().map(|up| (1.0 + up) / 2.0).sum::<f64>() / up.len() as f64;
        let slow = next[self.poles + 2..].iter().map(|rate| near(*rate, 5.0)).fold(1.0, f64::min);
        upright * (1.0 + near(next[0], 2.0)) / 2.0 * (4.0 + (1.0 - u[0] * u[0]).max(0.0)) / 5.0 * (1.0 + slow) / 2.0
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}
