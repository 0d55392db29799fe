//! What was found, and which pieces do not follow it.

use nalgebra::{DMatrix, DVector};
use sindyna_core::number::significant;

use super::fit::{Data, Fitted};
use super::grouped::Group;
use super::linearised;
use crate::estimate::{Doubt, Estimate, Posterior};
use crate::mechanics::{Equations, condition};
use crate::motion::Stepping;
use crate::solve::Selected;

/// Weight below which a piece counts as disturbed.
const DISTURBED: f64 = 0.2;

/// Consecutive parts of the pieces that are taken for independent.
const CLUSTERS: usize = 30;

/// Part of a parameter by which it is changed for standard errors. Where dry friction holds, a path has corners in its parameters, and a tangent at one says nothing of how far
/// the parameter is known.
const SECANT: f64 = 0.01;

/// Times that are told, at most.
const TOLD: usize = 8;

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
    let by_theta = equations.slopes(&fitted.theta)?;
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
    let drawn = equations.drawn(&fitted.theta, &covariance);
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
        corrections: Vec::new(),
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
    let groups = linearised::groups(data, equations, (&fitted.theta, SECANT), fitted);
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

/// Sentences about pieces that do not follow the equations.
fn notes(data: &Data<'_>, fitted: &Fitted) -> Vec<String> {
    let disturbed: Vec<usize> = (0..data.pieces.len()).filter(|&p| fitted.weights[p] < DISTURBED).collect();
    let Some(first) = data.pieces.first() else { return Vec::new() };
    let (count, seconds) = (data.pieces.len(), significant(first.seconds(), 2));
    let errors =
        "their standard errors tell how pieces of these logs disagree: those of other recordings may differ by more"
            .to_owned();
    if disturbed.is_empty() {
        return vec![format!("the equations were fitted to {count} pieces of {seconds} s"), errors];
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
    let pieces = format!(
        "the equations were fitted to {count} pieces of {seconds} s, of which {} do not follow them (from {}{more}): the system was disturbed there, or something is missing",
        disturbed.len(),
        times.join(", ")
    );
    vec![pieces, errors]
}
