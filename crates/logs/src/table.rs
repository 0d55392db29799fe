//! A log as a table of named columns, wherever it is from.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::text::Text;
use crate::values::Values;
use crate::{LogError, Note, Place};

/// Named columns of as many cells each.
#[derive(Debug)]
pub(crate) struct Table {
    path: PathBuf,
    columns: Vec<Column>,
    cells: Cells,
    /// What the file has that is no column, and why.
    left_out: Vec<(String, String)>,
}

/// What stands in the rows. Cells of numbers are read as text too: as many digits as tell them apart are what a log in text would have,
/// so what is told by digits is told of every format alike.
#[derive(Debug)]
enum Cells {
    Text(Text),
    Values { columns: Vec<Values>, rows: usize },
}

/// A column as the header names it: `th`, or `th [rad]` with its unit.
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
            _ => Self { name: header.to_owned(), unit: String::new() },
        }
    }
}

impl Table {
    pub(crate) fn of_text(path: &Path, columns: Vec<Column>, text: Text) -> Self {
        Self { path: path.to_owned(), columns, cells: Cells::Text(text), left_out: Vec::new() }
    }

    /// A table of `columns` with `rows` values each, or less where the last ones are missing.
    pub(crate) fn of_values(
        path: &Path,
        columns: Vec<(Column, Values)>,
        rows: usize,
        left_out: Vec<(String, String)>,
    ) -> Self {
        let (columns, values) = columns.into_iter().unzip();
        Self { path: path.to_owned(), columns, cells: Cells::Values { columns: values, rows }, left_out }
    }

    /// Says that the column called `name` is in `unit`, whatever the header says.
    pub(crate) fn set_unit(&mut self, name: &str, unit: &str) -> Result<(), LogError> {
        let at = self.column(name)?;
        unit.clone_into(&mut self.columns[at].unit);
        Ok(())
    }

    /// What was decided about how the file is written.
    pub(crate) fn notes(&self) -> Vec<Note> {
        match &self.cells {
            Cells::Text(text) => text.notes(),
            Cells::Values { .. } if self.left_out.is_empty() => Vec::new(),
            Cells::Values { .. } => vec![Note::LeftOut { arrays: self.left_out.clone() }],
        }
    }

    /// The columns, left to right.
    pub(crate) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The number of the column called `name`, if there is one.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name == name)
    }

    /// The number of the column called `name`.
    pub(crate) fn column(&self, name: &str) -> Result<usize, LogError> {
        self.find(name).ok_or_else(|| {
            let (path, column) = (self.path.clone(), name.to_owned());
            if let Some((_, why)) = self.left_out.iter().find(|(left_out, _)| left_out == name) {
                return LogError::NotAColumn { path, column, why: why.clone() };
            }
            let known = self.columns.iter().map(|c| c.name.clone()).filter(|n| !n.is_empty()).collect();
            LogError::UnknownColumn { path, column, known }
        })
    }

    /// The rows: their numbers in the file, and their cells.
    pub(crate) fn rows(&self) -> Box<dyn Iterator<Item = (usize, Vec<Cow<'_, str>>)> + '_> {
        match &self.cells {
            Cells::Text(text) => Box::new(text.rows()),
            Cells::Values { columns, rows } => {
                Box::new((0..*rows).map(move |i| (i + 1, columns.iter().map(|c| c.cell(i)).collect())))
            }
        }
    }

    /// What the file is called.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Where row number `number` is, in this file.
    pub(crate) fn place(&self, number: usize) -> Place {
        Place { file: None, number, is_line: matches!(self.cells, Cells::Text(_)) }
    }

    /// The number in `cell`, which stands in row number `row` under column number `column`.
    pub(crate) fn number(&self, row: usize, column: usize, cell: &str) -> Result<f64, LogError> {
        let told = || (self.path.clone(), self.place(row), self.columns[column].name.clone(), cell.to_owned());
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => {
                let (path, row, column, cell) = told();
                Err(LogError::NotFinite { path, row, column, cell })
            }
            Err(_) => {
                let (path, row, column, cell) = told();
                Err(LogError::NotANumber { path, row, column, cell })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_none_are_told_with_their_place() {
        let check = |table: &Table, row: usize, place: &str| {
            for (cell, says) in [
                ("nan", "`nan` is not a finite"),
                ("1e999", "finite"),
                ("", "an empty cell"),
                ("x", "`x` is not a number"),
            ] {
                let failure = table.number(row, 1, cell).unwrap_err().to_string();
                assert!(failure.contains(says) && failure.contains(&format!("{place}: column `b`")), "{failure}");
            }
            let unknown = table.column("c").unwrap_err().to_string();
            assert!(unknown.contains("no column named `c`; known: `a`, `b`"), "{unknown}");
        };
        let text = crate::text::parse(Path::new("log.csv"), "a,b\n1,2\n".into(), None, false).unwrap();
        check(&text, 2, "log.csv, line 2");
        let columns = ["a", "b"].map(|name| (Column::new(name), Values::F64(vec![1.0]))).to_vec();
        check(&Table::of_values(Path::new("log.npz"), columns, 1, Vec::new()), 1, "log.npz, row 1");
    }
}
