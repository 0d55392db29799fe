//! Single samples that are off.

use super::finding::Finding;
use super::signal::{Clock, Signal, median};

/// Standard deviations by which a sample is off.
const FAR: f64 = 8.0;

/// The samples of `signal` that are far from both neighbours, which are near each other. The scale is what the middle half of the samples is off: a
/// signal that jumps from level to level has none.
pub(super) fn of(signal: &Signal<'_>, clock: &Clock<'_>) -> Option<Finding> {
    let off = |values: &ndarray::ArrayView1<'_, f64>, i: usize| values[i] - 0.5 * (values[i - 1] + values[i + 1]);
    let inner = |n: usize| 1..n.saturating_sub(1);
    let sizes = signal.pieces.iter().flat_map(|piece| inner(piece.values.len()).map(|i| off(&piece.values, i).abs()));
    let scale = 1.4826 * median(sizes.collect())?.max(signal.step.unwrap_or(0.0));
    if scale == 0.0 {
        return None;
    }
    let (mut at, mut largest) = (Vec::new(), 0.0_f64);
    for piece in &signal.pieces {
        for i in inner(piece.values.len()) {
            let size = off(&piece.values, i).abs();
            let apart = (piece.values[i + 1] - piece.values[i - 1]).abs();
            if size > FAR * scale && apart < 0.5 * size {
                largest = largest.max(size);
                at.push(clock.of(piece, i));
            }
        }
    }
    (!at.is_empty()).then(|| Finding::Spikes { signal: signal.name.to_owned(), largest, at })
}
