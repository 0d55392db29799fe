//! What the digits of a column tell of its rounding.

use std::ops::RangeInclusive;

/// Digits of numbers that are measured with an error of their last digit: computed ones are seldom written with so few.
const COARSE: RangeInclusive<usize> = 1..=6;

/// Digits of numbers that were computed, and rounded when they were written: a float64 needs more.
const FINE: RangeInclusive<usize> = 7..=15;

/// How the numbers of a column were written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Written {
    /// With all their digits.
    InFull,
    /// With fewer digits than a float64 has: in such steps.
    Finely {
        /// Distance of two neighbouring numbers.
        step: f64,
        /// Most digits of a number.
        digits: usize,
    },
    /// With few digits: in such steps.
    Coarsely(f64),
}

impl Written {
    /// The step of numbers that were rounded to many digits, 0 of others.
    pub(crate) fn fine(self) -> f64 {
        if let Self::Finely { step, .. } = self { step } else { 0.0 }
    }

    /// The step of numbers that were written with fewer digits than a float64 has, 0 of others.
    pub(crate) fn step(self) -> f64 {
        match self {
            Self::InFull => 0.0,
            Self::Finely { step, .. } | Self::Coarsely(step) => step,
        }
    }
}

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

    /// How the numbers of this column were written: the step is that of the largest ones if steps differ.
    pub(crate) fn written(&self) -> Written {
        // One number, again and again, is written as short as it is.
        let moves = self.range.is_some_and(|(low, high)| low < high);
        if !(moves && self.broken && self.reach > 0.0) {
            return Written::InFull;
        }
        let digits = self.digits;
        let step = 10_f64.powi(self.reach.log10().floor() as i32 + 1 - digits as i32);
        match digits {
            digits if COARSE.contains(&digits) => Written::Coarsely(step),
            digits if FINE.contains(&digits) => Written::Finely { step, digits },
            _ => Written::InFull,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_tell_a_step_where_they_are_not_all() {
        let written = |cells: &[&str]| {
            let mut seen = Resolution::default();
            cells.iter().for_each(|c| seen.see(c, c.parse().expect("a number")));
            seen.written()
        };
        let is = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-12;
        let coarse = |written: Written, step: f64| matches!(written, Written::Coarsely(found) if is(found, step));
        assert!(coarse(written(&["3.014", "-0.020", "0.5"]), 1e-3));
        assert!(coarse(written(&["12.3456", "0.0123456", "1e-5"]), 1e-4), "six digits of the largest");
        let fine = written(&["0.33333334", "0.25"]);
        assert!(matches!(fine, Written::Finely { step, digits: 8 } if is(step, 1e-8)), "{fine:?}");
        assert_eq!(written(&["0.1", "0.3333333333333333"]), Written::InFull);
        assert_eq!(written(&["1", "2", "-5"]), Written::InFull, "whole numbers are counts");
        assert_eq!(written(&["0.7", "0.7"]), Written::InFull, "a constant is written as short as it is");
    }
}
