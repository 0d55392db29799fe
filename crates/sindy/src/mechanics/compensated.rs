//! Momenta with noise: regressions without what noise adds to them.
//!
//! Rows of joints that no input acts on have no other side: with noise in their columns, coefficients of zero leave least of them. The ratio of what parameters leave to what noise makes of it has no
//! such minimum.

use nalgebra::DMatrix;
use ndarray::Array2;
use rand::RngExt as _;
use rand_distr::StandardNormal;
use sindyna_core::Seed;

use super::balance::{Steps, balance};
use super::elimination::eliminated;
use crate::Triangle;
use crate::data::Segment;
use crate::library::Lagrangian;

/// Samples of the noise.
const DRAWS: u64 = 8;

/// Times the rows of each joint are weighed by their noise.
const WEIGHINGS: usize = 3;

/// Part of a product of columns that is added to it, so that columns that depend on each other have coefficients.
const RIDGE: f64 = 1e-10;

/// Products of the columns that the parameters of a Lagrangian have in balanced momenta.
pub(super) struct Compensated<'a> {
    lagrangian: &'a Lagrangian,
    /// Per joint (P, P).
    products: Vec<DMatrix<f64>>,
    /// Per joint, what noise adds to them (P, P).
    added: Vec<DMatrix<f64>>,
    /// Rows of a joint that have no sample in common.
    count: f64,
}

/// Parameters with their values, the first of them the unit of the others.
pub(super) struct Set {
    pub(super) chosen: Vec<usize>,
    pub(super) values: Vec<f64>,
    /// −2 ln L and the price of the parameters.
    pub(super) score: f64,
}

impl<'a> Compensated<'a> {
    /// Momenta over `segments`, whose samples have errors of the standard deviations `sigma` (n), added up over windows of so many steps.
    pub(super) fn new(
        lagrangian: &'a Lagrangian,
        (segments, sigma): (&[Segment], &[f64]),
        (at_once, window): (bool, usize),
    ) -> Self {
        let (n_joints, n_parameters) = (lagrangian.joints.len(), lagrangian.parameters.len());
        let none = || vec![DMatrix::zeros(n_parameters, n_parameters); n_joints];
        let (mut products, mut added, mut count) = (none(), none(), 0.0);
        let mut rng = Seed::new(0).stream("momenta", 0);
        for segment in segments {
            let u = segment.mean_inputs();
            let rows = |x: &Array2<f64>| -> Vec<DMatrix<f64>> {
                let steps = Steps { x: x.view(), u: u.view(), dt: &segment.dt };
                balance(lagrangian, steps, at_once).iter().map(|rows| windowed(rows, window)).collect()
            };
            let seen = rows(&segment.x);
            products.iter_mut().zip(&seen).for_each(|(sum, rows)| *sum += rows.transpose() * rows);
            for _ in 0..DRAWS {
                let mut x = segment.x.clone();
                for mut sample in x.rows_mut() {
                    let errors = sample.iter_mut().zip(sigma);
                    errors.for_each(|(x, sigma)| *x += sigma * rng.sample::<f64, _>(StandardNormal));
                }
                for (sum, (noisy, seen)) in added.iter_mut().zip(rows(&x).iter().zip(&seen)) {
                    let moved = noisy - seen;
                    *sum += moved.transpose() * &moved / DRAWS as f64;
                }
            }
            count += seen.first().map_or(0, DMatrix::nrows) as f64 / window as f64;
        }
        Self { lagrangian, products, added, count }
    }

