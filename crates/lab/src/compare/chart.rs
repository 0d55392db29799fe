//! A learning curve as a drawing.

use std::fmt::Write as _;

use super::curve::Quartiles;

/// One method in a drawing.
pub(crate) struct Line {
    pub(crate) name: String,
    /// Scores on the way; one point is carried on to the right.
    pub(crate) points: Vec<Quartiles>,
    /// A score that has nothing to do with real steps, drawn across.
    pub(crate) level: Option<f64>,
}

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 340.0;
/// Left, right, top, bottom.
const MARGIN: (f64, f64, f64, f64) = (62.0, 96.0, 14.0, 40.0);

/// Real steps the axis goes to at least.
const LEAST_STEPS: usize = 1_000;

/// Colours that people who see colours otherwise can tell apart too (Okabe, Ito 2008); the page names them.
const COLOURS: usize = 7;

/// The drawing of `lines`, as SVG whose colours are the classes `c0` to `c6`; `mark` is the return that solves the task.
pub(crate) fn svg(title: &str, lines: &[Line], mark: Option<f64>) -> String {
    let scores = lines.iter().flat_map(|l| l.points.iter().flat_map(|q| [q.low, q.high]).chain(l.level)).chain(mark);
    let (low, high) = scores.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let (low, high) = if low < high { (low, high) } else { (low - 1.0, low + 1.0) };
    let most = lines.iter().flat_map(|l| l.points.iter().map(|q| q.real_steps)).max().unwrap_or(0).max(LEAST_STEPS);
    let axes = Axes { steps: (5.0, most as f64), scores: (low, high + 0.04 * (high - low)) };
    let mut text = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{title}: return against real steps\" \
         xmlns=\"http://www.w3.org/2000/svg\">\n"
    );
    axes.draw(&mut text);
    if let Some(mark) = mark {
        let y = axes.y(mark);
        let _ = writeln!(
            text,
            "<line class=\"mark\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
            MARGIN.0,
            WIDTH - MARGIN.1
        );
    }
    let mut names: Vec<(f64, usize, &str)> = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let colour = i % COLOURS;
        if let Some(level) = line.level {
            let y = axes.y(level);
            let _ = writeln!(
                text,
                "<line class=\"c{colour} level\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
                MARGIN.0,
                WIDTH - MARGIN.1
            );
            names.push((y, colour, &line.name));
        }
        let (Some(first), Some(last)) = (line.points.first(), line.points.last()) else { continue };
        let end = Quartiles { real_steps: most, ..*last };
        let points: Vec<&Quartiles> = line.points.iter().chain([&end]).collect();
        let place = |q: &Quartiles, v: f64| format!("{:.1},{:.1}", axes.x(q.real_steps as f64), axes.y(v));
        let up: Vec<String> = points.iter().map(|q| place(q, q.high)).collect();
        let down: Vec<String> = points.iter().rev().map(|q| place(q, q.low)).collect();
        let middle: Vec<String> = points.iter().map(|q| place(q, q.middle)).collect();
        let _ = writeln!(text, "<polygon class=\"c{colour} band\" points=\"{} {}\"/>", up.join(" "), down.join(" "));
        let _ = writeln!(text, "<polyline class=\"c{colour} curve\" points=\"{}\"/>", middle.join(" "));
        let (x, y) = (axes.x(first.real_steps as f64), axes.y(first.middle));
        let _ = writeln!(text, "<circle class=\"c{colour} dot\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
        names.push((axes.y(last.middle), colour, &line.name));
    }
    // Names stand at the right end of their lines, one below the other where these meet.
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = 0.0_f64;
    for (y, colour, name) in names {
        let y = (y + 4.0).max(free + 13.0);
        free = y;
        let _ = writeln!(
            text,
            "<text class=\"c{colour} name\" x=\"{:.1}\" y=\"{y:.1}\">{name}</text>",
            WIDTH - MARGIN.1 + 6.0
        );
    }
    text + "</svg>\n"
}

struct Axes {
    steps: (f64, f64),
    scores: (f64, f64),
}

impl Axes {
    /// Real steps, on a logarithmic axis.
    fn x(&self, steps: f64) -> f64 {
        let (low, high) = (self.steps.0.ln(), self.steps.1.ln());
        MARGIN.0 + (steps.max(self.steps.0).ln() - low) / (high - low) * (WIDTH - MARGIN.0 - MARGIN.1)
    }

    fn y(&self, score: f64) -> f64 {
        let share = (score - self.scores.0) / (self.scores.1 - self.scores.0);
        HEIGHT - MARGIN.3 - share * (HEIGHT - MARGIN.2 - MARGIN.3)
    }

    fn draw(&self, text: &mut String) {
        let (bottom, right) = (HEIGHT - MARGIN.3, WIDTH - MARGIN.1);
        let mut decade = 10.0;
        while decade <= self.steps.1 {
            let x = self.x(decade);
            let _ = writeln!(
                text,
                "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{}\" y2=\"{bottom}\"/>",
                MARGIN.2
            );
            let _ = writeln!(
                text,
                "<text class=\"tick\" text-anchor=\"middle\" x=\"{x:.1}\" y=\"{:.1}\">{decade}</text>",
                bottom + 16.0
            );
            decade *= 10.0;
        }
        for tick in ticks(self.scores.0, self.scores.1) {
            let y = self.y(tick);
            let _ =
                writeln!(text, "<line class=\"grid\" x1=\"{}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>", MARGIN.0);
            let _ = writeln!(
                text,
                "<text class=\"tick\" text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{tick}</text>",
                MARGIN.0 - 6.0,
                y + 4.0
            );
        }
        let middle = 0.5 * (MARGIN.0 + right);
        let _ = writeln!(
            text,
            "<text class=\"tick\" text-anchor=\"middle\" x=\"{middle:.1}\" y=\"{:.1}\">real steps</text>",
            HEIGHT - 6.0
        );
    }
}

/// Four to eight round numbers between `low` and `high`.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 5.0;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * power).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(-1200.0, -140.0), [-1000.0, -500.0]);
        assert_eq!(ticks(0.0, 100.0), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
    }

    #[test]
    fn a_curve_ends_at_the_right_border_and_falls_where_scores_fall() {
        let q = |real_steps, v: f64| Quartiles { real_steps, low: v, middle: v, high: v };
        let line = Line { name: "sac".into(), points: vec![q(100, 0.0), q(1000, 10.0)], level: None };
        let drawing = svg("any", &[line], Some(10.0));
        let curve = drawing.lines().find(|l| l.contains("polyline")).expect("there is a curve");
        let numbers: Vec<f64> = curve.split(['"', ' ', ',']).filter_map(|word| word.parse().ok()).collect();
        let n = numbers.len();
        assert!((numbers[n - 2] - (WIDTH - MARGIN.1)).abs() < 0.1, "{curve}");
        assert!(numbers[1] > numbers[3], "a better score stands higher: {curve}");
    }
}
