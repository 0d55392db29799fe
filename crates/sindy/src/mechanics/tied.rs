//! What all data tell of the parameters that a Lagrangian was proposed with.

use super::noisy::{ALL, Proposal};
use super::windows::{Fitted, Windows, stride, windows};
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
    /// By how much likelier (2 ln L) the data are if inputs are linear between samples; 0 where they are known to be, or to be held.
    pub(crate) linear: f64,
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
            let linear =
                if stepping.is_continuous() { data.gain_of_linear_inputs(&best, joints, segments) } else { 0.0 };
            let (chosen, theta) = (best.chosen, best.values);
            return Some(Tied { lagrangian: lagrangian.clone(), nearest: choice.nearest, linear, chosen, theta });
        }
        others.retain(|p| !driving.contains(p));
    }
}

impl Windows<'_> {
    /// By how much likelier (2 ln L) `segments` are with inputs that are linear between samples, by the parameters of `best`; 0 where that is known, or there are none.
    fn gain_of_linear_inputs(&self, best: &Fitted, joints: &Joints, segments: &[Segment]) -> f64 {
        if segments.iter().any(|s| s.ramp.is_some() || s.u.is_empty()) {
            return 0.0;
        }
        let linear: Vec<Segment> = segments.iter().filter(|s| s.len() > 1).map(Segment::with_linear_inputs).collect();
        let held: Vec<Segment> = linear.iter().map(|s| Segment { ramp: None, ..s.clone() }).collect();
        let misfit = |segments: &[Segment]| {
            let windows = windows(segments, stride(joints, segments));
            let fitted = Windows { windows: &windows, ..*self }.fitted((&best.chosen, best.values.clone()), None, ALL);
            fitted.map(|fitted| fitted.misfit)
        };
        misfit(&held).zip(misfit(&linear)).map_or(0.0, |(held, linear)| held - linear)
    }
}
