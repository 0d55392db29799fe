//! States that are angles, told by their names and by how they turn.

use std::f64::consts::{PI, TAU};

use crate::column::Column;
use crate::recording::Recording;
use crate::{Note, rates, roles, units};

/// The states, whose columns are `states`, that turn as only angles do: beyond a whole turn, or from one end of it to the other at
/// once. Their names or units say that they may be angles, or one of the `inputs` is a torque, under which positions are; what has no unit and goes on beyond such an end as it came is one whatever its name. A name is not enough for
/// what goes beyond a turn: `Th` may be a temperature, and is no angle beside states none of which is its rate.
pub(crate) fn recognised(recordings: &[Recording], states: &[Column], inputs: &[&Column]) -> Vec<(usize, Note)> {
    // Without time stamps no state is known to be the rate of another yet.
    let timed = recordings.iter().all(|r| r.times.len() == r.states.nrows());
    let seen = if timed { rates::recognised(recordings) } else { Vec::new() };
    let alone = !timed || states.len() == 1;
    let moves = |i: usize| alone || !states[i].unit.is_empty() || seen.iter().any(|s| s.of == i);
    let turning = |(i, column): (usize, &Column)| {
        let folds = folds(recordings, i, TAU);
        let turns = span(recordings, i) / TAU;
        let note = Note::Angle { state: column.name.clone(), turns: (!folds).then_some(turns) };
        let is_named = may_be(column, inputs) && (folds || turns > 1.0 + 1e-6 && moves(i));
        let goes_on = column.unit.is_empty() && folds && goes_on(recordings, i, TAU);
        (is_named || goes_on).then_some((i, note))
    };
    states.iter().enumerate().filter_map(turning).collect()
}

/// Whether the name or the unit of a state says that it may be an angle: the position of a joint may be one under a torque.
pub(crate) fn may_be(column: &Column, inputs: &[&Column]) -> bool {
    let is_torque =
        |c: &&Column| roles::is_torque(&c.name) || ["Nm", "N m", "N\u{b7}m", "N*m"].contains(&c.unit.as_str());
    match column.unit.as_str() {
        "" => roles::is_angle(&column.name) || (roles::is_of_a_joint(&column.name) && inputs.iter().any(is_torque)),
        unit => units::is_angle(unit),
    }
}

/// Whether a state may be an angle although no state is its rate: it is called like nothing else, or its rate may be one of the `inputs`.
pub(crate) fn may_be_without_rate(column: &Column, inputs: &[&Column]) -> bool {
    !column.unit.is_empty() || roles::is_bearing(&column.name) || inputs.iter().any(|c| roles::is_rate(&c.name))
}

/// What speaks for degrees, of the angle of state `i` without a unit: it jumps by 360, or goes farther than machines turn.
pub(crate) fn suspected(recordings: &[Recording], i: usize, column: &Column) -> Option<Note> {
    /// Radians of more turns than most logs have.
    const FAR: f64 = 60.0;
    let reach = recordings.iter().flat_map(|r| r.states.column(i).to_vec()).fold(0.0, |m: f64, v| m.max(v.abs()));
    let suspect = column.unit.is_empty() && (folds(recordings, i, 360.0) || reach > FAR);
    suspect.then(|| Note::Degrees { state: column.name.clone(), reach })
}

fn span(recordings: &[Recording], i: usize) -> f64 {
    let values = recordings.iter().flat_map(|r| r.states.column(i).to_vec());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    high - low
}

/// Part of a turn by which noise may carry a wrapped angle beyond its range.
const BEYOND: f64 = 0.05;

/// Whether state `i` stays within one `turn`, but for noise, and jumps by about that, with no other step near half of it.
fn folds(recordings: &[Recording], i: usize, turn: f64) -> bool {
    let mut jumps = 0;
    for recording in recordings {
        let column = recording.states.column(i);
        for (a, b) in column.iter().zip(column.iter().skip(1)) {
            let step = (b - a).abs() / turn * TAU;
            if step > PI {
                jumps += 1;
            }
            if (0.5 * PI..1.5 * PI).contains(&step) {
                return false;
            }
        }
    }
    jumps > 0 && span(recordings, i) <= turn * (1.0 + BEYOND)
}

