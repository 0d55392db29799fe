//! Single samples that are off.

use ndarray::ArrayView1;

use super::finding::Finding;
use super::signal::{Clock, Signal, differences, median};

/// Standard deviations of an extrapolation by which a sample is off.
const FAR: f64 = 5.0;

/// Samples on each side that tell what is expected.
const BESIDE: usize = 3;

/// Per piece of `signal` and sample: whether an input is switched there. An input that moves from sample to sample is switched where it does so by far more than it does
/// elsewhere.
pub(super) fn switched(signal: &Signal<'_>, inputs: &[Signal<'_>]) -> Vec<Vec<bool>> {
    let mut all: Vec<Vec<bool>> = signal.pieces.iter().map(|piece| vec![false; piece.values.len()]).collect();
    for input in inputs {
        let moves = || input.pieces.iter().map(|piece| differences(piece.values).mapv(f64::abs));
        let Some(usual) = median(moves().flatten().collect()) else { continue };
        for (switched, moves) in all.iter_mut().zip(moves()) {
            let later = switched.iter_mut().skip(1);
            later.zip(moves).for_each(|(switched, moved)| *switched |= moved > FAR * 1.4826 * usual);
        }
    }
    all
}

/// The samples of `signal` that are far from what those before and those after them lead to, to the same side. Where a signal bends or jumps, as states and rates do where an
/// input is switched, one of both leads there; where it is smooth, parabolas from both sides are off to different sides. The scale is what the middle half of the samples is
/// off: a signal that jumps from level to level has none. What is near a sample that is `switched` is not judged.
pub(super) fn of(signal: &Signal<'_>, switched: &[Vec<bool>], clock: &Clock<'_>) -> Option<Finding> {
    let inner = |n: usize| BESIDE..n.saturating_sub(BESIDE);
    let sizes = signal.pieces.iter().flat_map(|piece| {
        inner(piece.values.len()).flat_map(|i| off(&piece.values, i)).map(f64::abs).collect::<Vec<_>>()
    });
    let scale = 1.4826 * median(sizes.collect())?.max(signal.step.unwrap_or(0.0));
    if scale == 0.0 {
        return None;
    }
    let (mut at, mut largest) = (Vec::new(), 0.0_f64);
    for (piece, switched) in signal.pieces.iter().zip(switched) {
        let near = |i: usize| switched[i + 1 - BESIDE..i + BESIDE].contains(&true);
        for i in inner(piece.values.len()).filter(|&i| !near(i)) {
            let [before, after] = off(&piece.values, i);
            let size = before.abs().min(after.abs());
            if size > FAR * scale && before.signum() == after.signum() {
                largest = largest.max((piece.values[i] - 0.5 * (piece.values[i - 1] + piece.values[i + 1])).abs());
                at.push(clock.of(piece, i));
            }
        }
    }
    (!at.is_empty()).then(|| Finding::Spikes { signal: signal.name.to_owned(), largest, at })
}

/// By how much sample `i` is off from the parabolas through the three samples before and after it.
fn off(values: &ArrayView1<'_, f64>, i: usize) -> [f64; 2] {
    let parabola = |[a, b, c]: [usize; 3]| 3.0 * values[a] - 3.0 * values[b] + values[c];
    [[i - 1, i - 2, i - 3], [i + 1, i + 2, i + 3]].map(|beside| values[i] - parabola(beside))
}
