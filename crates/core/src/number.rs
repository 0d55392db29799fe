//! Numbers as people read them: the one place where digits, signs and thousands are decided.
//!
//! The minus of a number is U+2212, as in equations; [`ascii`] is for text that programs read.

/// `value` with `digits` significant digits and no trailing zeros; a scientific form where zeros would pile up.
///
/// ```
/// use sindyna_core::number::significant;
/// assert_eq!(significant(0.1 + 0.2, 9), "0.3");
/// assert_eq!(significant(-1.26e-6, 2), "−1.3e−6");
/// ```
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    with_minus(&ascii(value, digits))
}

/// [`significant`] digits for programs and their languages, whose minus is a hyphen.
///
/// ```
/// assert_eq!(sindyna_core::number::ascii(-1.26e-6, 2), "-1.3e-6");
/// ```
#[must_use]
pub fn ascii(value: f64, digits: usize) -> String {
    rounded(value, digits, -4)
}

/// `value` as a coefficient of a printed equation: six significant digits.
#[must_use]
pub fn coefficient(value: f64) -> String {
    with_minus(&rounded(value, 6, -5))
}

/// `value` with so many digits behind the point.
///
/// ```
/// assert_eq!(sindyna_core::number::decimals(-1234.56, 1), "−1234.6");
/// ```
#[must_use]
pub fn decimals(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    // What is rounded to zero has no sign.
    let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
    with_minus(if zero { text.trim_start_matches('-') } else { &text })
}

/// `text` with U+2212 for every hyphen.
fn with_minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

/// `value` with `digits` significant digits; below ten to the power `least` in scientific form.
fn rounded(value: f64, digits: usize, least: i32) -> String {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = text.split_once('e') else { return value.to_string() };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if (least..digits as i32).contains(&exponent) {
        trim(&format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize))
    } else {
        format!("{}e{exponent}", trim(mantissa))
    }
}

/// `value` in as few digits as tell it from others: of float32 where it is one (−1.2, not −1.2000000476837158).
#[must_use]
pub fn shortest(value: f64) -> String {
    let narrow = value as f32;
    let is_narrow = f64::from(narrow).to_bits() == value.to_bits();
    with_minus(&if is_narrow { narrow.to_string() } else { value.to_string() })
}

/// `value` with so many digits behind the point, thousands set apart; ∞ for infinity.
///
/// ```
/// assert_eq!(sindyna_core::number::fixed(-1234.56, 1), "−1,234.6");
/// ```
#[must_use]
pub fn fixed(value: f64, digits: usize) -> String {
    if value.is_infinite() {
        return if value > 0.0 { "∞".into() } else { "−∞".into() };
    }
    grouped(&decimals(value, digits))
}

/// `count` and `what`, with an s unless there is one of it.
///
/// ```
/// assert_eq!(sindyna_core::number::plural(1, "run"), "1 run");
/// assert_eq!(sindyna_core::number::plural(2, "run"), "2 runs");
/// ```
#[must_use]
pub fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Thousands set apart.
fn grouped(text: &str) -> String {
    let (whole, rest) = text.split_once('.').map_or((text, String::new()), |(whole, rest)| (whole, format!(".{rest}")));
    let (sign, digits) = whole.strip_prefix('−').map_or(("", whole), |digits| ("−", digits));
    let mut found = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            found.push(',');
        }
        found.push(digit);
    }
    format!("{sign}{found}{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_are_kept_and_zeros_are_not() {
        for (value, digits, text) in [
            (15.0, 9, "15"),
            (0.1 + 0.2, 9, "0.3"),
            (-0.002_512_345, 3, "−0.00251"),
            (1.26e-6, 2, "1.3e−6"),
            (131_000.0, 2, "1.3e5"),
            (0.0, 2, "0"),
            (99.9, 2, "1e2"),
            (f64::INFINITY, 2, "inf"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }

    #[test]
    fn every_printer_has_one_minus() {
        let shown = [significant(-2.5e-7, 3), coefficient(-2.5e-7), decimals(-2.5, 1), shortest(-2.5), fixed(-2.5, 1)];
        assert_eq!(shown, ["−2.5e−7", "−2.5e−7", "−2.5", "−2.5", "−2.5"]);
        assert_eq!((decimals(-0.04, 1), ascii(-2.5e-7, 3)), ("0.0".into(), "-2.5e-7".into()));
    }

    #[test]
    fn coefficients_have_six_digits_and_no_padding() {
        for (value, text) in [
            (15.0, "15"),
            (-0.0025, "−0.0025"),
            (2.0 / 3.0, "0.666667"),
            (123_456.7, "123457"),
            (1.5e-9, "1.5e−9"),
            (-2e10, "−2e10"),
            (0.0, "0"),
            (999_999.9, "1e6"),
        ] {
            assert_eq!(coefficient(value), text);
        }
    }

    #[test]
    fn widened_float32_is_shown_as_it_was_written() {
        for (value, text) in [(f64::from(-1.2_f32), "−1.2"), (-1.2, "−1.2"), (8.0, "8"), (f64::from(0.07_f32), "0.07")]
        {
            assert_eq!(shortest(value), text);
        }
    }

    #[test]
    fn numbers_are_grouped_and_signed() {
        for (value, digits, text) in [
            (-1234.56, 1, "−1,234.6"),
            (613_036.0, 0, "613,036"),
            (-0.04, 1, "0.0"),
            (f64::INFINITY, 0, "∞"),
            (12_345.5, 1, "12,345.5"),
        ] {
            assert_eq!(fixed(value, digits), text);
        }
    }
}
