//! Parameters of a Lagrangian fitted to steps.

use ndarray::Array2;

use super::mechanism::Mechanism;
use crate::Triangle;
use crate::library::Lagrangian;
use crate::motion::{Run, Stepping};

/// Parts of a Gauss–Newton step that are tried, one after the other.
const PARTS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.02];

/// Singular values of scaled columns below this part of the largest are taken as zero.
const CUTOFF: f64 = 1e-12;

/// Part of a residual by which an iteration must lessen it to be followed by another.
const GAIN: f64 = 0.1;

/// Steps that one Lagrangian is to explain.
#[derive(Clone, Copy)]
pub(super) struct Data<'a> {
    pub(super) lagrangian: &'a Lagrangian,
    pub(super) runs: &'a [Run],
    pub(super) dt: f64,
}

/// Parameters with their values; the first of them is the unit of the others.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) chosen: Vec<usize>,
    pub(super) values: Vec<f64>,
    pub(super) stepping: Stepping,
    /// RMS of the errors of one step, each as part of what the errors of the samples explain.
    pub(super) rms: f64,
}

impl Data<'_> {
    /// `values` of the parameters `chosen` fitted in so many rounds of Gauss–Newton. `None` where the steps cannot be followed.
    pub(super) fn fitted(&self, chosen: &[usize], values: Vec<f64>, stepping: Stepping, rounds: usize) -> Option<Fit> {
        let mechanism = self.mechanism(chosen);
        let (mut triangle, mut rms) = self.linearised(&mechanism, &values, stepping)?;
        let mut values = values;
        let all: Vec<usize> = (0..chosen.len() - 1).collect();
        for _ in 0..rounds {
            let target = all.len();
            let length = |j: usize| triangle.norm(j).max(f64::MIN_POSITIVE);
            let step = triangle.solve_truncated(&all, target, CUTOFF, length);
            let tried = PARTS.iter().find_map(|part| {
                let mut moved = values.clone();
                moved[1..].iter_mut().zip(&step).enumerate().for_each(|(j, (v, d))| *v += part * d / length(j));
                let (triangle, left) = self.linearised(&mechanism, &moved, stepping)?;
                (left < rms).then_some((triangle, left, moved))
            });
            let Some((next, left, moved)) = tried else { break };
            let is_last = left > (1.0 - GAIN) * rms;
            (triangle, rms, values) = (next, left, moved);
            if is_last {
                break;
            }
        }
        Some(Fit { chosen: chosen.to_vec(), values, stepping, rms })
    }

    /// Errors of one step, linear in the parameters beside the first near `values`: the columns of their changes, and last what is left; and the RMS of that.
    pub(super) fn linearised(
        &self,
        mechanism: &Mechanism,
        values: &[f64],
        stepping: Stepping,
    ) -> Option<(Triangle, f64)> {
        let n_free = values.len() - 1;
        let mut triangle = Triangle::new(n_free + 1);
        let (mut squares, mut count) = (0.0, 0);
        for run in self.runs {
            let n = run.x.ncols();
            let mut rows = Array2::zeros((run.len() * n, n_free + 1));
            for t in 0..run.len() {
                let (x, u) = (run.x.row(t).to_vec(), run.u.row(t).to_vec());
                let flight = mechanism.step(mechanism.start(&x), &u, values, self.dt, stepping)?;
                for i in 0..n {
                    let sigma = run.sigma[[t, i]].hypot(run.sigma[[t + 1, i]]).max(f64::MIN_POSITIVE);
                    let mut row = rows.row_mut(t * n + i);
                    (0..n_free).for_each(|p| row[p] = flight.changes(i)[1 + p] / sigma);
                    row[n_free] = (run.x[[t + 1, i]] - flight.state(i)) / sigma;
                    squares += row[n_free].powi(2);
                    count += usize::from((flight.state(i) - run.x[[t, i]]).abs() > 0.0);
                }
            }
            triangle.push(rows.view()).ok()?;
        }
        let rms = (squares / f64::max(count as f64, 1.0)).sqrt();
        rms.is_finite().then_some((triangle, rms))
    }

    /// The equations with the parameters `chosen`.
    pub(super) fn mechanism(&self, chosen: &[usize]) -> Mechanism {
        let dims = self.runs.first().map_or((0, 0), |run| (run.x.ncols(), run.u.ncols()));
        Mechanism::new(self.lagrangian, chosen, dims)
    }

    /// Steps times joints: rows that tell parameters.
    pub(super) fn rows(&self) -> usize {
        self.runs.iter().map(Run::len).sum::<usize>() * self.lagrangian.joints.len()
    }
}
