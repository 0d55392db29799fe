//! Signals against time: measured and predicted.

use std::fmt::Write as _;

use super::axes::{Axes, Axis};
use super::drawing::Figure;
use super::frame::{BOTTOM, LEFT, TOP, WIDTH};
use crate::escape::escaped;
use crate::thin::{Point, range, thinned};

/// Right end of panels without names beside them.
const RIGHT: f64 = WIDTH - 24.0;

/// Bottom of a panel with another one below it, and top of that one.
const UPPER_BOTTOM: f64 = 178.0;
const LOWER_TOP: f64 = 226.0;

/// Letters of a name that stand above an axis.
const MOST_LETTERS: usize = 14;

/// One line with its name.
pub(crate) struct Line<'a> {
    pub(crate) class: &'a str,
    pub(crate) name: &'a str,
    /// Points from left to right, in pieces between which there is a gap.
    pub(crate) pieces: Vec<Vec<Point>>,
}

/// One signal against time.
pub(crate) struct Series<'a> {
    /// The signal with its unit.
    pub(crate) label: &'a str,
    pub(crate) time: &'a str,
    /// The first is drawn below the others.
    pub(crate) lines: Vec<Line<'a>>,
    /// Differences, drawn as dots in a panel below.
    pub(crate) residuals: Option<(&'a str, Vec<Point>)>,
    /// Times at which something begins anew.
    pub(crate) borders: Vec<f64>,
    /// Points of a line at most.
    pub(crate) most: usize,
}

/// A name as there is room for.
pub(crate) fn short(name: &str) -> String {
    match name.chars().nth(MOST_LETTERS) {
        Some(_) => name.chars().take(MOST_LETTERS - 1).collect::<String>() + "…",
        None => name.to_owned(),
    }
}

pub(crate) fn series(name: String, alternative: String, caption: String, of: &Series<'_>) -> Figure {
    let points = || of.lines.iter().flat_map(|line| line.pieces.iter().flatten().copied());
    let (left, right) = range(points().map(|p| p.0)).unwrap_or((0.0, 1.0));
    // What is measured, and what is predicted from it, says how much room there is: a free run may go anywhere.
    let near = of.lines.iter().take(2).flat_map(|line| line.pieces.iter().flatten().map(|p| p.1));
    let (low, high) = range(near).unwrap_or((0.0, 1.0));
    let room = 0.08 * (high - low);
    let bottom = if of.residuals.is_some() { UPPER_BOTTOM } else { BOTTOM };
    let time = if of.residuals.is_some() { "" } else { of.time };
    let x = |label: &str| Axis::even(label, left, right);
    let y = Axis::even(&short(of.label), low - room, high + room);
    let upper = Axes { x: x(time), y, left: LEFT, right: RIGHT, top: TOP, bottom };
    let mut text = String::new();
    upper.draw(&mut text);
    for &border in &of.borders {
        upper.upright(&mut text, "mark", border);
    }
    for line in &of.lines {
        for piece in line.pieces.iter().flat_map(|piece| inside(piece, &upper)) {
            let most = (of.most * piece.len() / points().count().max(1) * of.lines.len()).max(60);
            upper.line(&mut text, line.class, &thinned(&piece, most.min(of.most)));
        }
    }
    legend(&mut text, &of.lines);
    if let Some((label, residuals)) = &of.residuals {
        let size = range(residuals.iter().map(|p| p.1.abs())).map_or(1.0, |r| r.1);
        let y = Axis::even(label, -1.1 * size, 1.1 * size).few();
        let lower = Axes { x: x(of.time), y, left: LEFT, right: RIGHT, top: LOWER_TOP, bottom: BOTTOM };
        lower.draw(&mut text);
        lower.dots(&mut text, "c4", &thinned(residuals, of.most));
    }
    Figure { name, alternative, caption, elements: text }
}

/// The pieces of a line that lie within the axes.
fn inside(points: &[Point], axes: &Axes) -> Vec<Vec<Point>> {
    let within = |p: &Point| axes.y.low <= p.1 && p.1 <= axes.y.high;
    points.split(|p| !within(p)).filter(|piece| !piece.is_empty()).map(<[Point]>::to_vec).collect()
}

/// Names of the lines in their colours, at the upper right.
fn legend(text: &mut String, lines: &[Line<'_>]) {
    let mut right = RIGHT;
    for line in lines.iter().rev() {
        let colour = line.class.split(' ').next().filter(|class| class.starts_with('c')).unwrap_or_default();
        let (x, y) = (right, TOP - 8.0);
        let _ = writeln!(text, r#"<text class="{colour} name end" x="{x:.1}" y="{y}">{}</text>"#, escaped(line.name));
        right -= 8.4 * line.name.chars().count() as f64 + 14.0;
    }
}
