//! How much of a record its page shows.

/// Rows of a table.
pub(super) const MOST_ROWS: usize = 200;

/// States that have figures of their own.
pub(super) const MOST_STATES: usize = 8;
