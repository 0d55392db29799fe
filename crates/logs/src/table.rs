//! A text file as columns of cells, checked line by line.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::layout::{Layout, Line, lines, split, without_comments};
use crate::{LogError, Note};

/// A CSV file with a header; every line has as many cells as the header.
#[derive(Debug)]
pub(crate) struct Table {
    path: PathBuf,
    text: String,
    layout: Layout,
    latin: bool,
    columns: Vec<Column>,
    /// Number (from 1) and place of each line after the header.
    lines: Vec<Line>,
}

/// A column as the header names it: `th`, or `th [rad]` with its unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: String,
}

impl Column {
    fn new(header: &str) -> Self {
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
    /// Reads all of `source`, which messages call `path`.
    pub(crate) fn read(path: &Path, mut source: impl std::io::Read, delimiter: Option<u8>) -> Result<Self, LogError> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).map_err(|source| LogError::Unreadable { path: path.to_owned(), source })?;
        match String::from_utf8(bytes) {
            Ok(text) => Self::parse(path, text, delimiter),
            Err(e) if is_latin(e.as_bytes()) => {
                let text = e.as_bytes().iter().map(|byte| char::from(*byte)).collect();
                Ok(Self { latin: true, ..Self::parse(path, text, delimiter)? })
            }
            Err(e) => {
                let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
                Err(LogError::NotText { path: path.to_owned(), line })
            }
        }
    }

    /// Reads `text`, which messages call `path`.
    pub(crate) fn parse(path: &Path, text: String, delimiter: Option<u8>) -> Result<Self, LogError> {
        let mut lines = without_comments(&text, lines(&text), delimiter);
        while lines.last().is_some_and(|(_, place)| text[place.clone()].trim().is_empty()) {
            lines.pop();
        }
        let Some(first) = lines.first().cloned() else {
            return Err(LogError::Empty { path: path.to_owned() });
        };
        let layout = Layout::of(&text, &lines, delimiter);
        let lines = lines.split_off(1);
        let mut table = Self { path: path.to_owned(), layout, latin: false, columns: Vec::new(), lines, text };
        table.columns = table.header(first)?;
        table.read_units()?;
        if table.lines.is_empty() {
            return Err(LogError::NoRows { path: path.to_owned() });
        }
        for &(line, ref place) in &table.lines {
            table.check_width(line, place.clone())?;
        }
        Ok(table)
    }

    /// Takes the line after the header for units, if it has no number where the next one has some.
    fn read_units(&mut self) -> Result<(), LogError> {
        let [(line, first), (next, second), ..] = &self.lines[..] else { return Ok(()) };
        let cells = self.split(*line, &self.text[first.clone()])?;
        let numbers = |cells: &[Cow<'_, str>]| cells.iter().any(|cell| cell.parse::<f64>().is_ok());
        let rows_follow = self.split(*next, &self.text[second.clone()]).is_ok_and(|cells| numbers(&cells));
        let told = cells.iter().any(|cell| !cell.is_empty());
        if cells.len() != self.columns.len() || numbers(&cells) || !told || !rows_follow {
            return Ok(());
        }
        let units: Vec<String> =
            cells.iter().map(|cell| cell.trim_matches(['[', ']', '(', ')', ' ']).to_owned()).collect();
        for (column, unit) in self.columns.iter_mut().zip(units).filter(|(column, _)| column.unit.is_empty()) {
            column.unit = unit;
        }
        self.lines.remove(0);
        Ok(())
    }

    /// Says that the column called `name` is in `unit`, whatever the header says.
    pub(crate) fn set_unit(&mut self, name: &str, unit: &str) -> Result<(), LogError> {
        let at = self.column(name)?;
        unit.clone_into(&mut self.columns[at].unit);
        Ok(())
    }

    /// What was decided about how the file is written.
    pub(crate) fn notes(&self) -> impl Iterator<Item = Note> {
        let delimiter = self.layout.delimiter;
        let written = (delimiter != ',' || self.layout.decimal_comma)
            .then_some(Note::Layout { delimiter, decimal_comma: self.layout.decimal_comma });
        let latin = self.latin.then_some(Note::Latin);
        // Whether the last number may be cut off.
        let abrupt = (!self.text.ends_with(['\n', '\r'])).then_some(Note::EndsAbruptly);
        written.into_iter().chain(latin).chain(abrupt)
    }

    fn header(&self, (line, place): (usize, Range<usize>)) -> Result<Vec<Column>, LogError> {
        let header = self.text[place].trim_start_matches('\u{feff}');
        let cells = self.split(line, header)?;
        if let [only] = &cells[..]
            && only.contains([',', ';', '\t'])
        {
            return Err(LogError::OneColumn { path: self.path.clone(), line, header: only.to_string() });
        }
        if cells.iter().all(|c| c.is_empty() || c.parse::<f64>().is_ok()) {
            return Err(LogError::NoHeader { path: self.path.clone(), line, row: header.to_owned() });
        }
        let columns: Vec<Column> = cells.iter().map(|c| Column::new(c)).collect();
        let mut seen = HashMap::new();
        for (i, column) in columns.iter().enumerate().filter(|(_, c)| !c.name.is_empty()) {
            if let Some(other) = seen.insert(&column.name, i) {
                let (path, column) = (self.path.clone(), column.name.clone());
                return Err(LogError::DuplicateColumn { path, line, first: other + 1, second: i + 1, column });
            }
        }
        Ok(columns)
    }

    fn check_width(&self, line: usize, place: Range<usize>) -> Result<(), LogError> {
        let last = place.end == self.text.len();
        let text = &self.text[place];
        let cells = match self.split(line, text) {
            Err(_) if last => 0,
            cells => cells?.len(),
        };
        if cells == self.columns.len() {
            return Ok(());
        }
        let (path, expected) = (self.path.clone(), self.columns.len());
        Err(match () {
            () if last && cells < expected => LogError::CutOff { path, line, text: text.to_owned() },
            () if text.trim().is_empty() => LogError::EmptyLine { path, line },
            () => LogError::Width { path, line, cells, expected },
        })
    }

    /// The cells of `line`, as many as the header has where those left out or too many at its end are empty.
    fn split<'a>(&self, line: usize, text: &'a str) -> Result<Vec<Cow<'a, str>>, LogError> {
        let delimiter = self.layout.delimiter;
        let mut cells: Vec<Cow<'a, str>> = if text.contains('"') {
            if text.matches('"').count() % 2 == 1 {
                return Err(LogError::OpenQuote { path: self.path.clone(), line });
            }
            split(text, delimiter).into_iter().map(Cow::Owned).collect()
        } else if delimiter == ' ' {
            text.split_whitespace().map(Cow::Borrowed).collect()
        } else {
            text.split(delimiter).map(|c| Cow::Borrowed(c.trim())).collect()
        };
        if self.layout.decimal_comma && !self.columns.is_empty() {
            for cell in cells.iter_mut().filter(|cell| cell.contains(',')) {
                *cell = Cow::Owned(cell.replacen(',', ".", 1));
            }
        }
        let width = self.columns.len();
        if width > 0 {
            while cells.len() > width && cells.last().is_some_and(|cell| cell.is_empty()) {
                cells.pop();
            }
            let nameless = self.columns.iter().rev().take_while(|c| c.name.is_empty()).count();
            if cells.len() < width && cells.len() + nameless >= width {
                cells.resize(width, Cow::Borrowed(""));
            }
        }
        Ok(cells)
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
            let known = self.columns.iter().map(|c| c.name.clone()).filter(|n| !n.is_empty()).collect();
            LogError::UnknownColumn { path: self.path.clone(), column: name.to_owned(), known }
        })
    }

    /// The lines after the header: their numbers in the file, and their cells.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Result<(usize, Vec<Cow<'_, str>>), LogError>> {
        self.lines.iter().map(|&(line, ref place)| Ok((line, self.split(line, &self.text[place.clone()])?)))
    }

    /// What the file is called.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The number in `cell`, which stands in `line` under column number `column`.
    pub(crate) fn number(&self, line: usize, column: usize, cell: &str) -> Result<f64, LogError> {
        let (path, column) = (|| self.path.clone(), || self.columns[column].name.clone());
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(LogError::NotFinite { path: path(), line, column: column(), cell: cell.to_owned() }),
            Err(_) => Err(LogError::NotANumber { path: path(), line, column: column(), cell: cell.to_owned() }),
        }
    }
}

