//! Parameters fitted to pieces, each from a start of its own.

use nalgebra::{DMatrix, DVector};

use super::cut::Piece;
use super::grouped::{half, loss, weights};
use crate::Watch;
use crate::model::Model;

/// Part of the loss below which a round has settled.
const SETTLED: f64 = 1e-4;

/// Trials of the damping in a round.
const TRIALS: usize = 6;

/// Part of the largest parameter, or of the spread of a state, by which derivatives are taken.
const NUDGE: f64 = 1e-6;

/// Equations fitted to pieces.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    /// Parameters, the unit first.
    pub(super) theta: Vec<f64>,
    /// Per piece, the state at its start.
    pub(super) starts: Vec<Vec<f64>>,
    /// Per state, the size of its residuals in most pieces.
    pub(super) sigma: Vec<f64>,
    /// Per piece: mean square of its residuals over those, infinite where it diverges.
    pub(super) misfits: Vec<f64>,
    pub(super) weights: Vec<f64>,
}

/// The model at some parameters; `None` where there is none.
pub(super) type At<'a> = &'a dyn Fn(&[f64]) -> Option<Model>;

/// What is fitted.
#[derive(Clone, Copy)]
pub(super) struct Data<'a> {
    pub(super) pieces: &'a [Piece],
    /// Whether each state was measured (n).
    pub(super) measured: &'a [bool],
    /// The smallest size of residuals of each state that is believed (n).
    pub(super) floor: &'a [f64],
    /// Standard deviation of each state (n).
    pub(super) spread: &'a [f64],
    pub(super) watch: &'a Watch<'a>,
}

/// Residuals of one piece, and what they change with parameters and start.
pub(super) struct Slopes {
    pub(super) residuals: DVector<f64>,
    pub(super) by_theta: DMatrix<f64>,
    pub(super) by_start: DMatrix<f64>,
}

