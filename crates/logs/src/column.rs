//! What a column is called.

use crate::units;

/// A column as the header names it: `th`, or `th [rad]` with its unit, or `th_deg`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: String,
}

impl Column {
    pub(crate) fn new(header: &str) -> Self {
        let in_brackets = header.strip_suffix(']').and_then(|h| h.rsplit_once('['));
        // `speed (m/s)` has a unit, `cos(th)` has none.
        let in_parentheses = header.strip_suffix(')').and_then(|h| h.rsplit_once('('));
        let parted = in_parentheses.filter(|(name, unit)| name.ends_with(char::is_whitespace) || unit.contains('/'));
        match in_brackets.or(parted) {
            Some((name, unit)) if !name.trim().is_empty() => {
                Self { name: name.trim().to_owned(), unit: unit.trim().to_owned() }
            }
            _ => Self { name: header.to_owned(), unit: units::named(header).into() },
        }
    }
}
