//! Learning curves.

use std::fmt::Write as _;

use super::axes::{Axes, Axis};
use super::drawing::Figure;
use super::frame::{BOTTOM, LEFT, NAMES_AT, TOP};
use super::names::{self, Name};
use super::style::colour;
use crate::Comparison;
use crate::curve::{Point, curve};
use crate::groups::Group;
use crate::numbers::fixed;

/// Real steps the axis goes to at least.
const LEAST_STEPS: usize = 1_000;

/// One method in the drawing.
struct Line<'a> {
    method: &'a str,
    /// Class of its colour.
    class: String,
    /// Scores on the way; the last is carried on to the right.
    points: Vec<Point>,
    /// A score that has nothing to do with real steps, drawn across.
    level: Option<f64>,
}

/// The learning curves of all methods on `task`.
pub(crate) fn curves(comparison: &Comparison<'_>, task: &str) -> Figure {
    let Comparison { digest, catalog, groups } = comparison;
    let of_task: Vec<&Group> = groups.iter().filter(|group| group.task == task).collect();
    let lines: Vec<Line<'_>> = of_task
        .iter()
        .map(|group| {
            let points =
                if catalog.is_reference(&group.method) { Vec::new() } else { curve(digest, task, &group.method) };
            let level = if points.is_empty() { group.returns.as_ref().map(|returns| returns.mean) } else { None };
            Line { method: &group.method, class: colour(*catalog, &group.method), points, level }
        })
        .collect();
    let mark = catalog.system(task).and_then(|system| system.protocol().solved_at);
    Figure {
        name: format!("curves-{task}"),
        alternative: format!("Learning curves on {task}: return against real steps"),
        caption: mark.map_or_else(|| task.to_owned(), |mark| format!("{task}: solved at {}", fixed(mark, 0))),
        elements: drawing(task, &lines, mark),
    }
}

fn drawing<'l>(task: &str, lines: &'l [Line<'l>], mark: Option<f64>) -> String {
    let of_line = |line: &Line<'_>| {
        let ends = line.points.iter().flat_map(|point| [point.interval.low, point.interval.high]);
        ends.chain(line.level).collect::<Vec<_>>()
    };
    let scores: Vec<f64> = lines.iter().flat_map(of_line).chain(mark).collect();
    let low = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let high = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
    let room = 0.04 * (high - low);
    let most = lines.iter().flat_map(|line| line.points.iter().map(|point| point.real_steps));
    let most = most.max().unwrap_or(0).max(LEAST_STEPS) as f64;
    let axes = Axes {
        x: Axis::logarithmic("real steps", 5.0, most),
        y: Axis::even(&format!("return, {task}"), low - room, high + room),
        left: LEFT,
        right: NAMES_AT,
        top: TOP,
        bottom: BOTTOM,
    };
    let mut text = String::new();
    axes.draw(&mut text);
    if let Some(mark) = mark {
        axes.level(&mut text, "mark", mark);
    }
    for line in lines {
        if let Some(level) = line.level {
            axes.level(&mut text, &format!("{} level", line.class), level);
        }
    }
    // The first method lies on top.
    for line in lines.iter().rev() {
        draw(&mut text, &axes, &line.class, &line.points, most);
    }
    let end = |line: &Line<'_>| line.points.last().map(|point| point.mean).or(line.level);
    let name = |line: &'l Line<'l>| Some(Name { y: axes.y(end(line)?), class: line.class.clone(), text: line.method });
    let ends: Vec<Name<'_>> = lines.iter().filter_map(name).collect();
    names::draw(&mut text, ends, NAMES_AT, (TOP, BOTTOM));
    text
}

/// A curve with its band, up to the right end of the axis.
fn draw(text: &mut String, axes: &Axes, class: &str, points: &[Point], most: f64) {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
    let carried = (most, *last);
    let places: Vec<(f64, Point)> = points.iter().map(|p| (p.real_steps as f64, *p)).chain([carried]).collect();
    let along = |of: fn(&Point) -> f64| places.iter().map(move |(x, point)| (*x, of(point)));
    let up: Vec<String> = along(|p| p.interval.high).map(|p| axes.point(p)).collect();
    let down: Vec<String> = along(|p| p.interval.low).rev().map(|p| axes.point(p)).collect();
    let _ = writeln!(text, r#"<polygon class="{class} band" points="{} {}"/>"#, up.join(" "), down.join(" "));
    axes.line(text, &format!("{class} curve"), &along(|p| p.mean).collect::<Vec<_>>());
    axes.dot(text, class, (first.real_steps as f64, first.mean), 3.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Interval;

    #[test]
    fn a_curve_ends_at_the_right_border_and_falls_where_scores_fall() {
        let point = |real_steps, v: f64| Point { real_steps, mean: v, interval: Interval { low: v, high: v } };
        let line =
            Line { method: "sac", class: "c0".into(), points: vec![point(100, 0.0), point(1000, 10.0)], level: None };
        let drawing = drawing("any", &[line], Some(10.0));
        let curve = drawing.lines().find(|line| line.contains("curve")).expect("there is a curve");
        let numbers: Vec<f64> = curve.split(['"', ' ', ',']).filter_map(|word| word.parse().ok()).collect();
        assert_eq!(numbers[numbers.len() - 2], NAMES_AT, "{curve}");
        assert!(numbers[1] > numbers[3], "a better score stands higher: {curve}");
    }

    #[test]
    fn a_task_without_any_score_is_still_drawn() {
        assert!(drawing("any", &[], None).contains("real steps"));
    }
}