    /// Sets of parameters beside `unit`, from all to one, the likeliest first.
    ///
    /// # References
    /// Van Huffel, Vandewalle (1991), The Total Least Squares Problem, SIAM, chapter 8: errors with a known covariance.
    pub(super) fn sets(&self, unit: usize) -> Option<Vec<Set>> {
        let others = self.lagrangian.others(unit);
        let all: Vec<usize> = others.iter().copied().chain([unit]).collect();
        let of = |matrix: &DMatrix<f64>| DMatrix::from_fn(all.len(), all.len(), |i, j| matrix[(all[i], all[j])]);
        let products: Vec<DMatrix<f64>> = self.products.iter().map(of).collect();
        let added: Vec<DMatrix<f64>> = self.added.iter().map(of).collect();
        let mut weights: Vec<f64> = products.iter().map(|p| 1.0 / p.trace()).collect();
        let mut least = None;
        for _ in 0..WEIGHINGS {
            if weights.iter().any(|w| !w.is_finite()) {
                return None;
            }
            let (seen, noise) = (weighed(&products, &weights), weighed(&added, &weights));
            let scale: Vec<f64> = seen.diagonal().iter().map(|s| if *s > 0.0 { 1.0 / s.sqrt() } else { 0.0 }).collect();
            let scaled =
                |m: &DMatrix<f64>| DMatrix::from_fn(all.len(), all.len(), |i, j| scale[i] * scale[j] * m[(i, j)]);
            let (seen, noise) = (scaled(&seen), scaled(&noise));
            let lower = (&seen + DMatrix::identity(all.len(), all.len()) * RIDGE).cholesky()?.l();
            let half = lower.solve_lower_triangular(&noise)?;
            let whole = lower.solve_lower_triangular(&half.transpose())?;
            let eigen = whole.symmetric_eigen();
            let at = eigen.eigenvalues.imax();
            let part = 1.0 / eigen.eigenvalues[at];
            let theta = lower.transpose().solve_upper_triangular(&eigen.eigenvectors.column(at).into_owned())?;
            let theta = theta.component_mul(&nalgebra::DVector::from_column_slice(&scale));
            weights = added.iter().map(|a| 1.0 / (theta.transpose() * a * &theta)[(0, 0)]).collect();
            least = (part > 0.0).then_some((&seen - noise * part.min(1.0), scale));
        }
        let (left, scale) = least?;
        // Its square root is as good as rows.
        let eigen = left.symmetric_eigen();
        let target = others.len();
        let entry = |(i, j): (usize, usize)| {
            let sign = if j == target { -1.0 } else { 1.0 };
            sign * eigen.eigenvalues[i].max(0.0).sqrt() * eigen.eigenvectors[(j, i)]
        };
        let mut triangle = Triangle::new(all.len());
        triangle.push(Array2::from_shape_fn((all.len(), all.len()), entry).view()).ok()?;
        let set = |columns: &[usize], values: &[f64]| {
            let values = columns.iter().zip(values).map(|(&c, value)| value * scale[c] / scale[target]);
            let values: Vec<f64> = std::iter::once(1.0).chain(values).collect();
            let chosen: Vec<usize> = std::iter::once(unit).chain(columns.iter().map(|&c| others[c])).collect();
            let score = self.score(&chosen, &values);
            score.is_finite().then_some(Set { chosen, values, score })
        };
        let path = eliminated(&triangle, &vec![0.0; target]);
        let mut sets: Vec<Set> = path.iter().filter_map(|size| set(&size.columns, &size.values)).collect();
        sets.sort_by(|one, other| one.score.total_cmp(&other.score));
        Some(sets)
    }

    /// −2 ln L of the `values` of the parameters `chosen`, but for a constant, and their price.
    fn score(&self, chosen: &[usize], values: &[f64]) -> f64 {
        let square = |m: &DMatrix<f64>| -> f64 {
            let row = |(i, v): (&usize, &f64)| chosen.iter().zip(values).map(|(j, w)| v * w * m[(*i, *j)]).sum::<f64>();
            chosen.iter().zip(values).map(row).sum()
        };
        let joints = self.products.iter().zip(&self.added);
        let left: f64 = joints.map(|(seen, added)| self.count * (square(seen) / square(added)).ln()).sum();
        left + chosen.len() as f64 * (self.count * self.products.len() as f64).ln()
    }
}

fn weighed(matrices: &[DMatrix<f64>], weights: &[f64]) -> DMatrix<f64> {
    let zero = DMatrix::zeros(matrices[0].nrows(), matrices[0].ncols());
    matrices.iter().zip(weights).fold(zero, |sum, (m, w)| sum + m * *w)
}

/// Rows added up over windows of that many steps with a weight that vanishes smoothly at both ends; the rows themselves for one step.
fn windowed(rows: &Array2<f64>, window: usize) -> DMatrix<f64> {
    if window <= 1 {
        return DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[[i, j]]);
    }
    let weight = |t: usize| {
        let s = 2.0 * (t as f64 + 1.0) / (window as f64 + 1.0) - 1.0;
        (1.0 - s * s).powi(3)
    };
    let weights: Vec<f64> = (0..window).map(weight).collect();
    let starts = (rows.nrows() + 1).saturating_sub(window);
    let entry = |i: usize, j: usize| weights.iter().enumerate().map(|(t, w)| w * rows[[i + t, j]]).sum();
    DMatrix::from_fn(starts, rows.ncols(), entry)
}
