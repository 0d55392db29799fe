//! What the digits of a column tell of its rounding.

/// Digits of a number that nobody rounded: a float32 has up to nine, a float64 up to seventeen.
const FULL: usize = 7;

/// What the text of a column tells of its rounding.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Resolution {
    /// Most digits of a number, leading zeros not counted.
    digits: usize,
    /// Largest magnitude.
    reach: f64,
    /// Whether a number was not whole: counts and settings are written in full.
    broken: bool,
    /// Smallest and largest number.
    range: Option<(f64, f64)>,
}

impl Resolution {
    pub(crate) fn see(&mut self, text: &str, value: f64) {
        let mantissa = text.trim_start_matches(['-', '+']).split(['e', 'E']).next().unwrap_or("");
        let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
        self.digits = self.digits.max(digits.trim_start_matches('0').len());
        self.reach = self.reach.max(value.abs());
        self.broken |= value.fract() != 0.0;
        let (low, high) = self.range.unwrap_or((value, value));
        self.range = Some((low.min(value), high.max(value)));
    }

    /// The step between two numbers of this column, where it was rounded to fewer digits than a float32 has; of the largest ones
    /// if steps differ.
    pub(crate) fn step(&self) -> Option<f64> {
        // One number, again and again, is written as short as it is.
        let moves = self.range.is_some_and(|(low, high)| low < high);
        let rounded = moves && self.broken && self.reach > 0.0 && (1..FULL).contains(&self.digits);
        rounded.then(|| 10_f64.powi(self.reach.log10().floor() as i32 + 1 - self.digits as i32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_digits_tell_a_step_and_many_do_not() {
        let step = |cells: &[&str]| {
            let mut seen = Resolution::default();
            cells.iter().for_each(|c| seen.see(c, c.parse().expect("a number")));
            seen.step()
        };
        let near = |found: Option<f64>, expected: f64| found.is_some_and(|f| (f / expected - 1.0).abs() < 1e-12);
        assert!(near(step(&["3.014", "-0.020", "0.5"]), 1e-3));
        assert!(near(step(&["12.3456", "0.0123456", "1e-5"]), 1e-4), "six digits of the largest");
        assert_eq!(step(&["0.1", "0.3333333333333333"]), None);
        assert_eq!(step(&["0.33333334", "0.25"]), None);
        assert_eq!(step(&["1", "2", "-5"]), None, "whole numbers are counts");
        assert_eq!(step(&["0.7", "0.7"]), None, "a constant is written as short as it is");
    }
}
