//! Reports as functions of records: of one identification ([`model_page`]), one run ([`run_page`]), or a comparison of methods.
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
mod names;
mod numbers;
mod page;
mod portrait;
mod record;
mod scores;
mod signals;
pub mod stats;
pub mod text;
mod thin;

pub use catalog::{Catalog, Published};
pub use comparison::Comparison;
pub use equations::true_equations;
#[cfg(feature = "png")]
pub use figure::PngError;
pub use figure::{Figure, METHOD_COLOURS};
pub use groups::{Difference, Group, Ratio, Returns, Steps};
pub use names::method_name;
pub use page::Page;
pub use record::{model_page, run_page};
pub use signals::{Signal, log_page};
