//! Inputs that follow the states.

use ndarray::Array1;

use super::finding::Finding;
use super::signal::Signal;
use crate::response::{orthonormal, without};

/// Share of its variance from which an input has next to nothing of its own.
const TELLS: f64 = 0.95;

/// Whether `input` is nearly a linear function of `states` and of sines and cosines of those that `turn`.
pub(super) fn of(input: &Signal<'_>, states: &[Signal<'_>], turns: impl Fn(usize) -> bool) -> Option<Finding> {
    let rows: Vec<usize> = input.pieces.iter().map(|piece| piece.values.len()).collect();
    let all = |signal: &Signal<'_>, of: fn(f64) -> f64| -> Array1<f64> {
        signal
            .pieces
            .iter()
            .zip(&rows)
            .flat_map(|(piece, rows)| piece.values.iter().take(*rows).map(|v| of(*v)).collect::<Vec<_>>())
            .collect()
    };
    let whole = all(input, |v| v);
    let mut basis = vec![Array1::ones(whole.len())];
    let mean = orthonormal(basis.clone());
    let moved = without(&mean, whole.clone());
    for (i, state) in states.iter().enumerate() {
        basis.push(all(state, |v| v));
        if turns(i) {
            basis.extend([all(state, f64::sin), all(state, f64::cos)]);
        }
    }
    let width = basis.len();
    let left = without(&orthonormal(basis), whole);
    let share = 1.0 - left.dot(&left) / moved.dot(&moved);
    // A few samples are told by anything.
    (share >= TELLS && moved.len() > 10 * width).then(|| Finding::Feedback { signal: input.name.to_owned(), share })
}
