//! Motions that forces cause.

use nalgebra::{DMatrix, DVector};

use crate::Tree;
use crate::regressor::forces;
use crate::rows::Motion;

/// Runge–Kutta steps for each sample, at least, and their largest length \[s\].
const SUBSTEPS: usize = 2;
const LONGEST: f64 = 0.005;

/// Accelerations of the joints (n) at positions `q` and rates `v` under the forces `u` (n) for the `parameters` (13 n); `None` where the matrix of masses is singular.
#[must_use]
pub fn accelerations(tree: &Tree, parameters: &[f64], (q, v, u): (&[f64], &[f64], &[f64])) -> Option<Vec<f64>> {
    let n = tree.len();
    let none = vec![0.0; n];
    let at_rest = forces(tree, parameters, (q, v, &none), true);
    let mut masses = DMatrix::zeros(n, n);
    for j in 0..n {
        let mut unit = none.clone();
        unit[j] = 1.0;
        let column = forces(tree, parameters, (q, &none, &unit), false);
        masses.set_column(j, &DVector::from_vec(column));
    }
    let right = DVector::from_iterator(n, u.iter().zip(&at_rest).map(|(u, h)| u - h));
    let found = masses.lu().solve(&right)?;
    found.iter().all(|a| a.is_finite()).then(|| found.iter().copied().collect())
}

/// Positions and rates (T + 1, 2 n) from the first sample of `motion` on, under its forces; `None` if they do not stay finite.
#[must_use]
pub fn simulated(tree: &Tree, parameters: &[f64], motion: &Motion) -> Option<DMatrix<f64>> {
    let n = tree.len();
    let mut x: Vec<f64> = motion.positions.row(0).iter().chain(motion.rates.row(0).iter()).copied().collect();
    let mut all = DMatrix::zeros(motion.steps() + 1, 2 * n);
    all.row_mut(0).copy_from_slice(&x);
    for t in 0..motion.steps() {
        let dt = motion.times[t + 1] - motion.times[t];
        let u: Vec<f64> = motion.forces.row(t).iter().copied().collect();
        let count = SUBSTEPS.max((dt / LONGEST).ceil() as usize);
        let h = dt / count as f64;
        let rates = |x: &[f64]| -> Option<Vec<f64>> {
            let (q, v) = x.split_at(n);
            Some([v, &accelerations(tree, parameters, (q, v, &u))?].concat())
        };
        for _ in 0..count {
            let moved = |by: f64, k: &[f64]| x.iter().zip(k).map(|(x, k)| x + by * k).collect::<Vec<f64>>();
            let k1 = rates(&x)?;
            let k2 = rates(&moved(0.5 * h, &k1))?;
            let k3 = rates(&moved(0.5 * h, &k2))?;
            let k4 = rates(&moved(h, &k3))?;
            x = (0..2 * n).map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])).collect();
        }
        if x.iter().any(|v| !(v.abs() < 1e6)) {
            return None;
        }
        all.row_mut(t + 1).copy_from_slice(&x);
    }
    Some(all)
}
