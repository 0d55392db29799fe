//! Coefficients fitted to whole trajectories.

use faer::Mat;
use faer::linalg::solvers::Solve as _;
use ndarray::{Array2, ArrayView2, s};
use sindyna_core::{Dynamics as _, Seed};

use super::stepping::FINEST;
use super::{Found, Run, Stepping};
use crate::{Model, Triangle};

/// A model with polished coefficients.
#[derive(Debug, Clone)]
pub(crate) struct Polished {
    pub(crate) model: Model,
    /// Standard error of each offset and coefficient, in the order of [`Model::fitted`].
    pub(crate) errors: Vec<f64>,
}

/// Steps of a piece of trajectory that is followed from one start.
const PIECE: usize = 20;

/// Gauss–Newton steps, at most.
const ROUNDS: usize = 12;

/// Gain in χ², each error taken as large as it is seen, below which no step is taken any more: coefficients then move by less
/// than a tenth of their standard errors.
const ENOUGH: f64 = 0.01;

/// Times by which a coefficient may grow.
const RUNAWAY: f64 = 3.0;

/// Relative change by which derivatives are taken.
const NUDGE: f64 = 1e-6;

/// The polished equations of `found`. Where they are followed by as many Runge–Kutta steps as there are, nature takes more: by
/// how far coefficients move when the steps are halved is part of their standard errors.
pub(crate) fn polished(found: &Found, runs: &[Run]) -> Option<Polished> {
    let Polished { model, mut errors } = polish(&found.model, runs)?;
    if found.stepping == (Stepping::Continuous { substeps: FINEST }) {
        let finer = model.with_form(Stepping::Continuous { substeps: 2 * FINEST }.form());
        let finer = polish(&finer, runs)?.model.fitted();
        for ((error, here), there) in errors.iter_mut().zip(model.fitted()).zip(finer) {
            *error = error.hypot(here - there);
        }
    }
    Some(Polished { model, errors })
}

/// A piece of trajectory: observed states, controls, errors; and the start that is being fitted.
struct Piece<'a> {
    x: ArrayView2<'a, f64>,
    u: ArrayView2<'a, f64>,
    sigma: ArrayView2<'a, f64>,
    start: Vec<f64>,
}

/// Fits the coefficients of `model` to the trajectories in `runs`, and the start of each piece with them:
/// min Σ ((x − x̂)/σ)² by Gauss–Newton, where x̂ follows the model from its start. `None` if the model cannot follow the data,
/// or if they do not determine it.
///
/// A deterministic system seen through sensors with independent errors is estimated so with the least possible error.
///
/// # References
/// Bock (1983), multiple shooting for parameter estimation; here the pieces need not meet.
fn polish(model: &Model, runs: &[Run]) -> Option<Polished> {
    let mut pieces: Vec<Piece<'_>> = runs.iter().flat_map(pieces).collect();
    let mut model = model.clone();
    let mut xi = model.fitted();
    let start = xi.clone();
    let mut misfit = pieces.iter().map(|p| p.misfit(&model)).sum::<f64>();
    if !misfit.is_finite() {
        return None;
    }
    let compared: usize = pieces.iter().map(|p| p.x.len() - p.start.len()).sum();
    let freedom = compared.saturating_sub(xi.len()).max(1) as f64;
    let mut last = None;
    for _ in 0..ROUNDS {
        let step = gauss_newton(&model, &xi, &pieces)?;
        // A step that overshoots is halved.
        let mut taken = None;
        for halvings in 0..8 {
            let part = 0.5_f64.powi(halvings);
            let trial: Vec<f64> = xi.iter().zip(&step.xi).map(|(c, d)| c + part * d).collect();
            let moved = model.with_fitted(&trial);
            let starts: Vec<Vec<f64>> = pieces
                .iter()
                .zip(&step.starts)
                .map(|(p, d)| p.start.iter().zip(d).map(|(x, d)| x + part * d).collect())
                .collect();
            let total: f64 = pieces.iter().zip(&starts).map(|(p, start)| p.misfit_from(&moved, start)).sum();
            if total <= misfit {
                taken = Some((trial, moved, starts, total));
                break;
            }
        }
        last = Some(step.triangle);
        let Some((trial, moved, starts, total)) = taken else { break };
        let gain = misfit - total;
        (xi, model, misfit) = (trial, moved, total);
        for (piece, start) in pieces.iter_mut().zip(starts) {
            piece.start = start;
        }
        if gain < ENOUGH * (misfit / freedom).max(1.0) {
            break;
        }
    }
    // Where the data do not determine the coefficients, implicit ones above all, they run away.
    if xi.iter().zip(&start).any(|(new, old)| new.abs() > RUNAWAY * old.abs()) {
        return None;
    }
    let all: Vec<usize> = (0..xi.len()).collect();
    // The last step was too short to matter to them.
    let errors = last?.spread(&all);
    // Errors larger than the samples are declared to have are taken as they are seen.
    let spread = (misfit / freedom).sqrt().max(1.0);
    let errors = errors.into_iter().map(|e| e * spread).collect();
    Some(Polished { model, errors })
}

