//! Where in a log something is.

use std::fmt;
use std::path::PathBuf;

/// A row of a log, as its user finds it again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file, where there are several.
    pub file: Option<PathBuf>,
    /// Its number, from 1: of the line in a text file, the header included, else of the row.
    pub number: usize,
    /// Whether the file is text.
    pub is_line: bool,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", if self.is_line { "line" } else { "row" }, self.number)?;
        self.file.as_ref().map_or(Ok(()), |file| write!(f, " of {}", file.display()))
    }
}
