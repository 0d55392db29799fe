//! States that run into a limit: a sensor's, a stop's, the brim of a tank.

use super::finding::{At, Finding};
use super::signal::{Clock, Signal, differences, median};

/// Samples that stay at a limit.
const STAYS: usize = 3;

/// Part of its usual moves, and steps of its lattice, by which it arrives or leaves.
const PART: f64 = 0.25;
const STEPS: f64 = 3.0;

/// Other values that a signal has besides its limits; one that switches between few has no limits.
const VALUES: usize = 8;

/// The limits at which `signal` clips: its highest or its lowest value, where it arrives moving and then stays.
pub(super) fn of(signal: &Signal<'_>, clock: &Clock<'_>) -> Vec<Finding> {
    let values = || signal.pieces.iter().flat_map(|piece| piece.values.iter().copied());
    let count = values().count();
    let mut distinct: Vec<u64> = values().map(f64::to_bits).collect();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() < VALUES {
        return Vec::new();
    }
    let ends = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
    let usual = usual_move(signal, ends);
    if usual == 0.0 {
        return Vec::new();
    }
    let least = (PART * usual).max(STEPS * signal.step.unwrap_or(0.0));
    let clips = |limit: f64| {
        let at = arrivals(signal, limit, least, clock);
        let share = values().filter(|v| v.to_bits() == limit.to_bits()).count() as f64 / count as f64;
        (!at.is_empty()).then(|| Finding::Clips { signal: signal.name.to_owned(), limit, share, at })
    };
    ends.into_iter().filter_map(clips).collect()
}

/// How far it moves from samples that are not at its `ends` to the next, as a median.
fn usual_move(signal: &Signal<'_>, ends: [f64; 2]) -> f64 {
    let moves = signal.pieces.iter().flat_map(|piece| {
        let moves = differences(piece.values).into_iter().map(f64::abs);
        moves.zip(piece.values.iter().copied()).filter(|(_, from)| !ends.contains(from)).map(|(moved, _)| moved)
    });
    median(moves.collect()).unwrap_or(0.0)
}

/// When `signal` comes to `limit` and stays, if it moves by `least` from one sample to the next before it comes or after it has left. What comes to rest near its end, or turns
/// there, is slow.
fn arrivals(signal: &Signal<'_>, limit: f64, least: f64, clock: &Clock<'_>) -> Vec<At> {
    let mut at = Vec::new();
    for piece in &signal.pieces {
        let values = &piece.values;
        let there = |i: usize| values.get(i).is_some_and(|v| v.to_bits() == limit.to_bits());
        let arrives = |i: &usize| {
            let last = (*i..values.len()).take_while(|j| there(*j)).last().unwrap_or(*i);
            // The limit cuts the step to it short.
            let moved = |from: Option<usize>| from.and_then(|from| Some((values.get(from + 1)? - values[from]).abs()));
            let moves = [i.checked_sub(1), i.checked_sub(2), Some(last), Some(last + 1)];
            let fastest = moves.into_iter().filter_map(moved).fold(0.0, f64::max);
            last + 1 - i >= STAYS && fastest >= least
        };
        at.extend(
            (1..values.len()).filter(|i| there(*i) && !there(*i - 1)).filter(arrives).map(|i| clock.of(piece, i)),
        );
    }
    at
}
