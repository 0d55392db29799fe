//! Noise by differences of neighbouring samples.

use super::Segment;

/// A first estimate of the noise of state `i`: what no polynomial through a few neighbouring samples explains, for the degree that
/// leaves least.
///
/// # References
/// Gasser, Sroka, Jennen-Steinmetz (1986), Biometrika 73(3), here with divided differences of several orders and medians.
pub(super) fn by_differences(segments: &[Segment], i: usize) -> f64 {
    let of_order = |order: usize| {
        let mut left = Vec::new();
        for segment in segments {
            let mut times = vec![0.0];
            segment.dt.iter().for_each(|dt| times.push(times.last().copied().unwrap_or(0.0) + dt));
            for first in 0..times.len().saturating_sub(order) {
                let at = &times[first..=first + order];
                let span = (at[order] - at[0]) / order as f64;
                let weight =
                    |j: usize| (0..=order).filter(|&m| m != j).map(|m| span / (at[j] - at[m])).product::<f64>();
                let weights: Vec<f64> = (0..=order).map(weight).collect();
                let difference: f64 = weights.iter().enumerate().map(|(j, w)| w * segment.x[[first + j, i]]).sum();
                left.push(difference.abs() / weights.iter().map(|w| w * w).sum::<f64>().sqrt());
            }
        }
        left.sort_by(f64::total_cmp);
        left.get(left.len() / 2).map_or(f64::INFINITY, |median| median / 0.6745)
    };
    let least = (2..=6).map(of_order).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}
