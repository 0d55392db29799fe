//! Drawings as SVG whose colours are classes: a page has its own colours, light or dark, for all of them.

mod axes;
mod costs;
mod curves;
mod drawing;
mod frame;
mod names;
pub(crate) mod plots;
#[cfg(feature = "png")]
mod png;
mod portraits;
mod profile;
pub(crate) mod series;
mod style;

pub(crate) use costs::{CostRow, costs};
pub(crate) use curves::curves;
pub use drawing::Figure;
#[cfg(feature = "png")]
pub use png::PngError;
pub(crate) use portraits::portraits;
pub(crate) use profile::profiles;
pub use style::METHOD_COLOURS;
pub(crate) use style::{colour, page_style};
