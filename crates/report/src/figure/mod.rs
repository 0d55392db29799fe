//! Drawings as SVG whose colours are classes: a page has its own colours, light or dark, for all of them.

mod axes;
mod curves;
mod names;
#[cfg(feature = "png")]
mod png;
mod portraits;
mod profile;
mod style;

pub(super) use curves::curves;
#[cfg(feature = "png")]
pub use png::PngError;
pub(super) use portraits::portraits;
pub(super) use profile::profiles;
pub use style::METHOD_COLOURS;
pub(super) use style::page_style;

use crate::Catalog;

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
pub struct Figure {
    /// File name without its ending.
    pub name: String,
    /// What somebody who cannot see it is told.
    pub alternative: String,
    /// What is written below it.
    pub caption: String,
    /// The elements, on WIDTH × HEIGHT units.
    pub(super) elements: String,
}

impl Figure {
    /// The drawing as a file of its own: dark on white, whatever the reader prefers.
    #[must_use]
    pub fn svg(&self) -> String {
        style::standalone(self)
    }

    /// The drawing as a PNG file. Its text is set in DejaVu Sans, which comes with the program, so that every machine
    /// makes the same bytes.
    ///
    /// # Errors
    /// [`PngError`] where there is no memory for the pixels.
    #[cfg(feature = "png")]
    pub fn png(&self) -> Result<Vec<u8>, PngError> {
        png::png(&self.svg())
    }

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
fn colour(catalog: &dyn Catalog, name: &str) -> String {
    let (place, last) = (catalog.methods().iter().position(|method| *method == name), METHOD_COLOURS - 1);
    format!("c{}", place.unwrap_or(last).min(last))
}
