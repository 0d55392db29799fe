//! Which two states are the cosine and the sine of one angle.

use ndarray::Array2;
use sindyna_core::turning::unwrapped;

use crate::positions::positions;
use crate::recording::Recording;
use crate::{DeclarationError, LogError, StateOption};

/// Largest RMS of c² + s² − 1.
const CLOSE: f64 = 0.02;

/// Least a column must move to be a coordinate on a circle.
const LEAST: f64 = 1e-3;

/// Two columns that show one angle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Circle {
    pub(crate) cosine: usize,
    pub(crate) sine: usize,
    /// What the angle is called.
    pub(crate) name: String,
}

/// What one state is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reading {
    Column(usize),
    Circle { cosine: usize, sine: usize },
}

/// The pairs among the states called `names` that stay on the unit circle; every state is in one pair at most.
pub(crate) fn recognised(recordings: &[Recording], names: &[String]) -> Vec<Circle> {
    let mut circles: Vec<Circle> = Vec::new();
    for i in 0..names.len() {
        for j in i + 1..names.len() {
            let taken = circles.iter().any(|c| [c.cosine, c.sine].iter().any(|k| [i, j].contains(k)));
            if !taken && on_circle(recordings, i, j) {
                circles.push(circle(names, i, j));
            }
        }
    }
    circles
}

/// Whether columns `i` and `j` go about on the unit circle.
pub(crate) fn on_circle(recordings: &[Recording], i: usize, j: usize) -> bool {
    let (mut off, mut count) = (0.0, 0);
    let mut reach = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    for recording in recordings {
        for (c, s) in recording.states.column(i).iter().zip(recording.states.column(j)) {
            off += (c * c + s * s - 1.0).powi(2);
            count += 1;
            for (reach, v) in reach.iter_mut().zip([c, s]) {
                *reach = (reach.0.min(*v), reach.1.max(*v));
            }
        }
    }
    count >= 3 && (off / f64::from(count)).sqrt() <= CLOSE && reach.iter().all(|(low, high)| high - low > LEAST)
}

/// The circle of two columns: which is the cosine is told by their names, else the first one is.
pub(crate) fn circle(names: &[String], i: usize, j: usize) -> Circle {
    let swapped = names[i].to_lowercase().contains("sin") && !names[j].to_lowercase().contains("sin");
    let (cosine, sine) = if swapped { (j, i) } else { (i, j) };
    Circle { cosine, sine, name: name(&names[cosine], names) }
}

/// `cos_th`, `cos(th)` and `costh` are of `th`; of another name it is the angle.
fn name(cosine: &str, names: &[String]) -> String {
    let is_cos = |at: &usize| cosine.get(*at..at + 3).is_some_and(|part| part.eq_ignore_ascii_case("cos"));
    let rest = match (0..cosine.len()).find(is_cos) {
        Some(at) => format!("{}{}", &cosine[..at], &cosine[at + 3..]),
        None => String::new(),
    };
    let rest = rest.trim_matches(|c: char| !c.is_alphanumeric()).to_owned();
    let base = if rest.is_empty() { "angle".to_owned() } else { rest };
    let free = |name: &String| !names.contains(name);
    (1..).map(|i| if i == 1 { base.clone() } else { format!("{base}{i}") }).find(free).unwrap_or(base)
}

/// What the state that is read so is called; `columns` are the names of the columns.
pub(crate) fn name_of(reading: Reading, circles: &[Circle], columns: &[String]) -> String {
    match reading {
        Reading::Column(column) => columns[column].clone(),
        Reading::Circle { cosine, .. } => {
            circles.iter().find(|c| c.cosine == cosine).map_or_else(|| "angle".into(), |c| c.name.clone())
        }
    }
}

