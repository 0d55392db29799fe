//! A drawing.

use super::frame::{HEIGHT, WIDTH};
use super::style;
use crate::escape::escaped;

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
    pub(crate) elements: String,
}

impl Figure {
    /// The drawing as a file of its own: dark on white, whatever the reader prefers.
    #[must_use]
    pub fn svg(&self) -> String {
        style::standalone(&self.alternative, &self.elements)
    }

    /// The drawing as a PNG file. Its text is set in DejaVu Sans, which comes with the program, so that every machine
    /// makes the same bytes.
    ///
    /// # Errors
    /// [`PngError`](super::PngError) where there is no memory for the pixels.
    #[cfg(feature = "png")]
    pub fn png(&self) -> Result<Vec<u8>, super::PngError> {
        super::png::png(&self.svg())
    }

    /// The drawing as an element of a page.
    pub(crate) fn inline(&self) -> String {
        let alternative = escaped(&self.alternative);
        format!(
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{alternative}\">\n{}</svg>\n",
            self.elements
        )
    }
}
