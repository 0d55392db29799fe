//! A rectangle of a drawing with numbers at its borders.

use std::fmt::Write as _;

use crate::escape::escaped;
use crate::numbers::significant;
use crate::thin::simplified;

/// How far a line may pass from a point that is left out, in units of the drawing.
const TOLERANCE: f64 = 0.15;

/// How numbers are spread over an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Spacing {
    Even,
    Logarithmic,
}

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) spacing: Spacing,
    /// Parts that numbers divide it into, or one more.
    parts: f64,
    /// Whether it counts.
    whole: bool,
}

impl Axis {
    pub(super) fn even(label: &str, low: f64, high: f64) -> Self {
        // A span that the numbers cannot resolve is none.
        let least = 1e-9 * low.abs().max(high.abs());
        let (low, high) = if high - low > least { (low, high) } else { (low - least.max(1.0), high + least.max(1.0)) };
        Self { label: label.into(), low, high, spacing: Spacing::Even, parts: 5.0, whole: false }
    }

    pub(super) fn logarithmic(label: &str, low: f64, high: f64) -> Self {
        Self { label: label.into(), low, high, spacing: Spacing::Logarithmic, parts: 6.0, whole: false }
    }

    /// The same with few numbers, for a small panel.
    pub(super) fn few(self) -> Self {
        Self { parts: if self.spacing == Spacing::Logarithmic { 4.0 } else { 2.0 }, ..self }
    }

    /// The same for counts: only whole numbers stand at it.
    pub(super) fn whole(self) -> Self {
        Self { whole: true, ..self }
    }

    /// Where `value` lies between both ends, 0 to 1; what is beyond lies at the end.
    fn share(&self, value: f64) -> f64 {
        let place = |v: f64| if self.spacing == Spacing::Logarithmic { v.max(self.low).log10() } else { v };
        ((place(value) - place(self.low)) / (place(self.high) - place(self.low))).clamp(0.0, 1.0)
    }

    fn shown(&self, tick: f64) -> String {
        if self.spacing == Spacing::Logarithmic { power(tick) } else { shown(tick) }
    }

    fn ticks(&self) -> Vec<f64> {
        let mut ticks = match self.spacing {
            Spacing::Even => round_numbers(self.low, self.high, self.parts),
            Spacing::Logarithmic => powers_of_ten(self.low, self.high, self.parts),
        };
        ticks.retain(|tick| !self.whole || tick.fract() == 0.0);
        ticks
    }
}

