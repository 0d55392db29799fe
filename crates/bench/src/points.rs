//! True rates at points of a system's box, and whether an equation is true there.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq as _;
use sindyna_core::{Rng, VectorField};

use crate::equations::{Compiled, Equations};
use rand::Rng as _;

/// RMS of what true terms leave of a rate, as part of its spread: rounding alone.
const EXPLAINED: f64 = 1e-9;

/// RMS of a summand, or of what a term has of its own beside the others, as part of the whole, below which it is not needed.
const SUPERFLUOUS: f64 = 1e-7;

/// Difference of two terms, as part of one of them, below which they are the same.
const SAME: f64 = 1e-9;

/// States and inputs z = (x; u) drawn uniformly from a box, with the true rates there.
#[derive(Debug, Clone)]
pub struct Points {
    rows: Vec<(Vec<f64>, Vec<f64>)>,
    /// Standard deviation of each rate.
    spreads: Vec<f64>,
}

/// Whether the true rates satisfy an equation.
#[derive(Debug, Clone, PartialEq)]
pub enum Structure {
    /// They do, with exactly one set of coefficients, none of which is zero.
    True(Vec<f64>),
    /// They do, but not all terms are needed.
    Wider,
    /// They do not.
    Other,
}

impl Points {
    /// `count` points between the corners `low` and `high`, at which `field` is finite.
    #[must_use]
    pub fn new(field: &dyn VectorField, n: usize, low: &[f64], high: &[f64], count: usize, rng: &mut Rng) -> Self {
        let mut rows = Vec::with_capacity(count);
        // Outside the domain of a root or a logarithm there is nothing to compare.
        for _ in 0..20 * count {
            let unit = |rng: &mut Rng| (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            let z: Vec<f64> = low.iter().zip(high).map(|(l, h)| l + (h - l) * unit(rng)).collect();
            let mut rates = vec![0.0; n];
            field.eval(&z[..n], &z[n..], &mut rates);
            if rates.iter().all(|r| r.is_finite()) {
                rows.push((z, rates));
            }
            if rows.len() == count {
                break;
            }
        }
        let spread = |i: usize| {
            let mean = rows.iter().map(|(_, r)| r[i]).sum::<f64>() / rows.len() as f64;
            rms(rows.iter().map(|(_, r)| r[i] - mean))
        };
        let spreads = (0..n).map(spread).collect();
        Self { rows, spreads }
    }

    /// Values of a term at all points.
    pub(crate) fn column(&self, term: &Compiled) -> Vec<f64> {
        self.rows.iter().map(|(z, rates)| term.value(z, rates)).collect()
    }

    /// Whether two terms are the same but for a factor.
    pub(crate) fn same(&self, a: &Compiled, b: &Compiled) -> bool {
        let (a, b) = (self.column(a), self.column(b));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let factor = dot(&a, &b) / dot(&b, &b);
        rms(a.iter().zip(&b).map(|(a, b)| a - factor * b)) < SAME * rms(a.iter().copied())
    }

    /// Whether the true rate of state `i` is a sum of `terms` with some coefficients. Implicit equations have many true forms: any
    /// counts.
    pub(crate) fn structure(&self, i: usize, terms: &[Compiled]) -> Structure {
        if terms.is_empty() {
            return Structure::Other;
        }
        let columns: Vec<Vec<f64>> = terms.iter().map(|t| self.column(t)).collect();
        let norms: Vec<f64> = columns.iter().map(|c| c.iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
        if norms.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
            return Structure::Other;
        }
        let a = Mat::from_fn(self.rows.len(), columns.len(), |row, j| columns[j][row] / norms[j]);
        let b = Mat::from_fn(self.rows.len(), 1, |row, _| self.rows[row].1[i]);
        let qr = a.qr();
        let r = qr.thin_R();
        if (0..r.ncols()).any(|j| r[(j, j)].abs() < SUPERFLUOUS) {
            return Structure::Wider;
        }
        let x = qr.solve_lstsq(&b);
        let left = &b - &a * &x;
        let spread = self.spreads[i];
        let unexplained = rms((0..self.rows.len()).map(|row| left[(row, 0)]));
        if unexplained.is_nan() || unexplained >= EXPLAINED * spread {
            return Structure::Other;
        }
        // The columns are of unit length, so that a summand's RMS is its coefficient over √N.
        let points = self.rows.len() as f64;
        if (0..columns.len()).any(|j| x[(j, 0)].abs() / points.sqrt() < SUPERFLUOUS * spread) {
            return Structure::Wider;
        }
        Structure::True((0..columns.len()).map(|j| x[(j, 0)] / norms[j]).collect())
    }

    /// RMS error of the rates of `equations`, as part of the spread of the true ones, for the worst of `states`; infinite where
    /// they are not finite.
    pub(crate) fn deviation(&self, equations: &Equations, states: impl Iterator<Item = usize> + Clone) -> f64 {
        let found = |(z, rates): &(Vec<f64>, Vec<f64>)| {
            let mut x_dot = vec![0.0; rates.len()];
            equations.eval(&z[..rates.len()], &z[rates.len()..], &mut x_dot);
            x_dot
        };
        let rates: Vec<Vec<f64>> = self.rows.iter().map(found).collect();
        let of = |i: usize| rms(rates.iter().zip(&self.rows).map(|(f, (_, t))| f[i] - t[i])) / self.spreads[i];
        states.map(of).fold(0.0, |worst, d| if d.is_nan() { f64::INFINITY } else { worst.max(d) })
    }
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|v| v * v).sum::<f64>() / count).sqrt()
}
