//! By how much states may miss their equations in one step.

use super::flow::Flow;
use crate::data::Segment;

/// Parts of σ by which a state may miss its equation in one step, from the first iterations to the last: with the first the
/// states follow the data, with the last the equations.
pub(crate) const PARTS: [f64; 4] = [1.0, 0.1, 1e-2, 1e-3];

/// The last of them.
const LAST: f64 = PARTS[PARTS.len() - 1];

/// Standard deviations by which the states (n) may miss the equations of `flow` in each step of `segment`: `part` of `sigma`, the noise of
/// those that were measured and what is known at first of the others.
///
/// What a rate misses adds up in the state that it is the rate of, over the duration T of the segment. For q of a state that was measured, a rate that was not
/// may miss √3 q/T, its own rate √20 q/T², with which integrated random walks end as far from where they would be as that of q. At the
/// first of the [`PARTS`] a rate follows the data as freely as the other states do, and this bound is reached at the last one.
pub(super) fn slack(flow: &Flow, segment: &Segment, sigma: &[f64], part: f64) -> Vec<f64> {
    let duration: f64 = segment.dt.iter().sum();
    let of = |i: usize| {
        let bound = if segment.measures(i) { None } else { bound(flow, segment, sigma, (i, duration)) };
        let ratio = bound.map_or(1.0, |bound| (bound / sigma[i]).min(1.0));
        part * sigma[i] * ratio.powf(part.log(LAST))
    };
    (0..sigma.len()).map(of).collect()
}

/// What stands for the noise of state `i` at the last part: that of the measured state that it drives, over the `duration` to the power of their distance.
fn bound(flow: &Flow, segment: &Segment, sigma: &[f64], (i, duration): (usize, f64)) -> Option<f64> {
    let driven = |rate: usize| flow.rates.iter().position(|r| *r == Some(rate));
    let (mut state, mut distance) = (i, 0);
    while !segment.measures(state) {
        (state, distance) = (driven(state).filter(|_| distance < sigma.len())?, distance + 1);
    }
    // The variance of a random walk integrated d times over N steps of T/N is N (T^d / d!)² / (2 d + 1).
    let factorial: f64 = (1..=distance).map(|k| k as f64).product();
    let gain = duration.powi(distance as i32) / (factorial * (2.0 * distance as f64 + 1.0).sqrt());
    Some(sigma[state] / gain)
}