/// The rectangle, in units of the drawing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axes {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Axes {
    /// The same scale of values across a longer axis upwards, from `low` to `high`, that leaves the rectangle.
    pub(super) fn beyond(&self, (low, high): (f64, f64)) -> Self {
        let unit = (self.bottom - self.top) / (self.y.high - self.y.low);
        let y = Axis { low, high, ..self.y.clone() };
        let (top, bottom) = (self.top - (high - self.y.high) * unit, self.bottom + (self.y.low - low) * unit);
        Self { x: self.x.clone(), y, top, bottom, ..*self }
    }

    pub(super) fn x(&self, value: f64) -> f64 {
        self.left + self.x.share(value) * (self.right - self.left)
    }

    pub(super) fn y(&self, value: f64) -> f64 {
        self.bottom - self.y.share(value) * (self.bottom - self.top)
    }

    /// Both coordinates as a polyline has them.
    pub(super) fn point(&self, (x, y): (f64, f64)) -> String {
        format!("{:.1},{:.1}", self.x(x), self.y(y))
    }

    /// Grid, numbers and names of both axes.
    pub(super) fn draw(&self, text: &mut String) {
        self.draw_across(text);
        let Self { left, right, top, .. } = *self;
        for tick in self.y.ticks() {
            let y = self.y(tick);
            let _ = writeln!(text, r#"<line class="grid" x1="{left}" x2="{right}" y1="{y:.1}" y2="{y:.1}"/>"#);
            let _ = writeln!(
                text,
                r#"<text class="end" x="{:.1}" y="{:.1}">{}</text>"#,
                left - 6.0,
                y + 4.5,
                self.y.shown(tick)
            );
        }
        let _ = writeln!(text, r#"<text x="{:.1}" y="{:.1}">{}</text>"#, left, top - 8.0, escaped(&self.y.label));
    }

    /// The same of the axis across alone.
    pub(super) fn draw_across(&self, text: &mut String) {
        let Self { left, right, top, bottom, .. } = *self;
        for tick in self.x.ticks() {
            let x = self.x(tick);
            let _ = writeln!(text, r#"<line class="grid" x1="{x:.1}" x2="{x:.1}" y1="{top}" y2="{bottom}"/>"#);
            let _ = writeln!(
                text,
                r#"<text class="middle" x="{x:.1}" y="{:.1}">{}</text>"#,
                bottom + 17.0,
                self.x.shown(tick)
            );
        }
        let middle = 0.5 * (left + right);
        let _ = writeln!(
            text,
            r#"<text class="middle" x="{middle:.1}" y="{:.1}">{}</text>"#,
            bottom + 35.0,
            escaped(&self.x.label)
        );
    }

    /// A level all across.
    pub(super) fn level(&self, text: &mut String, class: &str, value: f64) {
        let (left, right, y) = (self.left, self.right, self.y(value));
        let _ = writeln!(text, r#"<line class="{class}" x1="{left}" x2="{right}" y1="{y:.1}" y2="{y:.1}"/>"#);
    }

    /// Straight lines from point to point; points are left out that nobody would miss.
    pub(super) fn line(&self, text: &mut String, class: &str, points: &[(f64, f64)]) {
        let places: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (self.x(x), self.y(y))).collect();
        let shown = |(x, y): &(f64, f64)| format!("{x:.1},{y:.1}");
        let points: Vec<String> = simplified(&places, TOLERANCE).iter().map(shown).collect();
        let _ = writeln!(text, r#"<polyline class="{class}" points="{}"/>"#, points.join(" "));
    }

    /// A dot at each point: one element for all of them.
    pub(super) fn dots(&self, text: &mut String, class: &str, points: &[(f64, f64)]) {
        let place = |&(x, y): &(f64, f64)| format!("M{:.0} {:.0}h0", self.x(x), self.y(y));
        let path: String = points.iter().map(place).collect();
        let _ = writeln!(text, r#"<path class="{class} dots" d="{path}"/>"#);
    }

    /// A line from the bottom to the top.
    pub(super) fn upright(&self, text: &mut String, class: &str, value: f64) {
        let (top, bottom, x) = (self.top, self.bottom, self.x(value));
        let _ = writeln!(text, r#"<line class="{class}" x1="{x:.1}" x2="{x:.1}" y1="{top}" y2="{bottom}"/>"#);
    }

    pub(super) fn dot(&self, text: &mut String, class: &str, (x, y): (f64, f64), radius: f64) {
        let (x, y) = (self.x(x), self.y(y));
        let _ = writeln!(text, r#"<circle class="{class}" cx="{x:.1}" cy="{y:.1}" r="{radius}"/>"#);
    }
}

/// A number at an axis.
fn shown(value: f64) -> String {
    significant(value, 6)
}

/// A power of ten, such as 10⁻³.
fn power(value: f64) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32(u32::from('⁰') + u32::from(c) - u32::from('0')).unwrap_or(c),
        _ => c,
    };
    let exponent = value.log10().round() as i32;
    "10".to_owned() + &exponent.to_string().chars().map(digit).collect::<String>()
}

/// Powers of ten between `low` and `high`, about `most` at most.
fn powers_of_ten(low: f64, high: f64, most: f64) -> Vec<f64> {
    let (first, last) = (low.log10().ceil() as i32, high.log10().floor() as i32);
    let step = ((last - first) / most as i32 + 1).max(1);
    (first..=last).filter(|exponent| exponent.rem_euclid(step) == 0).map(|exponent| 10_f64.powi(exponent)).collect()
}

/// Round numbers between `low` and `high`, which divide it into about so many `parts`.
fn round_numbers(low: f64, high: f64, parts: f64) -> Vec<f64> {
    let rough = (high - low) / parts;
    let power = rough.log10().floor() as i32;
    let steps = [(1, power), (2, power), (5, power), (1, power + 1)];
    let size = |(digit, power): (i32, i32)| f64::from(digit) * 10_f64.powi(power);
    let (digit, power) = steps.into_iter().find(|step| size(*step) >= rough * (1.0 - 1e-9)).unwrap_or((1, power + 1));
    let step = size((digit, power));
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    // Divided by a whole number where there is one, so that 0.6 is 0.6 and not 0.6000000000000001.
    let number = |i: i64| {
        let whole = (i * i64::from(digit)) as f64;
        if power < 0 { whole / 10_f64.powi(-power) } else { whole * 10_f64.powi(power) }
    };
    (first..=last).map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(round_numbers(-1200.0, -140.0, 5.0), [-1000.0, -500.0]);
        assert_eq!(round_numbers(0.0, 100.0, 5.0), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(round_numbers(0.0, 1.0, 5.0), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        assert_eq!(powers_of_ten(5.0, 20_000.0, 6.0), [10.0, 100.0, 1_000.0, 10_000.0]);
        assert_eq!(powers_of_ten(1e-14, 1e13, 6.0).len(), 5, "27 decades have no 27 numbers");
        assert_eq!((shown(-0.5), shown(2e-13), shown(1e6)), ("−0.5".into(), "2e−13".into(), "1e6".into()));
        assert_eq!([1.0, 10.0, 1e-3, 1e14].map(power), ["10⁰", "10¹", "10⁻³", "10¹⁴"]);
    }

    #[test]
    fn what_lies_beyond_an_axis_is_drawn_at_its_end() {
        let axes = Axes {
            x: Axis::logarithmic("", 10.0, 1_000.0),
            y: Axis::even("", 0.0, 2.0),
            left: 0.0,
            right: 100.0,
            top: 0.0,
            bottom: 50.0,
        };
        assert_eq!((axes.x(100.0), axes.x(1.0), axes.x(1e6)), (50.0, 0.0, 100.0));
        assert_eq!((axes.y(1.0), axes.y(-3.0), axes.y(2.0)), (25.0, 50.0, 0.0));
        assert_eq!(Axis::even("", 3.0, 3.0), Axis::even("", 2.0, 4.0), "a single value has room around it");
    }
}