impl Data<'_> {
    /// What most pieces leave by `fitted`, as a part of the spread of each measured state: the largest.
    pub(super) fn left(&self, fitted: &Fitted) -> f64 {
        let parts = fitted.sigma.iter().zip(self.spread).zip(self.measured);
        let moving = parts.filter(|((_, spread), measured)| **measured && **spread > 0.0);
        moving.map(|((s, spread), _)| s / spread).fold(0.0, f64::max)
    }

    /// Residuals of the measured states of `piece` over `sigma`, cell by cell, after a start; `None` where the model diverges.
    fn residuals(&self, model: &Model, piece: &Piece, start: &[f64], sigma: &[f64]) -> Option<Vec<f64>> {
        let x = model.along(start, &piece.u, &piece.dt)?;
        let mut residuals = Vec::with_capacity(x.len());
        for (simulated, measured) in x.rows().into_iter().zip(piece.x.rows()) {
            for i in (0..sigma.len()).filter(|&i| self.measured[i]) {
                residuals.push((simulated[i] - measured[i]) / sigma[i]);
            }
        }
        Some(residuals)
    }

    /// Mean squares of the residuals of all pieces.
    pub(super) fn misfits(&self, model: Option<&Model>, starts: &[Vec<f64>], sigma: &[f64]) -> Vec<f64> {
        let of = |(piece, start): (&Piece, &Vec<f64>)| {
            let residuals = model.and_then(|model| self.residuals(model, piece, start, sigma));
            residuals.map_or(f64::INFINITY, |r| r.iter().map(|v| v * v).sum::<f64>() / r.len().max(1) as f64)
        };
        self.pieces.iter().zip(starts).map(of).collect()
    }

    /// The slopes of each piece by the parameters `free`, each changed by at least the part `least` of its own; none where it diverges.
    pub(super) fn slopes(
        &self,
        at: At<'_>,
        (theta, starts, sigma): (&[f64], &[Vec<f64>], &[f64]),
        free: &[usize],
        least: f64,
    ) -> Vec<Option<Slopes>> {
        let Some(model) = at(theta) else { return self.pieces.iter().map(|_| None).collect() };
        let largest = theta.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let step = |j: usize| (NUDGE * largest).max(least * theta[j].abs());
        let nudged: Vec<Option<Model>> = free
            .iter()
            .map(|&j| {
                let mut theta = theta.to_vec();
                theta[j] += step(j);
                at(&theta)
            })
            .collect();
        let n = sigma.len();
        let of = |(piece, start): (&Piece, &Vec<f64>)| {
            let base = self.residuals(&model, piece, start, sigma)?;
            let mut by_theta = DMatrix::zeros(base.len(), free.len());
            let mut by_start = DMatrix::zeros(base.len(), n);
            for (j, (nudged, free)) in nudged.iter().zip(free).enumerate() {
                let moved = self.residuals(nudged.as_ref()?, piece, start, sigma)?;
                (0..base.len()).for_each(|r| by_theta[(r, j)] = (moved[r] - base[r]) / step(*free));
            }
            for i in 0..n {
                let h = NUDGE * self.spread[i];
                let mut start = start.clone();
                start[i] += h;
                let moved = self.residuals(&model, piece, &start, sigma)?;
                (0..base.len()).for_each(|r| by_start[(r, i)] = (moved[r] - base[r]) / h);
            }
            Some(Slopes { residuals: DVector::from_vec(base), by_theta, by_start })
        };
        self.pieces.iter().zip(starts).map(|pair| if self.watch.go_on() { of(pair) } else { None }).collect()
    }

    /// Sizes of the residuals of each state in most pieces.
    fn sizes(&self, model: &Model, starts: &[Vec<f64>], before: &[f64]) -> Vec<f64> {
        let n_measured = self.measured.iter().filter(|m| **m).count();
        let ones = vec![1.0; before.len()];
        let mut squares: Vec<Vec<f64>> = vec![Vec::new(); n_measured];
        for (piece, start) in self.pieces.iter().zip(starts) {
            let Some(residuals) = self.residuals(model, piece, start, &ones) else { continue };
            for (place, all) in squares.iter_mut().enumerate() {
                let own: Vec<f64> = residuals.iter().skip(place).step_by(n_measured).map(|r| r * r).collect();
                all.push((own.iter().sum::<f64>() / own.len().max(1) as f64).sqrt());
            }
        }
        let mut sizes = squares.into_iter();
        let of = |i: usize| {
            if !self.measured[i] {
                return before[i];
            }
            let mut all = sizes.next().unwrap_or_default();
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied().unwrap_or(before[i]).max(self.floor[i])
        };
        (0..before.len()).map(of).collect()
    }

    /// The parameters, from `theta`, the first of which stays, and the starts of all pieces that lose least; `rounds` at most. `None` if there is no model at `theta`.
    pub(super) fn fitted(&self, at: At<'_>, theta: &[f64], from: Option<&Fitted>, rounds: usize) -> Option<Fitted> {
        let mut theta = theta.to_vec();
        let mut starts: Vec<Vec<f64>> =
            from.map_or_else(|| self.pieces.iter().map(Piece::first).collect(), |f| f.starts.clone());
        let mut model = at(&theta)?;
        // A tenth of what a state spreads, until residuals are known.
        let mut sigma: Vec<f64> =
            from.map_or_else(|| self.spread.iter().map(|s| 0.1 * s).collect(), |f| f.sigma.clone());
        let free: Vec<usize> = (1..theta.len()).collect();
        let mut damping = 1e-3;
        let mut settled = 0;
        for _ in 0..rounds {
            if !self.watch.go_on() {
                return None;
            }
            sigma = self.sizes(&model, &starts, &sigma);
            let misfits = self.misfits(Some(&model), &starts, &sigma);
            let half = half(&misfits);
            let weight = weights(&misfits, half);
            let total = |misfits: &[f64]| misfits.iter().map(|m| loss(*m, half)).sum::<f64>();
            let before = total(&misfits);
            let slopes = self.slopes(at, (&theta, &starts, &sigma), &free, 0.0);
            let mut better = None;
            for _ in 0..TRIALS {
                let Some((change, moves)) = step(&slopes, &weight, free.len(), damping) else { break };
                let mut next = theta.clone();
                free.iter().zip(change.iter()).for_each(|(j, d)| next[*j] += d);
                let moved: Vec<Vec<f64>> = starts
                    .iter()
                    .zip(&moves)
                    .map(|(start, by)| start.iter().zip(by.iter()).map(|(x, d)| x + d).collect())
                    .collect();
                let candidate = at(&next);
                let after = total(&self.misfits(candidate.as_ref(), &moved, &sigma));
                if after < before {
                    better = candidate.map(|model| (model, next, moved, after));
                    damping = f64::max(0.25 * damping, 1e-9);
                    break;
                }
                damping *= 6.0;
            }
            let Some((new, next, moved, after)) = better else { break };
            (model, theta, starts) = (new, next, moved);
            settled = if before - after < SETTLED * before.abs() { settled + 1 } else { 0 };
            if settled == 2 {
                break;
            }
        }
        let sigma = self.sizes(&model, &starts, &sigma);
        let misfits = self.misfits(Some(&model), &starts, &sigma);
        let half = half(&misfits);
        let weights = weights(&misfits, half);
        Some(Fitted { theta, starts, sigma, misfits, weights })
    }
}

