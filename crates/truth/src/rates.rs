//! The true rates over a system's box, and how far a model's are from them.

use sindyna_core::{Kind, Region, Seed, VectorField as _};
use sindyna_envs::System;
use sindyna_sindy::Model;

/// States and controls drawn uniformly from the box of a system (declared bounds, else typical magnitudes; controls from
/// their bounds), with the true rates there.
#[derive(Debug, Clone)]
pub struct Truth {
    /// z = (x; u), one row per point.
    points: Vec<Vec<f64>>,
    /// ẋ, one row per point.
    rates: Vec<Vec<f64>>,
    /// Standard deviation of each rate over the box; none for states whose rate is a state, which are not judged.
    spreads: Vec<Option<f64>>,
}

/// How far a model's rates are from the true ones, as parts of the spread of each true rate; the worst equation counts.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Deviation {
    /// Largest difference on any point.
    pub worst: f64,
    /// Root of the mean of squared differences.
    pub rms: f64,
}

impl Truth {
    /// `count` points in the box of `system`.
    #[must_use]
    pub fn of(system: &System, count: usize) -> Self {
        let spec = system.spec();
        let (states, controls) = (Region::of(spec), Region::of(&of_controls(spec)));
        let (n, mut rng) = (spec.state_dim(), Seed::new(99).stream("box", 0));
        let (mut points, mut rates) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let field = system.rates();
        for _ in 0..count {
            let (mut z, mut x_dot) = (vec![0.0; n + spec.control_dim()], vec![0.0; n]);
            states.sample(&mut rng, &mut z[..n]);
            controls.sample(&mut rng, &mut z[n..]);
            field.eval(&z[..n], &z[n..], &mut x_dot);
            points.push(z);
            rates.push(x_dot);
        }
        let kinematic = |i: usize| spec.state.iter().any(|s| s.kind == Kind::RateOf(i));
        let spread = |i: usize| (!kinematic(i)).then(|| deviation(rates.iter().map(|row| row[i])));
        let spreads = (0..n).map(spread).collect();
        Self { points, rates, spreads }
    }

    /// The first `count` points, with the rates there.
    pub(crate) fn rows(&self, count: usize) -> impl Iterator<Item = (&[f64], &[f64])> {
        self.points.iter().zip(&self.rates).map(|(z, r)| (z.as_slice(), r.as_slice())).take(count)
    }

    /// Equations that are judged, with the spread of their rates.
    pub fn judged(&self) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        self.spreads.iter().enumerate().filter_map(|(i, s)| s.map(|s| (i, s)))
    }

    /// How far the rates of `model`, whose states are those of the system, are from the truth.
    #[must_use]
    pub fn deviation(&self, model: &Model) -> Deviation {
        let n = self.spreads.len();
        let (mut worst, mut squares, mut x_dot) = (vec![0.0_f64; n], vec![0.0; n], vec![0.0; n]);
        for (z, rates) in self.points.iter().zip(&self.rates) {
            model.eval(&z[..n], &z[n..], &mut x_dot);
            for i in 0..n {
                let error = (x_dot[i] - rates[i]).abs();
                // A rate that is no number is as wrong as can be.
                worst[i] = worst[i].max(if error.is_nan() { f64::INFINITY } else { error });
                squares[i] += error * error;
            }
        }
        let points = self.points.len() as f64;
        let most = |of: &dyn Fn(usize) -> f64| {
            self.judged()
                .map(|(i, spread)| of(i) / spread)
                .fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
        };
        Deviation { worst: most(&|i| worst[i]), rms: most(&|i| (squares[i] / points).sqrt()) }
    }
}

/// The spec whose states are the controls of `spec`, so that controls are drawn as states are.
fn of_controls(spec: &sindyna_core::Spec) -> sindyna_core::Spec {
    sindyna_core::Spec { state: spec.control.clone(), observation: Vec::new(), ..spec.clone() }
}

/// Standard deviation of `values`.
fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}
