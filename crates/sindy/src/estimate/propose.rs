//! Linear regressions along a path: which terms each equation may have.

use ndarray::{Array2, Axis, concatenate};

use super::search::Problem;
use crate::Triangle;
use crate::design::{Path, averages, whiten};
use crate::shooting::Flow;
use crate::solve::{Selected, Selection};

/// Part of the noise that is left on a smoothed path.
const SMOOTHED: f64 = 0.5;

/// Rates of errors on the path before anything is known of the equations, in standard deviations of a channel per step.
const UNKNOWN: f64 = 0.2;

/// Operations for each size of an equation.
const BUDGET: u64 = 100_000;

impl Problem<'_> {
    /// The best terms of every equation on `path`, for noise of standard deviations `sigma` (n). `along` are equations found before and
    /// their coefficients, whose derivatives tell what errors of the path do.
    pub(super) fn propose(
        &self,
        path: &Path<'_>,
        sigma: &[f64],
        along: Option<(&Flow, &[f64], &[Array2<f64>])>,
    ) -> Vec<Selected> {
        let theta: Vec<Array2<f64>> =
            self.segments.iter().enumerate().map(|(at, s)| averages(self.terms, s, at, path)).collect();
        let errors = self.errors(sigma, along);
        let solver = self.solver.within(BUDGET);
        (0..self.rates.len())
            .map(|i| {
                if self.rates[i].is_some() {
                    return nothing();
                }
                let choice = self.choice(i);
                let Some(triangle) = self.rows(&theta, &choice, i, sigma, &errors) else { return nothing() };
                let complexity: Vec<u32> = choice.iter().map(|&j| self.terms[j].complexity).collect();
                let selection = Selection { floor: 0.0, complexity: &complexity, region: None };
                solver.solve(&triangle, choice.len(), selection).renumbered(&choice)
            })
            .collect()
    }

    /// Terms equation `i` may have: its own derivative explains itself.
    fn choice(&self, i: usize) -> Vec<usize> {
        (0..self.terms.len()).filter(|&j| self.terms[j].rate != Some(i)).collect()
    }

    /// The triangle of [Θ of `choice` | Δxᵢ/Δt], its rows whitened; `None` if a number is not finite.
    fn rows(
        &self,
        theta: &[Array2<f64>],
        choice: &[usize],
        i: usize,
        sigma: &[f64],
        errors: &[Array2<f64>],
    ) -> Option<Triangle> {
        let mut triangle = Triangle::new(choice.len() + 1);
        for ((segment, theta), errors) in self.segments.iter().zip(theta).zip(errors) {
            let rate = |t: usize| (segment.x[[t + 1, i]] - segment.x[[t, i]]) / segment.dt[t];
            let target = Array2::from_shape_fn((segment.len(), 1), |(t, _)| rate(t));
            let mut rows = concatenate![Axis(1), theta.select(Axis(1), choice), target];
            let extra: Vec<f64> = errors.column(i).to_vec();
            whiten(rows.view_mut(), &vec![sigma[i]; segment.len() + 1], &extra, &segment.dt);
            triangle.push(rows.view()).ok()?;
        }
        Some(triangle)
    }

    /// Standard deviations of what errors of the path add to the rate of each state in each step (T, n).
    fn errors(&self, sigma: &[f64], along: Option<(&Flow, &[f64], &[Array2<f64>])>) -> Vec<Array2<f64>> {
        let n = sigma.len();
        let unknown = |(t, i): (usize, usize), dt: &[f64]| UNKNOWN * sigma[i] / dt[t];
        let Some((flow, xi, x)) = along else {
            let of = |s: &crate::data::Segment| Array2::from_shape_fn((s.len(), n), |at| unknown(at, &s.dt));
            return self.segments.iter().map(of).collect();
        };
        let mut scratch = flow.scratch();
        let width = n + flow.n_parameters();
        let (mut next, mut s) = (vec![0.0; n], vec![0.0; n * width]);
        let mut all = Vec::with_capacity(self.segments.len());
        for (segment, x) in self.segments.iter().zip(x) {
            let mut errors = Array2::zeros((segment.len(), n));
            for t in 0..segment.len() {
                let (now, u) = (x.row(t).to_vec(), segment.u.row(t).to_vec());
                let step = (&now[..], &u[..], segment.dt[t]);
                let finite = flow.step(step, xi, &mut next, Some(&mut s), &mut scratch, &mut |_| {});
                for i in 0..n {
                    let moved = |j: usize| s[i * width + j] - if i == j { 1.0 } else { 0.0 };
                    let through = (0..n).map(|j| (moved(j) * SMOOTHED * sigma[j]).powi(2)).sum::<f64>().sqrt();
                    errors[[t, i]] = if finite { through / segment.dt[t] } else { unknown((t, i), &segment.dt) };
                }
            }
            all.push(errors);
        }
        all
    }
}

/// An equation without terms.
fn nothing() -> Selected {
    Selected {
        support: Vec::new(),
        coefficients: Vec::new(),
        residual: 0.0,
        reached_floor: true,
        proved: false,
        path: Vec::new(),
        ties: Vec::new(),
    }
}
