//! Numbers as people read them.

/// `value` with at most six significant digits and no trailing zeros; a scientific form where zeros would pile up.
pub(crate) fn readable(value: f64) -> String {
    let text = format!("{value:.5e}");
    let Some((mantissa, exponent)) = text.split_once('e') else { return value.to_string() };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |digits: &str| match digits.contains('.') {
        true => digits.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => digits.to_owned(),
    };
    let text = if (-5..6).contains(&exponent) {
        trim(&format!("{value:.*}", (5 - exponent).max(0) as usize))
    } else {
        format!("{}e{exponent}", trim(mantissa))
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::readable;

    #[test]
    fn six_digits_and_no_padding() {
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
            assert_eq!(readable(value), text);
        }
    }
}
