//! What was found, and which pieces do not follow it.

use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Seed, number::significant};

use super::equations::Equations;
use super::fit::{Data, Fitted};
use super::grouped::Group;
use super::linearised;
use crate::estimate::{Doubt, Estimate, Posterior};
use crate::motion::Stepping;
use crate::solve::Selected;

/// Weight below which a piece counts as disturbed.
const DISTURBED: f64 = 0.2;

/// Consecutive parts of the pieces that are taken for independent.
const CLUSTERS: usize = 30;

/// Sets of coefficients that are drawn.
const DRAWS: usize = 64;

/// Times that are told, at most.
const TOLD: usize = 8;

/// Step by which derivatives of coefficients are taken, as part of the largest parameter.
const NUDGE: f64 = 1e-6;

/// Equations fitted to pieces, and what speaks of the rest.
pub(crate) struct Disturbed {
    pub(crate) found: Estimate,
    /// What the equations leave of most pieces, as a part of the spread of each state: the largest.
    pub(crate) left: f64,
    /// Sentences about pieces that do not follow the equations.
    pub(crate) notes: Vec<String>,
}

/// The account of `equations` as `fitted`, of states with declared `rates`; `None` where the data do not determine their parameters.
pub(super) fn account(
    rates: &[Option<usize>],
    data: &Data<'_>,
    equations: &Equations,
    fitted: &Fitted,
) -> Option<Disturbed> {
    let covariance = covariance(data, equations, fitted)?;
    let xi = equations.coefficients(&fitted.theta)?;
    let by_theta = slopes(equations, &fitted.theta)?;
    let of_xi = &by_theta * &covariance * by_theta.transpose();
    let mut errors = (0..xi.len()).map(|j| of_xi[(j, j)].max(0.0).sqrt());
    let mut coefficients = xi.iter().copied();
    let n = equations.supports.len();
    let is_kinematic = equations.model.kinematic();
    let (mut fits, mut all_errors) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for (i, support) in equations.supports.iter().enumerate() {
        let count = if is_kinematic[i] { 0 } else { support.len() };
        let own = if is_kinematic[i] { vec![1.0] } else { coefficients.by_ref().take(count).collect() };
        fits.push(Selected {
            support: support.clone(),
            coefficients: own,
            residual: fitted.sigma[i],
            reached_floor: is_kinematic[i],
            proved: false,
            converged: true,
            path: Vec::new(),
            ties: Vec::new(),
        });
        all_errors.push(errors.by_ref().take(count).collect());
    }
    let drawn = drawn(equations, &fitted.theta, &covariance);
    let of_spread = |i: usize| {
        if data.measured[i] && data.spread[i] > 0.0 { 1.0 - fitted.sigma[i] / data.spread[i] } else { f64::NAN }
    };
    let found = Estimate {
        posterior: Posterior::of_draws(equations.terms.clone(), rates, &equations.supports, drawn),
        terms: equations.terms.clone(),
        inside: Vec::new(),
        fits,
        twins: Vec::new(),
        n_known: vec![0; n],
        contradicted: Vec::new(),
        errors: all_errors,
        stepping: Stepping::Classical { substeps: 1 },
        condition: condition(&covariance),
        sigma: fitted.sigma.clone(),
        signal_noise: data.floor.to_vec(),
        measured: data.measured.to_vec(),
        rates: rates.to_vec(),
        path: Vec::new(),
        score: f64::INFINITY,
        astray: 0,
        growing: vec![0.0; n],
        doubts: is_kinematic.iter().map(|k| (!k).then_some(Doubt::Disturbed)).collect(),
        fit: (0..n).map(of_spread).collect(),
        complete: true,
        leaves_nothing: false,
        rounding: None,
    };
    Some(Disturbed { found, left: data.left(fitted), notes: notes(data, fitted) })
}

