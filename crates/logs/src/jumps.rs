//! Steps far longer than the others, which may be the borders of rollouts that nobody marked.

use crate::recording::Recording;
use crate::{Note, Place};

/// Share of the steps that a jump is measured by the longest of.
const MOST: f64 = 0.95;

/// How much longer than those a jump is.
const FAR: f64 = 20.0;

/// A note on the longest jump of a state called one of `names`, if there is one; `place` tells where a row of a table is.
pub(crate) fn note(recordings: &[Recording], names: &[String], place: impl Fn(usize, usize) -> Place) -> Option<Note> {
    let jumps = names.iter().enumerate().filter_map(|(state, name)| {
        let mut steps: Vec<(f64, (usize, usize))> = Vec::new();
        for recording in recordings {
            let column = recording.states.column(state);
            let moved = column.iter().zip(column.iter().skip(1)).map(|(a, b)| (b - a).abs());
            steps.extend(moved.zip(recording.lines.iter().skip(1).map(|line| (recording.table, *line))));
        }
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let usual = steps.get((MOST * steps.len() as f64) as usize)?.0;
        let &(longest, row) = steps.last()?;
        (usual > 0.0 && longest > FAR * usual).then(|| (longest / usual, longest, row, name))
    });
    let (times, step, (table, line), name) = jumps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Note::Jump { state: name.clone(), step, row: place(table, line), times })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Row;
    use ndarray::Array2;

    #[test]
    fn a_border_nobody_marked_is_noted_and_a_swing_is_not() {
        let recording = |reset: bool| {
            let x = |i: usize| if reset && i >= 60 { 40.0 } else { (0.1 * i as f64).sin() };
            Recording {
                lines: (2..102).collect(),
                states: Array2::from_shape_fn((100, 1), |(i, _)| x(i)),
                inputs: Array2::zeros((100, 0)),
                ..Recording::default()
            }
        };
        let names = ["x".to_owned()];
        let place = |_, number| Place { file: None, row: Row { number, is_line: true } };
        assert_eq!(note(&[recording(false)], &names, place), None);
        let told = note(&[recording(true)], &names, place).unwrap().to_string();
        assert!(told.contains("x changes by 40.") && told.contains("before line 62"), "{told}");
    }
}
