//! What all data tell of the parameters that a Lagrangian was proposed with.

use super::noisy::{ALL, Proposal};
use super::windows::{Windows, stride, windows};
use crate::data::Segment;
use crate::library::{Joints, Lagrangian};
use crate::motion::Stepping;

/// Runge–Kutta steps per sampling interval.
const SUBSTEPS: usize = 4;

/// The parameters of a Lagrangian, which tie the coefficients of all equations together.
pub(crate) struct Tied {
    pub(crate) lagrangian: Lagrangian,
    /// Parameters and their values, the unit of the others first.
    pub(crate) chosen: Vec<usize>,
    pub(crate) theta: Vec<f64>,
    /// By how much more squares are left, in units of the noise, with another parameter in place of one of these, that is no more far-fetched: the least.
    pub(crate) nearest: f64,
}

/// The parameters of `proposal` and those that are missed without it, fitted to `segments`. Friction that would drive is left out. `None` where the data
/// cannot be followed.
pub(crate) fn tied(
    joints: &Joints,
    proposal: &Proposal,
    (segments, floor): (&[Segment], &[f64]),
    stepping: Stepping,
) -> Option<Tied> {
    let stepping = if stepping.is_continuous() { Stepping::Continuous { substeps: SUBSTEPS } } else { stepping };
    let windows = windows(segments, stride(joints, segments));
    let lagrangian = &proposal.lagrangian;
    let data = Windows { lagrangian, windows: &windows, floor, stepping };
    let (chosen, values): (Vec<usize>, Vec<f64>) = proposal.parameters.iter().copied().unzip();
    let begun = data.fitted((&chosen, values), None, ALL)?;
    let mut others = lagrangian.others(chosen[0]);
    loop {
        let all = data.with_others(&begun, &others, ALL)?;
        let choice = data.chosen(&all)?;
        let best = data.with_fewer(&all, (&choice.columns, &choice.values), ALL)?;
        let drives = |(p, value): (&usize, &f64)| lagrangian.dissipates(*p) && *value < 0.0;
        let driving: Vec<usize> =
            best.chosen.iter().zip(&best.values).filter(|pair| drives(*pair)).map(|(p, _)| *p).collect();
        if driving.is_empty() {
            let (chosen, theta) = (best.chosen, best.values);
            return Some(Tied { lagrangian: lagrangian.clone(), nearest: choice.nearest, chosen, theta });
        }
        others.retain(|p| !driving.contains(p));
    }
}
