//! Lagrangians that samples with noise propose.

use ndarray::Array2;

use super::balance::{Steps, balance};
use super::search::{Elbow, jumps};
use super::weighing::weighed;
use super::windows::{Fitted, Windows, stride, windows};
use crate::Watch;
use crate::data::{Segment, Signals};
use crate::library::{Joints, Lagrangian};
use crate::motion::Stepping;

/// Sets of parameters that are tried, arrangements whose parameters are all fitted, and those of which some are left out.
const TRIED: usize = 60;
const FITTED: usize = 6;
const TOLD: usize = 2;

/// Rounds of Gauss–Newton, of few parameters and of all.
const FEW: usize = 6;
pub(super) const ALL: usize = 12;

/// Runge–Kutta steps per sampling interval.
const SUBSTEPS: usize = 2;

/// A Lagrangian with the parameters that are not zero.
pub(crate) struct Proposal {
    pub(crate) lagrangian: Lagrangian,
    pub(crate) parameters: Vec<(usize, f64)>,
    /// −2 ln L and the price of the parameters.
    score: f64,
}

/// Those of the `lagrangians` of `joints` that predict `segments` best, the likeliest first. Errors of samples are `floor` (n) at least.
///
/// Of the arrangements whose momenta balance best, along the samples or the smoothed `signals`, all parameters are fitted to windows of samples, each from a start of its own; those that are not
/// missed are left out.
pub(crate) fn proposals(
    (joints, lagrangians): (&Joints, &[Lagrangian]),
    (segments, signals): (&[Segment], &Signals),
    floor: &[f64],
    stepping: Stepping,
    watch: &Watch<'_>,
) -> Vec<Proposal> {
    let stepping = if stepping.is_continuous() { Stepping::Continuous { substeps: SUBSTEPS } } else { stepping };
    let measured: Vec<Array2<f64>> = segments.iter().map(|segment| segment.x.clone()).collect();
    let stride = stride(joints, segments);
    let windows = windows(segments, stride);
    let mut balanced: Vec<(f64, Elbow)> = Vec::new();
    for (of, lagrangian) in lagrangians.iter().enumerate() {
        for (x, window) in [(&measured, 1), (&signals.x, stride)] {
            if !watch.go_on() {
                return Vec::new();
            }
            let rows = |(segment, x): (&Segment, &Array2<f64>)| {
                let u = segment.mean_inputs();
                let steps = Steps { x: x.view(), u: u.view(), dt: &segment.dt };
                let rows = balance(lagrangian, steps, !stepping.is_continuous());
                rows.iter().map(|rows| windowed(rows, window)).collect::<Vec<_>>()
            };
            let rows: Vec<Vec<Array2<f64>>> = segments.iter().zip(x).map(rows).collect();
            for unit in lagrangian.units() {
                let choice = lagrangian.others(unit);
                let Some(triangle) = weighed(lagrangian, &rows, (unit, &choice)) else { continue };
                let (all, target): (Vec<usize>, usize) = ((0..choice.len()).collect(), choice.len());
                let free = triangle.n_rows().saturating_sub(target);
                let left = triangle.residual_norm(&all, &triangle.solve_unit(&all, target), target)
                    / triangle.norm(target)
                    / (free as f64).sqrt();
                balanced.extend(
                    jumps(&triangle, (of, unit, &choice), f64::INFINITY).into_iter().map(|elbow| (left, elbow)),
                );
            }
        }
    }
    balanced.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    let data = |of: usize| Windows { lagrangian: &lagrangians[of], windows: &windows, floor, stepping };
    let fit = |(_, elbow): &(f64, Elbow)| {
        let data = data(elbow.of);
        let few = data.fitted((&elbow.chosen, elbow.values.clone()), None, FEW)?;
        let all = data.with_others(&few, &data.lagrangian.others(elbow.chosen[0]), ALL)?;
        Some((all.misfit + data.price(all.chosen.len()), elbow.of, all))
    };
    let mut fitted: Vec<(f64, usize, Fitted)> =
        balanced.iter().take(TRIED).filter(|_| watch.go_on()).filter_map(fit).take(FITTED).collect();
    fitted.sort_by(|(one, ..), (other, ..)| one.total_cmp(other));
    fitted.dedup_by(|(_, one, _), (_, other, _)| one == other);
    fitted.truncate(TOLD);
    let proposal = |(_, of, all): &(f64, usize, Fitted)| {
        let data = data(*of);
        let choice = data.chosen(all)?;
        let found = data.with_fewer(all, (&choice.columns, &choice.values), ALL)?;
        let score = found.misfit + data.price(found.chosen.len());
        let parameters = found.chosen.into_iter().zip(found.values).collect();
        Some(Proposal { lagrangian: lagrangians[*of].clone(), parameters, score })
    };
    let mut told: Vec<Proposal> = fitted.iter().filter_map(proposal).collect();
    told.sort_by(|one, other| one.score.total_cmp(&other.score));
    told
}

/// Rows added up over windows of that many steps with a weight that vanishes smoothly at both ends; the rows themselves for one step.
fn windowed(rows: &Array2<f64>, window: usize) -> Array2<f64> {
    if window <= 1 {
        return rows.clone();
    }
    let weight = |t: usize| {
        let s = 2.0 * (t as f64 + 1.0) / (window as f64 + 1.0) - 1.0;
        (1.0 - s * s).powi(3)
    };
    let starts: Vec<usize> = (0..(rows.nrows() + 1).saturating_sub(window)).collect();
    let mut summed = Array2::zeros((starts.len(), rows.ncols()));
    for (mut row, &start) in summed.rows_mut().into_iter().zip(&starts) {
        (0..window).for_each(|t| row.scaled_add(weight(t), &rows.row(start + t)));
    }
    summed
}
