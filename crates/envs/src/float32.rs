//! Which numbers Gymnasium keeps in float32.

/// `value` rounded to the nearest float32.
pub(crate) fn rounded(value: f64) -> f64 {
    f64::from(value as f32)
}

/// Whether `value` is a float32. Gymnasium computes in the type its numbers happen to have, and a type is no part
/// of a state or an action here; but a float64 that came from arithmetic is a float32 once in 2²⁹ times.
#[expect(clippy::float_cmp, reason = "the question is whether rounding changes the value at all")]
pub(crate) fn is_float32(value: f64) -> bool {
    rounded(value) == value
}

/// `value` rounded to float32 if `narrow`: the result of an operation on float32 numbers.
pub(crate) fn rounded_if(narrow: bool, value: f64) -> f64 {
    if narrow { rounded(value) } else { value }
}
