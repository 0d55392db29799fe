//! States as they were measured: folded angles, columns that never change.

use std::f64::consts::{PI, TAU};

use crate::Note;
use crate::recording::Recording;

/// Joins angles that were folded into one turn.
pub(crate) fn unwrap(recordings: &mut [Recording], angles: &[usize], names: &[String]) -> Vec<Note> {
    let mut notes = Vec::new();
    for &angle in angles {
        let values = || recordings.iter().flat_map(|r| r.states.column(angle).to_vec());
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        // What spans more than a turn was never folded.
        if high - low > TAU * (1.0 + 1e-6) {
            continue;
        }
        let mut jumps = 0;
        for recording in &mut *recordings {
            let (mut turns, mut last) = (0.0, None);
            for value in recording.states.column_mut(angle) {
                let step: f64 = last.map_or(0.0, |last| *value - last);
                last = Some(*value);
                if step.abs() > PI {
                    turns -= step.signum();
                    jumps += 1;
                }
                *value += turns * TAU;
            }
        }
        if jumps > 0 {
            notes.push(Note::Unwrapped { state: names[angle].clone(), jumps });
        }
    }
    notes
}

/// States that never change: no term of another equation can be told from the same with them in it.
pub(crate) fn still(recordings: &[Recording], names: &[String]) -> Vec<Note> {
    let stays = |i: &usize| {
        let mut values = recordings.iter().flat_map(|r| r.states.column(*i).to_vec());
        let first = values.next();
        values.all(|v| Some(v) == first)
    };
    (0..names.len()).filter(stays).map(|i| Note::Still { state: names[i].clone() }).collect()
}
