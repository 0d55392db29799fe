//! Angles that were measured in degrees or turns, in radians.

use std::f64::consts::PI;

use crate::Note;
use crate::column::Column;
use crate::recording::Recording;

/// Radians, and the unit they are in, that are one of `unit`; `None` for what is no angle and no rate of one.
fn radians(unit: &str) -> Option<(f64, &'static str)> {
    const DEGREE: f64 = PI / 180.0;
    Some(match unit.trim().to_lowercase().as_str() {
        "deg" | "degs" | "degree" | "degrees" | "\u{b0}" => (DEGREE, "rad"),
        "rev" | "revs" | "turn" | "turns" | "revolutions" => (2.0 * PI, "rad"),
        "deg/s" | "degree/s" | "degrees/s" | "\u{b0}/s" | "dps" => (DEGREE, "rad/s"),
        "deg/s^2" | "deg/s\u{b2}" | "deg/s2" | "degrees/s^2" => (DEGREE, "rad/s\u{b2}"),
        "rpm" | "rev/min" | "1/min" => (PI / 30.0, "rad/s"),
        "rev/s" | "rps" | "turns/s" => (2.0 * PI, "rad/s"),
        _ => return None,
    })
}

/// Turns the states whose `columns` are in degrees or turns into radians; their units, the factor of each, and notes.
pub(crate) fn in_radians(recordings: &mut [Recording], columns: &[&Column]) -> (Vec<Column>, Vec<f64>, Vec<Note>) {
    let (mut told, mut factors, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for (i, column) in columns.iter().enumerate() {
        let Some((factor, unit)) = radians(&column.unit) else {
            told.push((*column).clone());
            factors.push(1.0);
            continue;
        };
        recordings.iter_mut().for_each(|r| r.states.column_mut(i).mapv_inplace(|v| v * factor));
        notes.push(Note::Radians { state: column.name.clone(), unit: column.unit.clone() });
        told.push(Column { unit: unit.to_owned(), ..(*column).clone() });
        factors.push(factor);
    }
    (told, factors, notes)
}

/// Whether `unit` is that of an angle.
pub(crate) fn is_angle(unit: &str) -> bool {
    unit == "rad" || radians(unit).is_some_and(|(_, unit)| unit == "rad")
}
