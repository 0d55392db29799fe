//! Lagrangians that samples with noise propose.

use super::compensated::{Compensated, Set};
use super::windows::{Fitted, Windows, stride, windows};
use crate::Watch;
use crate::data::Segment;
use crate::library::{Joints, Lagrangian};
use crate::motion::Stepping;

/// Sets of parameters of each arrangement and unit, those that are tried, arrangements whose parameters are all fitted (with the whole effort, and at least), and those of which some are left out.
const SETS: usize = 2;
const TRIED: usize = 60;
const FITTED: usize = 6;
const FEWEST: usize = 2;
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
/// missed are left out. With the part `effort` (0 to 1) of all that is done fewer are fitted.
pub(crate) fn proposals(
    (joints, lagrangians): (&Joints, &[Lagrangian]),
    (segments, sigma): (&[Segment], &[f64]),
    floor: &[f64],
    stepping: Stepping,
    (effort, watch): (f64, &Watch<'_>),
) -> Vec<Proposal> {
    let stepping = if stepping.is_continuous() { Stepping::Continuous { substeps: SUBSTEPS } } else { stepping };
    let stride = stride(joints, segments);
    let windows = windows(segments, stride);
    let data = |of: usize| Windows { lagrangian: &lagrangians[of], windows: &windows, floor, stepping };
    let mut balanced: Vec<(usize, Set)> = Vec::new();
    for (of, lagrangian) in lagrangians.iter().enumerate() {
        for window in [1, stride] {
            if !watch.go_on() {
                return Vec::new();
            }
            let momenta = Compensated::new(lagrangian, (segments, sigma), (!stepping.is_continuous(), window));
            for unit in lagrangian.units() {
                let sets = momenta.sets(unit).into_iter().flatten();
                // With positive masses: an input that pushes backwards is a unit of −1.
                let signed = |set: Set| {
                    let sign = data(of).sign(&set.chosen, &set.values)?;
                    Some(Set { values: set.values.iter().map(|value| sign * value).collect(), ..set })
                };
                let moving = sets.filter_map(signed);
                balanced.extend(moving.take(SETS).map(|set| (of, set)));
            }
        }
    }
    balanced.sort_by(|(_, one), (_, other)| one.score.total_cmp(&other.score));
    let fit = |(of, set): &(usize, Set)| {
        let data = data(*of);
        let few = data.fitted((&set.chosen, set.values.clone()), None, FEW)?;
        let all = data.with_others(&few, &data.lagrangian.others(set.chosen[0]), ALL)?;
        Some((all.misfit + data.price(all.chosen.len()), *of, all))
    };
    let part = |of: usize| ((effort * of as f64).ceil() as usize).max(FEWEST);
    let mut fitted: Vec<(f64, usize, Fitted)> =
        balanced.iter().take(part(TRIED)).filter(|_| watch.go_on()).filter_map(fit).take(part(FITTED)).collect();
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
