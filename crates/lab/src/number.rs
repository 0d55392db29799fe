//! Numbers as people read them.

/// `value` with `digits` significant digits and no trailing zeros; a scientific form where zeros would pile up.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = text.split_once('e') else { return value.to_string() };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if (-4..digits as i32).contains(&exponent) {
        trim(&format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize))
    } else {
        format!("{}e{exponent}", trim(mantissa))
    }
}

/// `value` in as few digits as tell it from others: of float32 where it is one (−1.2, not −1.2000000476837158).
pub(crate) fn shortest(value: f64) -> String {
    let narrow = value as f32;
    if f64::from(narrow).to_bits() == value.to_bits() { narrow.to_string() } else { value.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_are_kept_and_zeros_are_not() {
        for (value, digits, text) in [
            (15.0, 9, "15"),
            (0.1 + 0.2, 9, "0.3"),
            (-0.002_512_345, 3, "-0.00251"),
            (1.26e-6, 2, "1.3e-6"),
            (131_000.0, 2, "1.3e5"),
            (0.0, 2, "0"),
            (99.9, 2, "1e2"),
            (f64::INFINITY, 2, "inf"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }

    #[test]
    fn widened_float32_is_shown_as_it_was_written() {
        for (value, text) in [(f64::from(-1.2_f32), "-1.2"), (-1.2, "-1.2"), (8.0, "8"), (f64::from(0.07_f32), "0.07")]
        {
            assert_eq!(shortest(value), text);
        }
    }
}
