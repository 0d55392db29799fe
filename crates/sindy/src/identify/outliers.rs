//! Steps that follow no equations, and what they have in common.

use ndarray::{Array1, s};

use super::{after_changes, ends};
use crate::data::Segment;
use crate::model::{Inputs, Model};

/// Error of one step, as a multiple of the median, beyond which it follows no equations.
const STRAY: f64 = 15.0;

/// A sentence about the steps of `segments`, of a system whose states have the first `names`, that do not follow `model`, if they are at one end of the range of a state, or where inputs change, by more than chance: samples of all
/// states, whose errors are `floor` (n) at least.
pub(super) fn told(names: &[String], model: &Model, segments: &[Segment], floor: &[f64]) -> Option<String> {
    let errors: Vec<Vec<Array1<f64>>> = segments.iter().map(|s| errors(model, s)).collect::<Option<_>>()?;
    let typical = |i: usize| {
        let mut all: Vec<f64> = errors.iter().flatten().map(|e| e[i]).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).map_or(f64::INFINITY, |median| median.max(floor[i]))
    };
    let typical: Vec<f64> = (0..floor.len()).map(typical).collect();
    let is_stray = |e: &Array1<f64>| e.iter().zip(&typical).any(|(e, typical)| *e > STRAY * typical);
    // Strays that follow one another are one event.
    let mut events: Vec<Vec<(usize, usize)>> = Vec::new();
    for (at, of_segment) in errors.iter().enumerate() {
        for t in (0..of_segment.len()).filter(|t| is_stray(&of_segment[*t])) {
            match events.last_mut().filter(|event| event.last() == Some(&(at, t.wrapping_sub(1)))) {
                Some(event) => event.push((at, t)),
                None => events.push(vec![(at, t)]),
            }
        }
    }
    ends::met(&names[..floor.len()], segments, &events).or_else(|| after_changes::told(segments, &events))
}

/// Per step of `segment`: |x⁺ − F(x, u)| from the samples (n). `None` where a state was not measured, or the model cannot be asked.
fn errors(model: &Model, segment: &Segment) -> Option<Vec<Array1<f64>>> {
    if segment.relative.as_ref().is_some_and(|r| r.iter().any(|r| !r.is_finite())) {
        return None;
    }
    let of = |t: usize| {
        let u = segment.u.slice(s![t..=t, ..]);
        let end = segment.ramp.as_ref().map(|ramp| &u + &ramp.by.slice(s![t..=t, ..]));
        let inputs = Inputs { start: u, end: end.as_ref().map(|end| end.view()), intersample: segment.intersample() };
        let next = model.simulate_at(&segment.x.row(t).to_vec(), inputs, &segment.dt[t..=t]).ok()?;
        Some((&segment.x.row(t + 1) - &next.row(1)).mapv(f64::abs))
    };
    (0..segment.len()).map(of).collect()
}
