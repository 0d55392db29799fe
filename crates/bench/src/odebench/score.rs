//! What a prediction is worth.

use ndarray::{Array2, Axis, aview1, concatenate};
use sindyna_core::{Dynamics, Seed};

use super::Problem;
use crate::equations::{Equations, Term};
use crate::points::{Points, Structure};

/// Points at which the symbolic form is compared.
const POINTS: usize = 500;

/// States (T, n) from `start` by steps of `dynamics`; none if they do not stay finite.
#[must_use]
pub fn simulate(dynamics: &dyn Dynamics, start: &[f64], samples: usize) -> Option<Array2<f64>> {
    let (mut x, mut next) = (start.to_vec(), start.to_vec());
    let (mut states, mut rng) = (Array2::zeros((samples, start.len())), Seed::new(0).numpy());
    for row in 0..samples {
        states.row_mut(row).assign(&aview1(&x));
        dynamics.step(&x, &[], &mut rng, &mut next).ok()?;
        std::mem::swap(&mut x, &mut next);
    }
    Some(states)
}

/// R² over all states, each weighted with its variance: 1 − Σ(x − x̂)²/Σ(x − x̄)².
#[must_use]
pub fn r_squared(truth: &Array2<f64>, predicted: &Array2<f64>) -> f64 {
    let mean = truth.sum_axis(Axis(0)) / truth.nrows() as f64;
    let squares = |a: Array2<f64>| a.iter().map(|v| v * v).sum::<f64>();
    1.0 - squares(truth - predicted) / squares(truth - &mean)
}

/// Whether the true rates satisfy every equation found with exactly one set of coefficients, none of them zero, over the box of
/// both trajectories; and the RMS error of the rates there, as part of their spread, in the worst equation.
///
/// # Errors
/// If a term cannot be read.
pub fn compared(
    problem: &Problem,
    found: &[Vec<Term>],
    trajectories: [&Array2<f64>; 2],
) -> anyhow::Result<(bool, f64)> {
    let n = found.len();
    let all = concatenate![Axis(0), *trajectories[0], *trajectories[1]];
    let corner = |of: fn(f64, f64) -> f64| all.fold_axis(Axis(0), f64::NAN, move |&a, &b| of(a, b)).to_vec();
    let (low, high) = (corner(f64::min), corner(f64::max));
    let points = Points::new(&problem.equations, n, &low, &high, POINTS, &mut Seed::new(0).stream("box", 0));
    let names: Vec<String> = (0..n).map(|i| format!("x_{i}")).collect();
    let compiled = Equations::new(found, &names)?;
    let recovered = (0..n).all(|i| matches!(points.structure(i, compiled.row(i)), Structure::True(_)));
    Ok((recovered, points.deviation(&compiled, 0..n)))
}
