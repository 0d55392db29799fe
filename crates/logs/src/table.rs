//! A log as a table of named columns, wherever it is from.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::column::Column;
use crate::text::{self, Text};
use crate::values::Values;
use crate::{LogError, Note, Row};

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

impl Table {
    /// The text in `bytes`, which messages call `path`.
    pub(crate) fn read(path: &Path, bytes: Vec<u8>, delimiter: Option<u8>) -> Result<Self, LogError> {
        Ok(Self::of_text(path, text::read(path, bytes, delimiter)?))
    }

    /// The text `text`, which messages call `path`.
    pub(crate) fn parse(path: &Path, text: String, delimiter: Option<u8>) -> Result<Self, LogError> {
        Ok(Self::of_text(path, text::parse(path, text, delimiter, false)?))
    }

    fn of_text(path: &Path, (columns, text): (Vec<Column>, Text)) -> Self {
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
    pub(crate) fn row(&self, number: usize) -> Row {
        Row { number, is_line: matches!(self.cells, Cells::Text(_)) }
    }

    /// The number in `cell`, which stands in row number `row` under column number `column`.
    pub(crate) fn number(&self, row: usize, column: usize, cell: &str) -> Result<f64, LogError> {
        let told = || (self.path.clone(), self.row(row), self.columns[column].name.clone(), cell.to_owned());
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
        let text = Table::parse(Path::new("log.csv"), "a,b\n1,2\n".into(), None).unwrap();
        check(&text, 2, "log.csv, line 2");
        let columns = ["a", "b"].map(|name| (Column::new(name), Values::F64(vec![1.0]))).to_vec();
        check(&Table::of_values(Path::new("log.npz"), columns, 1, Vec::new()), 1, "log.npz, row 1");
    }

    fn parse(text: &str) -> Result<Table, LogError> {
        Table::parse(Path::new("log.csv"), text.to_owned(), None)
    }

    #[test]
    fn cells_are_read_with_quotes_units_marks_and_either_line_break() {
        let table = parse("\u{feff}t [s],\"th, left [rad]\",w\r\n0, 1.5 ,\"2\"\r\n0.1,\"-3e-2\",4\r\n\r\n").unwrap();
        let names: Vec<_> = table.columns().iter().map(|c| (c.name.as_str(), c.unit.as_str())).collect();
        assert_eq!(names, [("t", "s"), ("th, left", "rad"), ("w", "")]);
        let rows: Vec<_> = table.rows().collect();
        assert_eq!(rows[0], (2, vec!["0".into(), "1.5".into(), "2".into()]));
        assert_eq!(rows[1].1[1], "-3e-2");
        assert_eq!(table.number(3, 1, "-3e-2").unwrap(), -0.03);
    }

    #[test]
    fn cells_are_separated_by_what_is_said() {
        let table = Table::parse(Path::new("log.csv"), "a;\"b;c\"\n1;2\n".into(), Some(b';')).unwrap();
        assert_eq!(table.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["a", "b;c"]);
        assert_eq!(table.rows().next().unwrap().1, ["1", "2"]);
        let failure = Table::parse(Path::new("log.csv"), "a,b\n1,2\n".into(), Some(b'\t')).map(drop).unwrap_err();
        assert!(failure.to_string().contains("is one column"), "{failure}");
    }

    #[test]
    fn files_are_read_as_programs_write_them() {
        let names = |table: &Table| {
            table.columns().iter().map(|c| format!("{}|{}", c.name, c.unit)).collect::<Vec<_>>().join(" ")
        };
        for (text, expected) in [
            ("t;x [m];\n0;1,5;\n1;2,5;\n", "t| x|m |"),
            ("t;x [m]\n0;1,5;\n1;2,5;\n", "t| x|m"),
            (
                "t x (m)\n0 1.5\n1 2.5\n"
                    .replace(" x (m)", "\tx (m)")
                    .replace("0 ", "0\t")
                    .replace("1 ", "1\t")
                    .as_str(),
                "t| x|m",
            ),
            ("%time,x(m/s),cos(th)\n0,1.5,0\n1,2.5,0\n", "time| x|m/s cos(th)|"),
            ("t,x\r0,1.5\r1,2.5\r", "t| x|"),
            ("t,x\n[s],[mm]\n0,1.5\n1,2.5\n", "t|s x|mm"),
            ("// made today\nt x\n 0  1.5\n 1  2.5\n", "t| x|"),
        ] {
            let table = parse(text).unwrap();
            assert_eq!(names(&table), expected, "{text:?}");
            let x: Vec<String> = table.rows().map(|row| row.1[1].to_string()).collect();
            assert_eq!(x, ["1.5", "2.5"], "{text:?}");
        }
        let latin = Table::read(Path::new("log.csv"), b"t,a [\xb0]\n0,1\n".to_vec(), None).unwrap();
        assert_eq!(names(&latin), "t| a|\u{b0}");
        assert!(latin.notes().contains(&Note::Latin));
        let binary = Table::read(Path::new("log.csv"), b"t,a\n0,\xb0\0\n".to_vec(), None).map(drop).unwrap_err();
        assert!(binary.to_string().contains("line 2: not UTF-8"), "{binary}");
    }

    #[test]
    fn a_header_of_a_hundred_thousand_columns_is_read_in_seconds() {
        let names: Vec<String> = (0..100_000).map(|i| format!("c{i}")).collect();
        let begun = std::time::Instant::now();
        let table = parse(&format!("{}\n{}\n", names.join(","), vec!["0"; names.len()].join(","))).unwrap();
        assert_eq!(table.columns().len(), names.len());
        assert!(begun.elapsed() < std::time::Duration::from_secs(5), "{:?}", begun.elapsed());
    }

    #[test]
    fn comments_are_left_out_and_names_after_a_mark_are_names() {
        for text in
            ["# made today\na,b\n1,2\n# half\n3,4\n", "\u{feff}# made today\n# a,b\n1,2\n3,4\n", "#a,b\n1,2\n3,4\n"]
        {
            let table = parse(text).unwrap();
            let names: Vec<_> = table.columns().iter().map(|c| c.name.as_str()).collect();
            let rows: Vec<_> = table.rows().map(|row| row.1).collect();
            assert!(names == ["a", "b"] && rows == [["1", "2"], ["3", "4"]], "{text:?}: {names:?} {rows:?}");
        }
        let failure = parse("# made, today\n# a,b\n1,2,3\n").unwrap_err().to_string();
        assert!(failure.contains("line 3: `1,2,3` is a row of numbers"), "{failure}");
        assert!(parse("# nothing\n").unwrap_err().to_string().contains("is empty"));
    }

    #[test]
    fn whatever_is_wrong_is_named_with_its_line() {
        for (text, says) in [
            ("", "is empty"),
            ("\n\n", "is empty"),
            ("a,b\n", "no rows"),
            ("a,b\n1,2\n3\n4,5\n", "line 3: 1 cell where the header names 2 columns"),
            ("a,b\n1,2\n3,4,5\n", "line 3: 3 cells where"),
            ("a,b\n1,2\n3", "line 3: cut off (`3`)"),
            ("a,b\n1,2\n3,\"4", "line 3: cut off"),
            ("a,b\n1,\"2\n3,4\n", "line 2: a quote"),
            ("a,b\n1,2\n\n3,4\n", "line 3: empty"),
            ("a,b,a\n1,2,3\n", "columns 1 and 3 are both named `a`"),
            ("0.1,0.2\n0.2,0.3\n", "row of numbers"),
        ] {
            let failure = parse(text).map(drop).unwrap_err().to_string();
            assert!(failure.contains(says) && failure.contains("log.csv"), "{text:?}: {failure}");
        }
    }
}