fn pieces(run: &Run) -> Vec<Piece<'_>> {
    let cut = |first: usize| {
        let last = (first + PIECE).min(run.len());
        Piece {
            x: run.x.slice(s![first..=last, ..]),
            u: run.u.slice(s![first..last, ..]),
            sigma: run.sigma.slice(s![first..=last, ..]),
            start: run.x.row(first).to_vec(),
        }
    };
    (0..run.len()).step_by(PIECE).map(cut).collect()
}

impl Piece<'_> {
    /// (x − x̂)/σ (T + 1, n) from `start`.
    fn errors(&self, model: &Model, start: &[f64]) -> Array2<f64> {
        let mut rng = Seed::new(0).stream("no randomness", 0);
        let mut errors = Array2::from_elem(self.x.dim(), f64::NAN);
        let (mut x, mut next) = (start.to_vec(), vec![0.0; start.len()]);
        for t in 0..self.x.nrows() {
            for i in 0..x.len() {
                errors[[t, i]] = (self.x[[t, i]] - x[i]) / self.sigma[[t, i]];
            }
            if t < self.u.nrows() {
                let u = self.u.row(t).to_vec();
                if model.step(&x, &u, &mut rng, &mut next).is_err() {
                    break;
                }
                std::mem::swap(&mut x, &mut next);
            }
        }
        errors
    }

    fn misfit(&self, model: &Model) -> f64 {
        self.misfit_from(model, &self.start)
    }

    fn misfit_from(&self, model: &Model, start: &[f64]) -> f64 {
        let total: f64 = self.errors(model, start).iter().map(|e| e * e).sum();
        if total.is_finite() { total } else { f64::INFINITY }
    }
}

struct Step {
    xi: Vec<f64>,
    starts: Vec<Vec<f64>>,
    /// [∂x̂/∂ξ | x − x̂], what is left after the starts are fitted.
    triangle: Triangle,
}

/// One Gauss–Newton step. The start of a piece concerns that piece alone, so it is taken out by QR before the pieces are
/// put together.
fn gauss_newton(model: &Model, xi: &[f64], pieces: &[Piece<'_>]) -> Option<Step> {
    let p = xi.len();
    let nudges: Vec<f64> = xi.iter().map(|c| NUDGE * c.abs().max(1e-6)).collect();
    let nudged: Vec<[Model; 2]> = (0..p)
        .map(|j| {
            [1.0, -1.0].map(|sign| {
                let mut moved = xi.to_vec();
                moved[j] += sign * nudges[j];
                model.with_fitted(&moved)
            })
        })
        .collect();
    let mut triangle = Triangle::new(p + 1);
    let mut heads = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let n = piece.start.len();
        let errors = piece.errors(model, &piece.start);
        let mut columns: Vec<Array2<f64>> = Vec::with_capacity(n + p + 1);
        for i in 0..n {
            let size = NUDGE * piece.start[i].abs().max(1e-3);
            let [up, down] = [size, -size].map(|by| {
                let mut start = piece.start.clone();
                start[i] += by;
                piece.errors(model, &start)
            });
            columns.push((down - up) / (2.0 * size));
        }
        for (nudge, [up, down]) in nudges.iter().zip(&nudged) {
            columns.push((piece.errors(down, &piece.start) - piece.errors(up, &piece.start)) / (2.0 * *nudge));
        }
        columns.push(errors);
        let rows = columns[0].len();
        let flat: Vec<Vec<f64>> = columns.iter().map(|c| c.iter().copied().collect()).collect();
        if flat.iter().flatten().any(|v| !v.is_finite()) {
            return None;
        }
        let r = Mat::from_fn(rows, n + p + 1, |row, column| flat[column][row]).qr().thin_R().to_owned();
        let rest =
            Array2::from_shape_fn(
                (r.nrows().saturating_sub(n), p + 1),
                |(i, j)| {
                    if i <= j { r[(n + i, n + j)] } else { 0.0 }
                },
            );
        triangle.push(rest.view()).ok()?;
        heads.push(r);
    }
    let all: Vec<usize> = (0..p).collect();
    let delta = triangle.solve_unit(&all, p);
    let starts = heads.iter().zip(pieces).map(|(r, piece)| {
        let n = piece.start.len();
        let a = Mat::from_fn(n, n, |i, j| if i <= j { r[(i, j)] } else { 0.0 });
        let b = Mat::from_fn(n, 1, |i, _| r[(i, n + p)] - (0..p).map(|j| r[(i, n + j)] * delta[j]).sum::<f64>());
        let x = a.partial_piv_lu().solve(b);
        (0..n).map(|i| x[(i, 0)]).collect()
    });
    let starts = starts.collect();
    delta.iter().all(|d| d.is_finite()).then_some(Step { xi: delta, starts, triangle })
}
