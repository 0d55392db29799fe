//! Steps that follow no equations where inputs change: these act otherwise than they were recorded.

use crate::data::Segment;

/// Probability of what is taken for chance.
const CHANCE: f64 = 1e-3;

/// A sentence about `events` of successive steps of `segments` that do not follow the equations, as (segment, step), if more of them begin where an input changes than by chance, and most.
///
/// Of n events k are there with a probability of exp(−n D(k/n ‖ q)) at most, where inputs change in the share q of steps (Chernoff's bound).
pub(super) fn told(segments: &[Segment], events: &[Vec<(usize, usize)>]) -> Option<String> {
    let changes = |&(at, t): &(usize, usize)| t > 0 && segments[at].u.row(t) != segments[at].u.row(t - 1);
    let steps: usize = segments.iter().map(Segment::len).sum();
    let all = segments.iter().enumerate().flat_map(|(at, segment)| (0..segment.len()).map(move |t| (at, t)));
    let changing = all.filter(changes).count() as f64 / steps.max(1) as f64;
    let there = events.iter().filter(|event| event.first().is_some_and(changes)).count();
    let share = there as f64 / events.len().max(1) as f64;
    let part = |p: f64, q: f64| if p > 0.0 { p * (p / q).ln() } else { 0.0 };
    let divergence = part(share, changing) + part(1.0 - share, 1.0 - changing);
    let is_chance = share <= changing || (-(events.len() as f64) * divergence).exp() > CHANCE;
    (share > 0.5 && !is_chance).then(|| {
        format!(
            "{there} of {} places where steps do not follow the equations are those where an input changes: inputs act later than they were recorded, \
             through an actuator that follows them slowly, or otherwise than held",
            events.len()
        )
    })
}
