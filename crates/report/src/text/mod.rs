//! Records as text for a terminal.

mod account;
mod table;

pub use account::{text, verdict};
pub use table::{aligned, beside};