/// How many times as large as the other steps of an angle one across the end of its range may be.
const LIKE_OTHERS: f64 = 2.0;

/// Whether state `i`, which folds, moves on across the ends of its range by no more than elsewhere: one that is switched to and fro between two values does not.
fn goes_on(recordings: &[Recording], i: usize, turn: f64) -> bool {
    let (mut across, mut within) = (0.0_f64, 0.0_f64);
    for recording in recordings {
        let column = recording.states.column(i);
        for (a, b) in column.iter().zip(column.iter().skip(1)) {
            let step = (b - a).abs();
            let largest = if step > 0.5 * turn { &mut across } else { &mut within };
            *largest = largest.max(step.min((turn - step).abs()));
        }
    }
    across <= LIKE_OTHERS * within
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn recording(x: impl Fn(f64) -> f64) -> [Recording; 1] {
        [Recording { states: Array2::from_shape_fn((100, 1), |(i, _)| x(0.1 * i as f64)), ..Recording::default() }]
    }

    fn column(name: &str, unit: &str) -> Column {
        Column { name: name.into(), unit: unit.into() }
    }

    #[test]
    fn a_temperature_is_no_angle() {
        let [mut hot] = recording(|t| 60.0 + 8.0 * t.sin());
        hot.states = ndarray::concatenate![ndarray::Axis(1), hot.states, Array2::from_elem((100, 1), 20.0)];
        hot.times = (0..100).map(|i| 0.1 * f64::from(i)).collect();
        assert!(recognised(&[hot], &[column("Th", ""), column("Tc", "")], &[]).is_empty());
    }

    #[test]
    fn what_turns_is_an_angle_and_what_swings_is_as_it_was_declared() {
        let check = |x: fn(f64) -> f64, state: Column, input: Column, expected: Option<&str>| {
            let found = recognised(&recording(x), std::slice::from_ref(&state), &[&input]);
            let told = found.first().map(|(_, note)| note.to_string());
            assert_eq!(told.is_some(), expected.is_some(), "{state:?} {told:?}");
            assert!(told.is_none_or(|told| told.contains(expected.unwrap_or_default())));
        };
        let none = || column("x", "");
        check(|t| -2.0 * t, column("position", ""), column("torque", ""), Some("3.2 turns"));
        check(|t| -2.0 * t, column("position", ""), column("force", ""), None);
        check(|t| -2.0 * t, column("position", "mm"), column("torque", ""), None);
        check(|t| 2.0 * t, column("a", "rad"), none(), Some("turns"));
        check(|t| t.sin(), column("th", "rad"), none(), None);
        check(|t| (2.0 * t).sin().atan2((2.0 * t).cos()), column("th", ""), none(), Some("wrapped"));
        check(|t| (2.0 * t).sin().atan2((2.0 * t).cos()), column("h", ""), none(), Some("wrapped"));
        check(|t| (2.0 * t).sin().atan2((2.0 * t).cos()), column("h", "m"), none(), None);
        check(|t| (2.0 * t) % TAU, column("dir", ""), none(), Some("wrapped"));
        check(|t| 3.0 * (2.0 * t).sin().signum() + 0.01 * (50.0 * t).sin(), column("h", ""), none(), None);
        // Noise that was added after wrapping.
        check(
            |t| (2.0 * t).sin().atan2((2.0 * t).cos()) + 0.03 * (99.0 * t).sin(),
            column("th", ""),
            none(),
            Some("wrapped"),
        );
        let folded = recording(|t| (100.0 * t) % 360.0);
        assert!(suspected(&folded, 0, &column("th", "")).unwrap().to_string().contains("degrees"));
        assert_eq!(suspected(&folded, 0, &column("th", "rad")), None);
        assert_eq!(suspected(&recording(|t| -3.0 * t), 0, &column("th", "")), None);
    }
}
