//! What a run costs: real steps, and wall-clock time.

use std::fmt::Write as _;

use super::axes::{Axes, Axis};
use super::drawing::Figure;
use super::frame::{BOTTOM, TOP, WIDTH};
use crate::escape::escaped;
use crate::stats::median;
use crate::thin::range;

/// All runs of one method.
pub(crate) struct CostRow {
    pub(crate) method: String,
    /// Class of its colour.
    pub(crate) class: String,
    /// Real steps until solved, infinite for runs that never solve the task; none where they say nothing of the method.
    pub(crate) steps: Vec<f64>,
    pub(crate) seconds: Vec<f64>,
}

/// Right end of the names, and ends of both panels.
const NAMES: f64 = 118.0;
const STEPS: (f64, f64) = (128.0, 272.0);
const SECONDS: (f64, f64) = (308.0, WIDTH - 18.0);

/// Half the height of the mark at a median.
const MARK: f64 = 6.0;

/// A row for each method, a dot for each seed; `None` if no time is known.
pub(crate) fn costs(task: &str, rows: &[CostRow]) -> Option<Figure> {
    let steps = panel("real steps until solved", STEPS, rows.iter().flat_map(|row| &row.steps));
    let seconds = panel("wall-clock time [s]", SECONDS, rows.iter().flat_map(|row| &row.seconds))?;
    let mut text = String::new();
    for axes in steps.iter().chain([&seconds]) {
        axes.draw_across(&mut text);
    }
    let height = (BOTTOM - TOP) / rows.len().max(1) as f64;
    for (i, row) in rows.iter().enumerate() {
        let y = TOP + (i as f64 + 0.5) * height;
        let (class, name) = (&row.class, escaped(&row.method));
        let _ = writeln!(text, r#"<text class="{class} name end" x="{NAMES}" y="{:.1}">{name}</text>"#, y + 4.5);
        for (axes, values) in [(steps.as_ref(), &row.steps), (Some(&seconds), &row.seconds)] {
            let Some(axes) = axes else { continue };
            let finite = values.iter().filter(|value| value.is_finite());
            let dots: String = finite.map(|&value| format!("M{:.1} {y:.1}h0", axes.x(value))).collect();
            let _ = writeln!(text, r#"<path class="{class} seeds" d="{dots}"/>"#);
            if values.iter().any(|value| value.is_infinite()) {
                let _ = writeln!(text, r#"<circle class="{class} ring" cx="{}" cy="{y:.1}" r="3"/>"#, axes.right);
            }
            if let Some(middle) = median(values).filter(|middle| middle.is_finite()) {
                let (x, top, bottom) = (axes.x(middle), y - MARK, y + MARK);
                let _ = writeln!(
                    text,
                    r#"<line class="{class} tick" x1="{x:.1}" x2="{x:.1}" y1="{top:.1}" y2="{bottom:.1}"/>"#
                );
            }
        }
    }
    Some(Figure {
        name: format!("wall-time-{task}"),
        alternative: format!(
            "Real steps until solved and wall-clock time of a run on {task}, for each method and seed"
        ),
        caption: format!("{task}: a dot for each seed, a stroke at the median; ring: some seeds never solve it"),
        elements: text,
    })
}

/// A panel with whole decades; `None` without any number.
fn panel<'v>(label: &str, (left, right): (f64, f64), values: impl Iterator<Item = &'v f64>) -> Option<Axes> {
    let (low, high) = range(values.copied().filter(|v| *v > 0.0))?;
    let x = Axis::logarithmic(label, 10_f64.powf(low.log10().floor()), 10_f64.powf(high.log10().floor() + 1.0)).few();
    Some(Axes { x, y: Axis::even("", 0.0, 1.0), left, right, top: TOP, bottom: BOTTOM })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_has_a_dot_and_those_that_never_solve_the_task_a_ring() {
        let row =
            |steps: Vec<f64>| CostRow { method: "a<b".into(), class: "c0".into(), steps, seconds: vec![2.0, 3.0] };
        let figure = costs("any", &[row(vec![10.0, f64::INFINITY]), row(Vec::new())]).expect("there are times");
        let text = &figure.elements;
        assert_eq!((text.matches("h0").count(), text.matches("ring").count()), (5, 1), "{text}");
        assert_eq!(text.matches("tick").count(), 2, "the median of a solved and an unsolved run is infinite: {text}");
        assert!(text.contains("a&lt;b") && costs("any", &[]).is_none());
    }
}
