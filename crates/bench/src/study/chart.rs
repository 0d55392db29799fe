//! Small line charts as SVG: panels side by side over one set of categories.

use std::fmt::Write as _;

use sindyna_core::number::significant;

const WIDTH: f64 = 210.0;
const HEIGHT: f64 = 150.0;
const LEFT: f64 = 46.0;
const TOP: f64 = 34.0;
const GAP: f64 = 22.0;
const COLOURS: [&str; 5] = ["#1f5fa8", "#c2571a", "#3d8b4f", "#7a4fa3", "#888888"];

/// Values of one name, one per category.
type Line = (String, Vec<Option<f64>>);

/// Panels with one axis.
#[derive(Debug, Clone)]
pub struct Chart<'a> {
    /// What the categories are.
    pub across: &'a str,
    /// What the values are.
    pub up: &'a str,
    /// The categories.
    pub categories: Vec<String>,
    /// Lowest and highest value; those beyond are drawn at the border.
    pub range: (f64, f64),
    /// How values are placed.
    pub scale: Scale,
    /// Title and lines of each panel; lines of one name have one colour, those that begin with `STLSQ` are dashed.
    pub panels: Vec<(String, Vec<Line>)>,
}

/// How values are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithms.
    Logarithmic,
}

impl Chart<'_> {
    /// The drawing.
    #[must_use]
    pub fn svg(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in self.panels.iter().flat_map(|(_, lines)| lines) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        let total = LEFT + self.panels.len() as f64 * (WIDTH + GAP);
        let middle = TOP + HEIGHT / 2.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{total}\" height=\"{}\" font-family=\"sans-serif\" font-size=\"11\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
             <text transform=\"translate(12 {middle}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
            TOP + HEIGHT + 62.0,
            self.up
        );
        for (number, (title, lines)) in self.panels.iter().enumerate() {
            let left = LEFT + number as f64 * (WIDTH + GAP);
            text(&mut svg, (left + WIDTH / 2.0, TOP - 12.0), "middle\" font-weight=\"bold", title);
            self.grid(&mut svg, left, number == 0);
            for (name, values) in lines {
                let colour = COLOURS[names.iter().position(|n| n == name).unwrap_or(0) % COLOURS.len()];
                self.line(&mut svg, left, (name, colour), values);
            }
        }
        text(&mut svg, (LEFT + (total - LEFT) / 2.0, TOP + HEIGHT + 32.0), "middle", self.across);
        let mut at = LEFT;
        for (name, colour) in names.iter().zip(COLOURS.iter().cycle()) {
            let y = TOP + HEIGHT + 48.0;
            let _ = writeln!(svg, "<path d=\"M{at:.1} {y}h18\" stroke=\"{colour}\" stroke-width=\"2.5\"/>");
            text(&mut svg, (at + 23.0, y + 4.0), "start", name);
            at += 40.0 + 6.3 * name.chars().count() as f64;
        }
        svg + "</svg>\n"
    }

    fn grid(&self, svg: &mut String, left: f64, labelled: bool) {
        let (low, high) = (self.placed(self.range.0), self.placed(self.range.1));
        let ticks: Vec<f64> = match self.scale {
            Scale::Linear => (0..5).map(|i| low + (high - low) * f64::from(i) / 4.0).collect(),
            Scale::Logarithmic => (low.ceil() as i32..=high.floor() as i32).map(|e| 10_f64.powi(e)).collect(),
        };
        for tick in ticks {
            let y = self.height(tick);
            let _ = writeln!(svg, "<path d=\"M{left} {y:.1}h{WIDTH}\" stroke=\"#dddddd\"/>");
            if labelled {
                text(svg, (left - 4.0, y + 4.0), "end", &significant(tick, 3));
            }
        }
        for (i, category) in self.categories.iter().enumerate() {
            text(svg, (self.across(left, i), TOP + HEIGHT + 14.0), "middle", category);
        }
    }

    fn line(&self, svg: &mut String, left: f64, (name, colour): (&str, &str), values: &[Option<f64>]) {
        let point = |(i, value): (usize, &Option<f64>)| Some((self.across(left, i), self.height((*value)?)));
        let points: Vec<_> = values.iter().enumerate().filter_map(point).collect();
        let path: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
        let dashes = if name.starts_with("STLSQ") { " stroke-dasharray=\"4 3\"" } else { "" };
        if !path.is_empty() {
            let path = path.join("L");
            let _ =
                writeln!(svg, "<path d=\"M{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\"{dashes}/>");
        }
        for (x, y) in points {
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.4\" fill=\"{colour}\"/>");
        }
    }

    fn placed(&self, value: f64) -> f64 {
        if self.scale == Scale::Logarithmic { value.log10() } else { value }
    }

    fn height(&self, value: f64) -> f64 {
        let (low, high) = (self.placed(self.range.0), self.placed(self.range.1));
        let share = (self.placed(value.clamp(self.range.0, self.range.1)) - low) / (high - low);
        TOP + HEIGHT * (1.0 - share)
    }

    fn across(&self, left: f64, i: usize) -> f64 {
        left + 12.0 + (WIDTH - 24.0) * i as f64 / self.categories.len().saturating_sub(1).max(1) as f64
    }
}

fn text(svg: &mut String, (x, y): (f64, f64), anchor: &str, words: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
}