/// Whether `bytes` are text of one byte a letter, as some programs write `°` and `µ`.
fn is_latin(bytes: &[u8]) -> bool {
    bytes.iter().all(|b| matches!(b, b'\t' | b'\n' | b'\r' | 0x20..=0x7e | 0xa0..=0xff))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Table, LogError> {
        Table::parse(Path::new("log.csv"), text.to_owned(), None)
    }

    #[test]
    fn cells_are_read_with_quotes_units_marks_and_either_line_break() {
        let table = parse("\u{feff}t [s],\"th, left [rad]\",w\r\n0, 1.5 ,\"2\"\r\n0.1,\"-3e-2\",4\r\n\r\n").unwrap();
        let names: Vec<_> = table.columns().iter().map(|c| (c.name.as_str(), c.unit.as_str())).collect();
        assert_eq!(names, [("t", "s"), ("th, left", "rad"), ("w", "")]);
        let rows: Vec<_> = table.rows().map(Result::unwrap).collect();
        assert_eq!(rows[0], (2, vec!["0".into(), "1.5".into(), "2".into()]));
        assert_eq!(rows[1].1[1], "-3e-2");
        assert_eq!(table.number(3, 1, "-3e-2").unwrap(), -0.03);
    }

    #[test]
    fn cells_are_separated_by_what_is_said() {
        let table = Table::parse(Path::new("log.csv"), "a;\"b;c\"\n1;2\n".into(), Some(b';')).unwrap();
        assert_eq!(table.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["a", "b;c"]);
        assert_eq!(table.rows().next().unwrap().unwrap().1, ["1", "2"]);
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
            let x: Vec<String> = table.rows().map(|row| row.unwrap().1[1].to_string()).collect();
            assert_eq!(x, ["1.5", "2.5"], "{text:?}");
        }
        let latin = Table::read(Path::new("log.csv"), &b"t,a [\xb0]\n0,1\n"[..], None).unwrap();
        assert_eq!(names(&latin), "t| a|\u{b0}");
        assert!(latin.notes().any(|n| n == Note::Latin));
        let binary = Table::read(Path::new("log.csv"), &b"t,a\n0,\xb0\0\n"[..], None).map(drop).unwrap_err();
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
            let rows: Vec<_> = table.rows().map(|row| row.unwrap().1).collect();
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
        let table = parse("a,b\n1,2\n").unwrap();
        for (cell, says) in
            [("nan", "`nan` is not a finite"), ("1e999", "finite"), ("", "an empty cell"), ("x", "`x` is not a number")]
        {
            let failure = table.number(2, 1, cell).unwrap_err().to_string();
            assert!(failure.contains("line 2, ") || failure.contains("line 2: column `b`"), "{failure}");
            assert!(failure.contains(says), "{failure}");
        }
        assert!(table.column("c").unwrap_err().to_string().contains("no column named `c`; known: `a`, `b`"));
    }
}
