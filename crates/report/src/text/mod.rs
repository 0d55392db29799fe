//! Records as text for a terminal.

mod account;
mod lines;
mod table;

pub(crate) use account::{diverged, horizon};
pub use account::{text, verdict};
pub use lines::fitted;
pub use table::{aligned, beside};

/// Columns of text that is not for a terminal: files and tests are the same everywhere.
pub const WIDTH: usize = 110;
