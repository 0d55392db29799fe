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
use crate::names::method_name;
use crate::numbers::fixed;
use crate::thin::range;

/// Real steps the axis goes to at least.
const LEAST_STEPS: usize = 1_000;

/// One method in the drawing.
struct Line {
    method: String,
    /// Class of its colour.
    class: String,
    /// Scores on the way; the last is carried on to the right.
    points: Vec<Point>,
    /// A score that has nothing to do with real steps, drawn across.
    level: Option<f64>,
}

/// The learning curves of all methods on `task`: all returns, and those from the threshold up, where good methods differ.
pub(crate) fn curves(comparison: &Comparison<'_>, task: &str) -> Vec<Figure> {
    let Comparison { digest, catalog, groups } = comparison;
    let of_task: Vec<&Group> = groups.iter().filter(|group| group.task == task).collect();
    let lines: Vec<Line> = of_task
        .iter()
        .map(|group| {
            let points =
                if catalog.is_reference(&group.method) { Vec::new() } else { curve(digest, task, &group.method) };
            let level = if points.is_empty() { group.returns.as_ref().map(|returns| returns.mean) } else { None };
            Line { method: method_name(&group.method), class: colour(*catalog, &group.method), points, level }
        })
        .collect();
    let mark = catalog.system(task).and_then(|system| system.protocol().solved_at);
    let (low, high) = range(lines.iter().flat_map(Line::scores).chain(mark)).unwrap_or((0.0, 1.0));
    let room = 0.04 * (high - low);
    let figure = |end: &str, what: &str, caption: String, from: f64, to: f64| {
        let name = format!("curves-{task}{end}");
        let elements = drawing((&name, task), &lines, mark, (from, to));
        let alternative = format!("Learning curves on {task}: return against real steps{what}");
        Figure { name, alternative, caption, elements }
    };
    let solved = mark.map_or_else(String::new, |mark| format!(", solved at {}", fixed(mark, 0)));
    let whole = figure("", "", format!("{task}: all returns{solved}"), low - room, high + room);
    // What lies above the threshold can only be seen where something does.
    let above = mark.filter(|mark| lines.iter().any(|line| line.end().is_some_and(|end| end > *mark)));
    let top = above.map(|mark| {
        let room = 0.04 * (high - mark);
        let caption = format!("{task}: the same from the threshold, {}, up", fixed(mark, 0));
        figure("-solved", ", from the threshold up", caption, mark - room, high + room)
    });
    [Some(whole), top].into_iter().flatten().collect()
}

impl Line {
    /// Every return that is drawn.
    fn scores(&self) -> impl Iterator<Item = f64> {
        self.points.iter().flat_map(|point| [point.interval.low, point.interval.high]).chain(self.level)
    }

    /// Where it ends on the right.
    fn end(&self) -> Option<f64> {
        self.points.last().map(|point| point.mean).or(self.level)
    }
}

/// The lines on an axis of returns of `task` from `from` to `to`; what lies beyond is cut off. No other figure of a page is called `name`.
fn drawing((name, task): (&str, &str), lines: &[Line], mark: Option<f64>, (from, to): (f64, f64)) -> String {
    let most = lines.iter().flat_map(|line| line.points.iter().map(|point| point.real_steps));
    let most = most.max().unwrap_or(0).max(LEAST_STEPS) as f64;
    let axes = Axes {
        x: Axis::logarithmic("real steps", 5.0, most),
        y: Axis::even(&format!("return, {task}"), from, to),
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
        if let Some(level) = line.level.filter(|level| (from..=to).contains(level)) {
            axes.level(&mut text, &format!("{} level", line.class), level);
        }
    }
    let all =
        range(lines.iter().flat_map(Line::scores)).map_or((from, to), |(low, high)| (low.min(from), high.max(to)));
    let (beyond, (left, right)) = (axes.beyond(all), (axes.left, axes.right));
    let (width, height) = (right - left, BOTTOM - TOP);
    let _ = writeln!(
        text,
        r##"<clipPath id="clip-{name}"><rect x="{left}" y="{TOP}" width="{width}" height="{height}"/></clipPath>
<g clip-path="url(#clip-{name})">"##
    );
    // The first method lies on top.
    for line in lines.iter().rev() {
        draw(&mut text, &beyond, &line.class, &line.points, most);
    }
    text += "</g>\n";
    let ends = lines.iter().filter_map(|line| {
        let end = line.end().filter(|end| (from..=to).contains(end))?;
        Some(Name { y: axes.y(end), class: line.class.clone(), text: &line.method })
    });
    let ends: Vec<Name<'_>> = ends.collect();
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
        let points = vec![point(100, 0.0), point(1000, 10.0)];
        let line = Line { method: "sac".into(), class: "c0".into(), points, level: None };
        let drawing = drawing(("curves-any", "any"), &[line], Some(10.0), (-0.4, 10.4));
        let curve = drawing.lines().find(|line| line.contains(" curve\"")).expect("there is a curve");
        let numbers: Vec<f64> = curve.split(['"', ' ', ',']).filter_map(|word| word.parse().ok()).collect();
        assert_eq!(numbers[numbers.len() - 2], NAMES_AT, "{curve}");
        assert!(numbers[1] > numbers[3], "a better score stands higher: {curve}");
    }

    #[test]
    fn above_the_threshold_lines_are_where_their_returns_are_and_the_rest_is_cut_off() {
        let point = |real_steps, v: f64| Point { real_steps, mean: v, interval: Interval { low: v, high: v } };
        let line = |name: &str, ends: [f64; 2]| Line {
            method: name.into(),
            class: "c0".into(),
            points: vec![point(100, ends[0]), point(1000, ends[1])],
            level: None,
        };
        let lines = [line("good", [0.0, 100.0]), line("bad", [0.0, 50.0])];
        let text = drawing(("curves-any", "any"), &lines, Some(90.0), (90.0, 100.0));
        let curves: Vec<&str> = text.lines().filter(|line| line.contains(" curve\"")).collect();
        let heights = |line: &str| -> Vec<f64> {
            let points = line.split('"').nth(3).expect("it has points");
            points.split(' ').filter_map(|p| p.split_once(',')?.1.parse().ok()).collect()
        };
        // From 90 to 100 is the height of the panel, so 50 lies four panels below its bottom, and 0 nine.
        let panel = BOTTOM - TOP;
        let expected = [BOTTOM + 9.0 * panel, BOTTOM + 4.0 * panel];
        assert_eq!(heights(curves[0]), expected, "bad is drawn first");
        assert_eq!(heights(curves[1]), [BOTTOM + 9.0 * panel, TOP]);
        assert!(text.contains("good") && !text.contains("bad"), "only what ends in the panel has a name: {text}");
    }

    #[test]
    fn a_task_without_any_score_is_still_drawn() {
        assert!(drawing(("curves-any", "any"), &[], None, (0.0, 1.0)).contains("real steps"));
    }
}
