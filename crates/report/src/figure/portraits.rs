//! Phase portraits.

use std::fmt::Write as _;

use sindyna_core::{Channel, Kind, Spec};

use super::axes::{Axes, Axis};
use super::drawing::Figure;
use super::frame::{BOTTOM, LEFT, TOP, WIDTH};
use crate::portrait::{Path, Portrait};

/// Between two panels: numbers of the right one.
const GAP: f64 = 46.0;

/// The portrait of a model of the system `spec`, identified for `task`: the truth broad and pale, the model thin upon it.
/// The file of a portrait of a kind called `kind` is named after it; `how` says what acts.
pub(crate) fn portraits(
    (kind, task, how): (&str, &str, &str),
    spec: &Spec,
    portrait: &Portrait,
    caption: String,
) -> Figure {
    let count = portrait.panels.len().max(1) as f64;
    let width = (WIDTH - 14.0 - LEFT - GAP * (count - 1.0)) / count;
    let mut text = String::new();
    for (place, &(across, up)) in portrait.panels.iter().enumerate() {
        let left = LEFT + place as f64 * (width + GAP);
        let (x, y) = (&spec.state[across], &spec.state[up]);
        let axes = Axes {
            x: axis(x, portrait, across),
            y: axis(y, portrait, up),
            left: left.round(),
            right: (left + width).round(),
            top: TOP,
            bottom: BOTTOM,
        };
        axes.draw(&mut text);
        for path in &portrait.paths {
            draw(&mut text, &axes, path, (across, up), x.kind == Kind::Angle);
        }
    }
    Figure {
        name: format!("{kind}-{task}"),
        alternative: format!("Phase portrait of {task}, {how}: the true system and the identified model"),
        caption,
        elements: text,
    }
}

/// The axis of the state number `i`, with room for every path; of an angle that turns, one turn.
fn axis(channel: &Channel, portrait: &Portrait, i: usize) -> Axis {
    let values = || portrait.paths.iter().flat_map(|path| path.truth.iter().map(|state| state[i]));
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let turn = std::f64::consts::PI;
    let turns = channel.kind == Kind::Angle && (low < -turn || high > turn);
    let (low, high) = if turns { (-turn, turn) } else { (low, high) };
    let room = 0.04 * (high - low);
    let unit = if channel.unit.is_empty() { String::new() } else { format!(" [{}]", channel.unit) };
    Axis::even(&format!("{}{unit}", channel.name), low - room, high + room)
}

fn draw(text: &mut String, axes: &Axes, path: &Path, (across, up): (usize, usize), turns: bool) {
    for (class, states) in [("truth", &path.truth), ("c0 model", &path.model)] {
        let points: Vec<(f64, f64)> = states.iter().map(|state| (state[across], state[up])).collect();
        for piece in if turns { pieces(&points) } else { vec![points] } {
            axes.line(text, class, &piece);
        }
    }
    if let Some(start) = path.truth.first() {
        let (x, y) = (axes.x(start[across]), axes.y(start[up]));
        let _ = writeln!(text, r#"<circle class="c0" cx="{x:.1}" cy="{y:.1}" r="2.6"/>"#);
    }
}

/// A path over an angle, cut where it goes over from half a turn to minus half a turn.
fn pieces(points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    let (half, whole) = (std::f64::consts::PI, 2.0 * std::f64::consts::PI);
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut turn = None;
    for &(angle, rate) in points {
        let turns = ((angle + half) / whole).floor();
        if turn != Some(turns) {
            pieces.push(Vec::new());
            turn = Some(turns);
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push((angle - turns * whole, rate));
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_turns_over_is_cut() {
        let found = pieces(&[(3.0, 1.0), (3.2, 1.0), (3.4, 1.0)]);
        let lengths: Vec<usize> = found.iter().map(Vec::len).collect();
        assert_eq!(lengths, [1, 2]);
        assert!((found[1][0].0 - (3.2 - 2.0 * std::f64::consts::PI)).abs() < 1e-12);
        assert_eq!(pieces(&[(0.0, 1.0), (1.0, 1.0)]).len(), 1);
    }

    #[test]
    fn the_same_system_with_and_without_noise_has_two_pictures() {
        let system = sindyna_envs::find("pendulum").expect("it comes along");
        let portrait = Portrait { paths: Vec::new(), panels: Vec::new() };
        let name = |task: &str| portraits(("portrait", task, ""), system.spec(), &portrait, String::new()).name;
        assert_ne!(name("pendulum"), name("pendulum+noise-0.01"));
    }
}
