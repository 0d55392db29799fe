//! A CSV file as columns of text, checked line by line.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::LogError;

/// A CSV file with a header; every line has as many cells as the header.
#[derive(Debug)]
pub(crate) struct Table {
    path: PathBuf,
    text: String,
    delimiter: char,
    columns: Vec<Column>,
    /// Number (from 1) and place of each line after the header.
    lines: Vec<(usize, Range<usize>)>,
}

/// A column as the header names it: `th`, or `th [rad]` with its unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: String,
}

impl Column {
    fn new(header: &str) -> Self {
        let unit = header.strip_suffix(']').and_then(|h| h.rsplit_once('['));
        match unit {
            Some((name, unit)) if !name.trim().is_empty() => {
                Self { name: name.trim().to_owned(), unit: unit.trim().to_owned() }
            }
            _ => Self { name: header.to_owned(), unit: String::new() },
        }
    }
}

impl Table {
    /// Reads all of `source`, which messages call `path`.
    pub(crate) fn read(path: &Path, mut source: impl std::io::Read, delimiter: u8) -> Result<Self, LogError> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).map_err(|source| LogError::Unreadable { path: path.to_owned(), source })?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
            LogError::NotText { path: path.to_owned(), line }
        })?;
        Self::parse(path, text, delimiter)
    }

    /// Reads `text`, which messages call `path`.
    pub(crate) fn parse(path: &Path, text: String, delimiter: u8) -> Result<Self, LogError> {
        let delimiter = char::from(delimiter);
        if text.contains('\r') && !text.contains('\n') {
            return Err(LogError::CarriageReturns { path: path.to_owned() });
        }
        let mut lines = without_comments(&text, lines(&text), delimiter);
        while lines.last().is_some_and(|(_, place)| text[place.clone()].trim().is_empty()) {
            lines.pop();
        }
        let Some(first) = lines.first().cloned() else {
            return Err(LogError::Empty { path: path.to_owned() });
        };
        let mut table = Self { path: path.to_owned(), delimiter, columns: Vec::new(), lines: lines.split_off(1), text };
        table.columns = table.header(first)?;
        if table.lines.is_empty() {
            return Err(LogError::NoRows { path: path.to_owned() });
        }
        for &(line, ref place) in &table.lines {
            table.check_width(line, place.clone())?;
        }
        Ok(table)
    }

    fn header(&self, (line, place): (usize, Range<usize>)) -> Result<Vec<Column>, LogError> {
        let header = self.text[place].trim_start_matches('\u{feff}');
        let cells = self.split(line, header)?;
        if let [only] = &cells[..]
            && (only.contains([',', ';', '\t']) || only.split_whitespace().all(|part| part.parse::<f64>().is_ok()))
        {
            return Err(LogError::OneColumn { path: self.path.clone(), line, header: only.to_string() });
        }
        if cells.iter().all(|c| c.parse::<f64>().is_ok()) {
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

    /// The cells of `line`; `"…"` may hold delimiters, and `""` is a quote there.
    fn split<'a>(&self, line: usize, text: &'a str) -> Result<Vec<Cow<'a, str>>, LogError> {
        if !text.contains('"') {
            return Ok(text.split(self.delimiter).map(|c| Cow::Borrowed(c.trim())).collect());
        }
        let (mut cells, mut cell, mut quoted) = (Vec::new(), String::new(), false);
        let mut chars = text.chars().peekable();
        while let Some(c) = chars.next() {
            match c {
                '"' if quoted && chars.peek() == Some(&'"') => cell.extend(chars.next()),
                '"' => quoted = !quoted,
                c if c == self.delimiter && !quoted => {
                    cells.push(Cow::Owned(std::mem::take(&mut cell).trim().to_owned()))
                }
                c => cell.push(c),
            }
        }
        if quoted {
            return Err(LogError::OpenQuote { path: self.path.clone(), line });
        }
        cells.push(Cow::Owned(cell.trim().to_owned()));
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
            LogError::UnknownColumn { column: name.to_owned(), known }
        })
    }

    /// The lines after the header: their numbers in the file, and their cells.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Result<(usize, Vec<Cow<'_, str>>), LogError>> {
        self.lines.iter().map(|&(line, ref place)| Ok((line, self.split(line, &self.text[place.clone()])?)))
    }

    /// Whether the last line has no line break: what was being written may be cut off in its last number.
    pub(crate) fn ends_abruptly(&self) -> bool {
        !self.text.ends_with('\n')
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

/// Number (from 1) and place of every line, line breaks left out.
fn lines(text: &str) -> Vec<(usize, Range<usize>)> {
    let mut begin = 0;
    let place = |line: &str| {
        let place = begin..begin + line.trim_end_matches(['\n', '\r']).len();
        begin += line.len();
        place
    };
    text.split_inclusive('\n').map(place).enumerate().map(|(i, place)| (i + 1, place)).collect()
}

/// Takes away the lines that begin with `#`, but for one that names the columns, as NumPy writes it: the last before the numbers,
/// if it has as many cells.
fn without_comments(text: &str, mut lines: Vec<(usize, Range<usize>)>, delimiter: char) -> Vec<(usize, Range<usize>)> {
    let bare = |place: &Range<usize>| text[place.clone()].trim_start_matches(['\u{feff}', '#', ' ']);
    let comment = |place: &Range<usize>| text[place.clone()].trim_start_matches('\u{feff}').starts_with('#');
    let leading = lines.iter().take_while(|(_, place)| comment(place)).count();
    let end = lines.len().min(leading + 1);
    if let [.., (_, names), (_, first)] = &mut lines[..end] {
        let cells: Vec<&str> = text[first.clone()].split(delimiter).collect();
        let numbers = cells.iter().all(|cell| cell.trim().parse::<f64>().is_ok());
        if leading > 0 && numbers && bare(names).split(delimiter).count() == cells.len() {
            names.start = names.end - bare(names).len();
        }
    }
    lines.retain(|(_, place)| !comment(place));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Table, LogError> {
        Table::parse(Path::new("log.csv"), text.to_owned(), b',')
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
        let table = Table::parse(Path::new("log.csv"), "a;\"b;c\"\n1;2\n".into(), b';').unwrap();
        assert_eq!(table.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["a", "b;c"]);
        assert_eq!(table.rows().next().unwrap().unwrap().1, ["1", "2"]);
        let failure = Table::parse(Path::new("log.csv"), "a,b\n1,2\n".into(), b'\t').map(drop).unwrap_err();
        assert!(failure.to_string().contains("is one column"), "{failure}");
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
            ("a,b\r1,2\r3,4\r", "has one line: carriage returns break none"),
            ("a,b\n1,2\n3\n4,5\n", "line 3: 1 cell where the header names 2 columns"),
            ("a,b\n1,2\n3,4,5\n", "line 3: 3 cells where"),
            ("a,b\n1,2\n3", "line 3: cut off (`3`)"),
            ("a,b\n1,2\n3,\"4", "line 3: cut off"),
            ("a,b\n1,\"2\n3,4\n", "line 2: a quote"),
            ("a,b\n1,2\n\n3,4\n", "line 3: empty"),
            ("a,b,a\n1,2,3\n", "columns 1 and 3 are both named `a`"),
            ("a;b\n1;2\n", "`a;b` is one column"),
            ("# a b\n1 2\n3 4\n", "is one column"),
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