/// What the normal equations of all pieces come to when the starts are eliminated: the changes of the parameters and of the starts.
fn step(
    slopes: &[Option<Slopes>],
    weights: &[f64],
    n_theta: usize,
    damping: f64,
) -> Option<(DVector<f64>, Vec<DVector<f64>>)> {
    let n = slopes.iter().flatten().next()?.by_start.ncols();
    let mut matrix = DMatrix::<f64>::zeros(n_theta, n_theta);
    let mut right = DVector::<f64>::zeros(n_theta);
    let mut diagonal = DVector::<f64>::zeros(n_theta);
    let mut eliminated = Vec::with_capacity(slopes.len());
    for (slopes, weight) in slopes.iter().zip(weights) {
        let Some(Slopes { residuals, by_theta, by_start }) = slopes else {
            eliminated.push(None);
            continue;
        };
        let mut own = by_start.transpose() * by_start;
        for i in 0..n {
            own[(i, i)] += damping * own[(i, i)] + f64::MIN_POSITIVE;
        }
        let (cross, own_right) = (by_start.transpose() * by_theta, by_start.transpose() * residuals);
        let Some(factor) = own.cholesky() else {
            eliminated.push(None);
            continue;
        };
        let (solved_cross, solved_right) = (factor.solve(&cross), factor.solve(&own_right));
        let whole = by_theta.transpose() * by_theta;
        diagonal += *weight * whole.diagonal();
        matrix += *weight * (whole - cross.transpose() * &solved_cross);
        right += *weight * (by_theta.transpose() * residuals - cross.transpose() * &solved_right);
        eliminated.push(Some((solved_cross, solved_right)));
    }
    for j in 0..n_theta {
        matrix[(j, j)] += damping * diagonal[j] + f64::MIN_POSITIVE;
    }
    // Parameters have units: solved in those of the diagonal.
    let scale: Vec<f64> = (0..n_theta).map(|j| 1.0 / matrix[(j, j)].sqrt()).collect();
    let scaled = DMatrix::from_fn(n_theta, n_theta, |i, j| scale[i] * matrix[(i, j)] * scale[j]);
    let of_right = DVector::from_fn(n_theta, |i, _| scale[i] * right[i]);
    let solved = scaled.cholesky()?.solve(&of_right);
    let change = DVector::from_fn(n_theta, |i, _| -scale[i] * solved[i]);
    let moves = eliminated
        .into_iter()
        .map(|one| one.map_or_else(|| DVector::zeros(n), |(cross, right)| -(right + cross * &change)))
        .collect();
    change.iter().all(|v| v.is_finite()).then_some((change, moves))
}