/// The covariance of the parameters beside the unit, by how much clusters of pieces disagree.
///
/// # References
/// White (1980), Econometrica 48(4); Liang, Zeger (1986), Biometrika 73(1): H⁻¹ (Σ g gᵀ) H⁻¹ over clusters.
fn covariance(data: &Data<'_>, equations: &Equations, fitted: &Fitted) -> Option<DMatrix<f64>> {
    let groups = linearised::groups(data, equations, &fitted.theta, fitted);
    let k = fitted.theta.len() - 1;
    let (mut hessian, mut clusters) = (DMatrix::<f64>::zeros(k, k), vec![DVector::<f64>::zeros(k); CLUSTERS]);
    let count = groups.len();
    for (at, (group, weight)) in groups.iter().zip(&fitted.weights).enumerate() {
        let Some(Group { rows, .. }) = group else { continue };
        let by_theta = DMatrix::from_fn(rows.nrows(), k, |i, j| rows[[i, j]]);
        let left = DVector::from_fn(rows.nrows(), |i, _| {
            rows[[i, k]] - (0..k).map(|j| rows[[i, j]] * fitted.theta[1 + j]).sum::<f64>()
        });
        hessian += *weight * by_theta.transpose() * &by_theta;
        clusters[at * CLUSTERS / count.max(1)] += *weight * by_theta.transpose() * left;
    }
    let scale: Vec<f64> = (0..k).map(|j| 1.0 / hessian[(j, j)].sqrt()).collect();
    let scaled = DMatrix::from_fn(k, k, |i, j| scale[i] * hessian[(i, j)] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    let inverse = DMatrix::from_fn(k, k, |i, j| scale[i] * inverse[(i, j)] * scale[j]);
    let meat = clusters.iter().fold(DMatrix::zeros(k, k), |sum, g| sum + g * g.transpose());
    let all = &inverse * meat * &inverse * (CLUSTERS as f64 / (CLUSTERS - 1) as f64);
    all.iter().all(|v| v.is_finite()).then_some(all)
}

/// ∂ξ/∂θ of the coefficients by the parameters beside the unit.
fn slopes(equations: &Equations, theta: &[f64]) -> Option<DMatrix<f64>> {
    let base = equations.coefficients(theta)?;
    let step = NUDGE * theta.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let mut slopes = DMatrix::zeros(base.len(), theta.len() - 1);
    for j in 1..theta.len() {
        let mut moved = theta.to_vec();
        moved[j] += step;
        let moved = equations.coefficients(&moved)?;
        (0..base.len()).for_each(|i| slopes[(i, j - 1)] = (moved[i] - base[i]) / step);
    }
    Some(slopes)
}

/// Coefficients of parameters drawn from their normal distribution.
fn drawn(equations: &Equations, theta: &[f64], covariance: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let eigen = covariance.clone().symmetric_eigen();
    let mut rng = Seed::new(0).stream("coefficients", 0);
    let draw = |_| {
        let z = DVector::from_fn(theta.len() - 1, |i, _| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            normal * eigen.eigenvalues[i].max(0.0).sqrt()
        });
        let change = &eigen.eigenvectors * z;
        let moved: Vec<f64> =
            theta.iter().enumerate().map(|(j, v)| if j == 0 { *v } else { v + change[j - 1] }).collect();
        equations.coefficients(&moved)
    };
    let all: Vec<Vec<f64>> = (0..DRAWS).filter_map(draw).collect();
    if all.is_empty() { equations.coefficients(theta).into_iter().collect() } else { all }
}

/// The condition number of the correlations of the parameters.
fn condition(covariance: &DMatrix<f64>) -> f64 {
    let scale: Vec<f64> = covariance.diagonal().iter().map(|v| 1.0 / v.sqrt()).collect();
    let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| scale[i] * covariance[(i, j)] * scale[j]);
    let values = scaled.symmetric_eigen().eigenvalues;
    (values.max() / values.min().max(f64::MIN_POSITIVE)).sqrt()
}

/// Sentences about pieces that do not follow the equations.
fn notes(data: &Data<'_>, fitted: &Fitted) -> Vec<String> {
    let disturbed: Vec<usize> = (0..data.pieces.len()).filter(|&p| fitted.weights[p] < DISTURBED).collect();
    let Some(first) = data.pieces.first() else { return Vec::new() };
    let (count, seconds) = (data.pieces.len(), significant(first.seconds(), 2));
    if disturbed.is_empty() {
        return vec![format!("the equations were fitted to {count} pieces of {seconds} s")];
    }
    let several = data.pieces.last().is_some_and(|p| p.recording > 0);
    let mut worst = disturbed.clone();
    worst.sort_by(|a, b| fitted.misfits[*b].total_cmp(&fitted.misfits[*a]));
    worst.truncate(TOLD);
    worst.sort_unstable();
    let told = |p: &usize| {
        let piece = &data.pieces[*p];
        let time = significant(piece.start, 3);
        if several { format!("{time} s of trajectory {}", piece.recording + 1) } else { format!("{time} s") }
    };
    let times: Vec<String> = worst.iter().map(told).collect();
    let more = if worst.len() < disturbed.len() { ", and others" } else { "" };
    vec![format!(
        "the equations were fitted to {count} pieces of {seconds} s, of which {} do not follow them (from {}{more}): the system was disturbed there, or something is missing",
        disturbed.len(),
        times.join(", ")
    )]
}
