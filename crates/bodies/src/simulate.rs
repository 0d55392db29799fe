//! Motions that forces cause.

use nalgebra::{DMatrix, DVector};

use crate::Tree;
use crate::regressor::forces;
use crate::rows::Motion;

/// Runge–Kutta steps for each sample, at least, and their largest length \[s\].
const SUBSTEPS: usize = 2;
const LONGEST: f64 = 0.005;

/// Rounds of Gauss–Newton for a start, and the part of a spread by which slopes are taken.
const STARTS: usize = 2;
const NUDGE: f64 = 1e-4;

/// Accelerations of the joints (n) at positions `q` and rates `v` under the forces `u` (n) for the `parameters` (13 n); `None` where the matrix of masses is singular.
#[must_use]
pub fn accelerations(tree: &Tree, parameters: &[f64], (q, v, u): (&[f64], &[f64], &[f64])) -> Option<Vec<f64>> {
    let none = vec![0.0; tree.len()];
    let at_rest = forces(tree, parameters, (q, v, &none), true);
    let right = DVector::from_iterator(u.len(), u.iter().zip(&at_rest).map(|(u, h)| u - h));
    let found = masses(tree, parameters, q).lu().solve(&right)?;
    found.iter().all(|a| a.is_finite()).then(|| found.iter().copied().collect())
}

/// The matrix of masses M (n, n) at positions `q` (n).
pub(crate) fn masses(tree: &Tree, parameters: &[f64], q: &[f64]) -> DMatrix<f64> {
    let n = tree.len();
    let none = vec![0.0; n];
    let mut masses = DMatrix::zeros(n, n);
    for j in 0..n {
        let mut unit = none.clone();
        unit[j] = 1.0;
        masses.set_column(j, &DVector::from_vec(forces(tree, parameters, (q, &none, &unit), false)));
    }
    masses
}

/// Positions and rates (T + 1, 2 n) from the first sample of `motion` on, under its forces; `None` if they do not stay finite.
#[must_use]
pub fn simulated(tree: &Tree, parameters: &[f64], motion: &Motion) -> Option<DMatrix<f64>> {
    simulated_from(tree, parameters, motion, &first(motion))
}

/// Positions and rates of the first sample (2 n).
fn first(motion: &Motion) -> Vec<f64> {
    motion.positions.row(0).iter().chain(motion.rates.row(0).iter()).copied().collect()
}

/// Positions and rates (2 n) at the beginning of `motion` from which the simulation is nearest to its samples, of which each column has the spread `sizes` (2 n); `None` if it does not stay
/// finite.
pub(crate) fn start_of(tree: &Tree, parameters: &[f64], motion: &Motion, sizes: &[f64]) -> Option<Vec<f64>> {
    let n = tree.len();
    let error = |start: &[f64]| -> Option<DVector<f64>> {
        let x = simulated_from(tree, parameters, motion, start)?;
        let measured = |t: usize, i: usize| if i < n { motion.positions[(t, i)] } else { motion.rates[(t, i - n)] };
        let of = |k: usize| (x[(k / (2 * n), k % (2 * n))] - measured(k / (2 * n), k % (2 * n))) / sizes[k % (2 * n)];
        Some(DVector::from_iterator(x.len(), (0..x.len()).map(of)))
    };
    let mut start = first(motion);
    for _ in 0..STARTS {
        let here = error(&start)?;
        let mut slopes = DMatrix::zeros(here.len(), 2 * n);
        for i in 0..2 * n {
            let mut moved = start.clone();
            let step = NUDGE * sizes[i];
            moved[i] += step;
            slopes.set_column(i, &((error(&moved)? - &here) / step));
        }
        let step = (slopes.transpose() * &slopes).cholesky()?.solve(&(slopes.transpose() * here));
        start.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= step);
    }
    Some(start)
}

/// The same from the positions and rates `start` (2 n) on.
pub(crate) fn simulated_from(tree: &Tree, parameters: &[f64], motion: &Motion, start: &[f64]) -> Option<DMatrix<f64>> {
    let n = tree.len();
    let mut x = start.to_vec();
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
        if !x.iter().all(|v| v.abs() < 1e6) {
            return None;
        }
        all.row_mut(t + 1).copy_from_slice(&x);
    }
    Some(all)
}

/// Samples on each side by which one is smoothed.
const NEAR: usize = 5;

/// Positions and rates (2 n) of sample `at` by the cubic that is nearest to the positions and rates around it.
pub(crate) fn smoothed(motion: &Motion, at: usize) -> Option<Vec<f64>> {
    let (from, to) = (at.saturating_sub(NEAR), (at + NEAR).min(motion.steps()));
    if to - from < 4 {
        return Some(motion.positions.row(at).iter().chain(motion.rates.row(at).iter()).copied().collect());
    }
    let count = to - from + 1;
    let width = motion.times[to] - motion.times[from];
    // In parts of the width: positions, and rates times the width, whose errors are taken to be alike.
    let mut design = DMatrix::zeros(2 * count, 4);
    for k in 0..count {
        let s = (motion.times[from + k] - motion.times[at]) / width;
        design.row_mut(k).copy_from_slice(&[1.0, s, s * s, s * s * s]);
        design.row_mut(count + k).copy_from_slice(&[0.0, 1.0, 2.0 * s, 3.0 * s * s]);
    }
    let square = (design.transpose() * &design).cholesky()?;
    let n = motion.positions.ncols();
    let mut start = vec![0.0; 2 * n];
    for i in 0..n {
        let position = |k: usize| motion.positions[(from + k, i)];
        let rate = |k: usize| width * motion.rates[(from + k, i)];
        let right = DVector::from_iterator(2 * count, (0..count).map(position).chain((0..count).map(rate)));
        let found = square.solve(&(design.transpose() * right));
        (start[i], start[n + i]) = (found[0], found[1] / width);
    }
    Some(start)
}
