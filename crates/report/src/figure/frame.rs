//! Sizes of all drawings.

/// Width of every drawing; its text is 13 units high, so it is readable from a width of 360 pixels on.
pub(crate) const WIDTH: f64 = 460.0;
pub(crate) const HEIGHT: f64 = 320.0;
/// Room on the left for numbers, above for a name, below for numbers and a name.
pub(crate) const LEFT: f64 = 58.0;
pub(crate) const TOP: f64 = 26.0;
pub(crate) const BOTTOM: f64 = HEIGHT - 44.0;
/// Right end of lines that have a name beside them.
pub(crate) const NAMES_AT: f64 = WIDTH - 128.0;
