//! Which columns of a log are likely to be states, inputs and times.

/// Which columns are likely to be what, by their names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Suggestion {
    /// Columns that look like states.
    pub states: Vec<String>,
    /// Columns that look like inputs, such as `u` or `force`.
    pub inputs: Vec<String>,
    /// Whether there is a column of times.
    pub has_time: bool,
    /// A column that may hold the times, by its unit, if none does by its name.
    pub time_column: Option<String>,
}
