//! What is settled of a subset before the search.

use std::collections::BTreeSet;

/// What is settled before the search.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Constraints {
    /// Columns every subset has. They do not count as terms.
    pub fixed: Vec<usize>,
    /// Columns no subset has.
    pub forbidden: Vec<usize>,
    /// Columns that come together or not at all. A group counts as one term.
    pub groups: Vec<Vec<usize>>,
}

/// Why constraints were refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ConstraintError {
    /// A column that is not there.
    #[error("column {column} is constrained, there are {n_features}")]
    NoColumn {
        /// The column named.
        column: usize,
        /// Number of columns to choose from.
        n_features: usize,
    },
    /// A column named twice.
    #[error("column {column} is named by two constraints")]
    Twice {
        /// The column.
        column: usize,
    },
    /// A group without columns.
    #[error("group {group} is empty")]
    EmptyGroup {
        /// Its number.
        group: usize,
    },
}

impl Constraints {
    pub(super) fn check(&self, n_features: usize) -> Result<(), ConstraintError> {
        if let Some(group) = self.groups.iter().position(Vec::is_empty) {
            return Err(ConstraintError::EmptyGroup { group });
        }
        let mut seen = BTreeSet::new();
        for &column in self.fixed.iter().chain(&self.forbidden).chain(self.groups.iter().flatten()) {
            if column >= n_features {
                return Err(ConstraintError::NoColumn { column, n_features });
            }
            if !seen.insert(column) {
                return Err(ConstraintError::Twice { column });
            }
        }
        Ok(())
    }
}
