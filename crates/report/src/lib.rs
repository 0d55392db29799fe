//! What a comparison of methods comes to: statistics, figures and pages, all of them functions of its records.
//!
//! A [`Digest`](sindyna_record::comparison::Digest) and a [`Catalog`] (facts about tasks and methods that no record holds)
//! make a [`Comparison`], whose [`groups`](Comparison::groups) are the numbers and whose [`report`](Comparison::report) is a
//! [`Page`]: text, tables and figures that become [HTML](Page::html) or [Markdown](Page::markdown). The same records
//! give the same bytes. Nothing here reads or writes a file.
//!
//! ```
//! use sindyna_report::stats::{interval, mean};
//!
//! let returns = [-150.0, -160.0, -155.0, -148.0];
//! let found = interval(&[&returns], |sample| mean(&sample[0])).expect("four values are enough");
//! assert!(found.low < -153.25 && -153.25 < found.high);
//! ```

mod catalog;
mod comparison;
mod content;
mod curve;
mod document;
mod equations;
mod escape;
mod figure;
mod groups;
mod html;
mod markdown;
mod numbers;
mod page;
mod portrait;
mod scores;
pub mod stats;

pub use catalog::{Catalog, Published};
pub use comparison::Comparison;
#[cfg(feature = "png")]
pub use figure::PngError;
pub use figure::{Figure, METHOD_COLOURS};
pub use groups::{Difference, Group, Ratio, Returns, Steps};
pub use page::Page;
