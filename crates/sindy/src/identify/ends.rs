//! Steps that follow no equations, at one end of the range of a state: a stop, or something else that the system meets there.

use ndarray::{Array1, s};
use sindyna_core::number::significant;

use crate::data::Segment;
use crate::model::{Inputs, Model};

/// Error of one step, as a multiple of the median, beyond which it follows no equations.
const STRAY: f64 = 15.0;

/// Probability of what is taken for chance, and times that the end is reached, at least.
const CHANCE: f64 = 1e-3;
const FEWEST: usize = 2;

/// A sentence about the steps of `segments` that do not follow `model`, if they are at one end of the range of a state, by more than chance: samples of all
/// states, whose errors are `floor` (n) at least.
pub(super) fn met(names: &[String], model: &Model, segments: &[Segment], floor: &[f64]) -> Option<String> {
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
    let mut strays = 0;
    for (at, of_segment) in errors.iter().enumerate() {
        for t in (0..of_segment.len()).filter(|t| is_stray(&of_segment[*t])) {
            strays += 1;
            match events.last_mut().filter(|event| event.last() == Some(&(at, t.wrapping_sub(1)))) {
                Some(event) => event.push((at, t)),
                None => events.push(vec![(at, t)]),
            }
        }
    }
    let samples: usize = segments.iter().map(|s| s.x.nrows()).sum();
    let ends = (0..floor.len()).flat_map(|i| [(i, 1.0), (i, -1.0)]);
    let share = |(i, sign): (usize, f64)| {
        // Of a wrong sample one neighbour is as others are.
        let of_step = |&(at, t): &(usize, usize)| {
            let x = &segments[at].x;
            f64::min(sign * x[[t, i]], sign * x[[t + 1, i]])
        };
        let of_event = |event: &Vec<(usize, usize)>| event.iter().map(of_step).fold(f64::NEG_INFINITY, f64::max);
        let least = events.iter().map(of_event).fold(f64::INFINITY, f64::min);
        let beyond = segments.iter().flat_map(|s| s.x.column(i).to_vec()).filter(|x| sign * x >= least).count();
        (beyond as f64 / samples.max(1) as f64, least)
    };
    let (end, (beyond, least)) = ends.map(|end| (end, share(end))).min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    if events.len() < FEWEST || 2.0 * floor.len() as f64 * beyond.powi(events.len().min(1_000) as i32) > CHANCE {
        return None;
    }
    let (i, sign) = end;
    let (bound, which) = if sign > 0.0 { ("at least", "largest") } else { ("at most", "smallest") };
    Some(format!(
        "{strays} steps do not follow the equations, all where `{}` is {bound} {}, its {which} values: the system meets a stop there, or something else \
         that the equations do not contain",
        names[i],
        significant(sign * least, 4)
    ))
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
