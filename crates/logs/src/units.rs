//! Angles that were measured in degrees or turns, in radians.

use std::f64::consts::PI;

use ndarray::Array2;

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

/// Columns that were in degrees or turns, in radians.
#[derive(Default)]
pub(crate) struct Converted {
    /// The columns with their units.
    pub(crate) columns: Vec<Column>,
    /// What each was multiplied by.
    pub(crate) factors: Vec<f64>,
    pub(crate) notes: Vec<Note>,
}

/// Turns the values (rows, columns) whose `columns` are in degrees or turns into radians: those that `values` gives of a recording.
pub(crate) fn in_radians(
    recordings: &mut [Recording],
    columns: &[&Column],
    values: impl Fn(&mut Recording) -> &mut Array2<f64>,
) -> Converted {
    let mut converted = Converted::default();
    for (i, &column) in columns.iter().enumerate() {
        let (factor, unit) = radians(&column.unit).unwrap_or((1.0, &column.unit));
        if unit != column.unit {
            recordings.iter_mut().for_each(|r| values(r).column_mut(i).mapv_inplace(|v| v * factor));
            converted.notes.push(Note::Radians { column: column.name.clone(), unit: column.unit.clone() });
        }
        converted.columns.push(Column { unit: unit.to_owned(), ..column.clone() });
        converted.factors.push(factor);
    }
    converted
}

/// Whether the unit `of` a state is that of a rate of what `rate` is in.
pub(crate) fn are_reversed(rate: &str, of: &str) -> bool {
    let per_second = of.strip_suffix("/s").or_else(|| of.strip_suffix("\u{b7}s\u{207b}\u{b9}"));
    !rate.is_empty() && per_second == Some(rate)
}

/// Whether `unit` is that of an angle.
pub(crate) fn is_angle(unit: &str) -> bool {
    unit == "rad" || radians(unit).is_some_and(|(_, unit)| unit == "rad")
}

#[cfg(test)]
mod tests {
    use crate::{Log, LogOptions, Note};

    fn log(header: &str, options: &LogOptions, row: impl Fn(f64) -> [f64; 3]) -> Log {
        let rows = (0..60).map(|i| {
            let t = 0.05 * f64::from(i);
            let [a, b, c] = row(t);
            format!("{t},{a},{b},{c}\n")
        });
        Log::parse("log", format!("{header}\n{}", rows.collect::<String>()), options).unwrap()
    }

    #[test]
    fn angles_of_inputs_are_in_radians_as_those_of_states() {
        let options = LogOptions {
            states: vec!["x".into(), "speed".into()],
            inputs: vec!["steer".into()],
            ..LogOptions::default()
        };
        let log = log("t,x [m],speed [m/s],steer [deg]", &options, |t| {
            [t.sin(), 3.0 * (2.0 * t).cos(), 20.0 * (5.0 * t).sin()]
        });
        assert_eq!(log.spec.control[0].unit, "rad");
        assert!(log.notes.iter().any(|n| n.to_string() == "steer is converted from deg to radians"));
        let steer = log.data.rollouts().next().unwrap().controls[[3, 0]];
        assert!((steer - (20.0 * 0.75_f64.sin()).to_radians()).abs() < 1e-12, "{steer}");
    }

    #[test]
    fn names_with_the_units_of_each_other_are_noted() {
        let swapped = |header| {
            let log = log(header, &LogOptions::default(), |t| [3.0 * (2.0 * t).cos(), 1.5 * (2.0 * t).sin(), 0.0]);
            log.notes.iter().any(|n| matches!(n, Note::RateUnits { .. }))
        };
        assert!(swapped("t,velocity [m],position [m/s],force [N]"));
        assert!(!swapped("t,velocity [m/s],position [m],force [N]"));
    }
}