/// The circles of the `pairs` of names among the `states`.
pub(crate) fn given(pairs: &[(String, String)], states: &[String]) -> Result<Vec<Circle>, LogError> {
    let mut circles: Vec<Circle> = Vec::new();
    for (cosine, sine) in pairs {
        let both = positions(&[cosine.clone(), sine.clone()], states, StateOption::Circles)?;
        let taken = circles.iter().any(|c| [c.cosine, c.sine].iter().any(|k| both.contains(k)));
        if taken || both[0] == both[1] {
            return Err(DeclarationError::CircleTaken { cosine: cosine.clone(), sine: sine.clone() }.into());
        }
        let named = circle(states, both[0], both[1]);
        circles.push(Circle { cosine: both[0], sine: both[1], ..named });
    }
    Ok(circles)
}

/// What each state is read from: the columns in their order, an angle in the place of the first of its two.
pub(crate) fn readings(n_columns: usize, circles: &[Circle]) -> Vec<Reading> {
    let reading = |i: usize| match circles.iter().find(|c| [c.cosine, c.sine].contains(&i)) {
        None => Some(Reading::Column(i)),
        Some(c) if i == c.cosine.min(c.sine) => Some(Reading::Circle { cosine: c.cosine, sine: c.sine }),
        Some(_) => None,
    };
    (0..n_columns).filter_map(reading).collect()
}

/// The recordings with their states as they are read; angles follow from row to row.
pub(crate) fn read(recordings: &[Recording], readings: &[Reading]) -> Vec<Recording> {
    let read = |recording: &Recording| {
        let columns = &recording.states;
        let mut states = Array2::zeros((columns.nrows(), readings.len()));
        for (mut state, reading) in states.columns_mut().into_iter().zip(readings) {
            match *reading {
                Reading::Column(i) => state.assign(&columns.column(i)),
                Reading::Circle { cosine, sine } => {
                    let mut last = 0.0;
                    for (value, row) in state.iter_mut().zip(columns.rows()) {
                        last = unwrapped(row[sine].atan2(row[cosine]), last);
                        *value = last;
                    }
                }
            }
        }
        Recording { states, ..recording.clone() }
    };
    recordings.iter().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(columns: usize, x: impl Fn(f64, usize) -> f64) -> Recording {
        let states = Array2::from_shape_fn((60, columns), |(i, j)| x(i as f64 * 0.2, j));
        Recording { states, inputs: Array2::zeros((60, 0)), ..Recording::default() }
    }

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|n| (*n).to_owned()).collect()
    }

    #[test]
    fn a_circle_is_seen_and_its_angle_goes_on_over_a_turn() {
        let log = [recording(3, |t, j| [2.0 * t.cos(), t.sin(), t.cos()][j])];
        let circles = recognised(&log, &names(&["x", "sin_th", "cos_th"]));
        assert_eq!(circles, [Circle { cosine: 2, sine: 1, name: "th".into() }]);
        let readings = readings(3, &circles);
        assert_eq!(readings, [Reading::Column(0), Reading::Circle { cosine: 2, sine: 1 }]);
        let read = read(&log, &readings);
        for (i, angle) in read[0].states.column(1).iter().enumerate() {
            assert!((angle - i as f64 * 0.2).abs() < 1e-12, "{i}: {angle}");
        }
    }

    #[test]
    fn what_is_no_circle_stays_as_it_is() {
        let log = [recording(2, |t, j| [t.cos(), 1.2 * t.sin()][j])];
        assert_eq!(recognised(&log, &names(&["a", "b"])), []);
        let still = [recording(2, |_, j| [1.0, 0.0][j])];
        assert_eq!(recognised(&still, &names(&["a", "b"])), []);
    }

    #[test]
    fn names_of_angles() {
        for (cosine, expected) in [
            ("cos(theta)", "theta"),
            ("th_cos", "th"),
            ("cosq1", "q1"),
            ("cos \u{3b8}", "\u{3b8}"),
            ("a", "angle"),
            ("cos", "angle"),
        ] {
            assert_eq!(name(cosine, &names(&[cosine, "sin"])), expected);
        }
        assert_eq!(name("cos_w", &names(&["cos_w", "sin_w", "w"])), "w2");
    }
}
