//! Steps that follow no equations at one end of the range of a state: a stop, or something else that the system meets there.

use sindyna_core::number::significant;

use crate::data::Segment;

/// Probability of what is taken for chance, and times that the end is reached, at least.
const CHANCE: f64 = 1e-3;
const FEWEST: usize = 2;

/// A sentence about `events` of successive steps of `segments` that do not follow the equations, as (segment, step), if they are at one end of the range of a state, by more than chance.
pub(super) fn met(names: &[String], segments: &[Segment], events: &[Vec<(usize, usize)>]) -> Option<String> {
    let samples: usize = segments.iter().map(|s| s.x.nrows()).sum();
    let ends = (0..names.len()).flat_map(|i| [(i, 1.0), (i, -1.0)]);
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
    if events.len() < FEWEST || 2.0 * names.len() as f64 * beyond.powi(events.len().min(1_000) as i32) > CHANCE {
        return None;
    }
    let (i, sign) = end;
    let strays: usize = events.iter().map(Vec::len).sum();
    let (bound, which) = if sign > 0.0 { ("at least", "largest") } else { ("at most", "smallest") };
    Some(format!(
        "{strays} steps do not follow the equations, all where `{}` is {bound} {}, its {which} values: the system meets a stop there, or something else \
         that the equations do not contain",
        names[i],
        significant(sign * least, 4)
    ))
}
