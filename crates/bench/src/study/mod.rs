//! What the studies share: cases side by side, results as files, numbers, tables and figures of pages.

mod cases;
mod chart;
mod number;
mod page;
mod process;
mod record;
mod train;

pub use cases::{each, kept};
pub use chart::{Chart, Scale};
pub use number::{Spread, by, count, many, median, percent, plain, rounded, share, short};
pub use page::Page;
pub use process::{ended_seconds, pinned};
pub use record::{Document, Made, Result, built, command, load, root, store, study};
pub use train::{Sindyna, Trained};
