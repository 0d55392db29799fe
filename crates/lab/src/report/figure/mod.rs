//! Drawings as SVG whose colours are classes: a page has its own colours, light or dark, for all of them.

mod axes;
mod curves;
mod names;
mod png;
mod portraits;
mod profile;
mod style;

pub(super) use curves::curves;
pub(super) use png::png;
pub(super) use portraits::portraits;
pub(super) use profile::profiles;
pub(super) use style::{page_style, standalone};

use crate::compare::Method;

/// Width of every drawing; its text is 13 units high, so it is readable from a width of 360 pixels on.
const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 320.0;
/// Room on the left for numbers, above for a name, below for numbers and a name.
const LEFT: f64 = 58.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = HEIGHT - 44.0;
/// Right end of lines that have a name beside them.
const NAMES_AT: f64 = WIDTH - 128.0;

/// A drawing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    /// File name without its ending.
    pub(super) name: String,
    /// What somebody who cannot see it is told.
    pub(super) alternative: String,
    pub(super) caption: String,
    /// The elements, on WIDTH × HEIGHT units.
    pub(super) elements: String,
}

impl Figure {
    /// The drawing as an element of a page.
    pub(super) fn inline(&self) -> String {
        let alternative = super::html::escaped(&self.alternative);
        format!(
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{alternative}\">\n{}</svg>\n",
            self.elements
        )
    }
}

/// The class whose colour is that of the method called `name`, in every drawing.
fn colour(name: &str) -> String {
    let place = Method::ALL.iter().position(|method| method.name() == name);
    format!("c{}", place.unwrap_or(Method::ALL.len() - 1))
}
