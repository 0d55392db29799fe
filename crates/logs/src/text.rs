//! A text file as columns of cells, checked line by line.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::column::Column;
use crate::layout::{Layout, Line, lines, split, without_comments};
use crate::{LogError, Note};

/// The lines of a CSV file after its header; each has as many cells as the header.
#[derive(Debug)]
pub(crate) struct Text {
    text: String,
    layout: Layout,
    latin: bool,
    /// Cells of the header; of its last ones the number that have no name.
    width: usize,
    nameless: usize,
    /// Number (from 1) and place of each line after the header.
    lines: Vec<Line>,
}

/// Reads `bytes`, which messages call `path`.
pub(crate) fn read(path: &Path, bytes: Vec<u8>, delimiter: Option<u8>) -> Result<(Vec<Column>, Text), LogError> {
    match String::from_utf8(bytes) {
        Ok(text) => parse(path, text, delimiter, false),
        Err(e) if is_latin(e.as_bytes()) => {
            parse(path, e.as_bytes().iter().map(|byte| char::from(*byte)).collect(), delimiter, true)
        }
        Err(e) => {
            let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
            Err(LogError::NotText { path: path.to_owned(), line })
        }
    }
}

/// Reads `text`, which messages call `path`.
pub(crate) fn parse(
    path: &Path,
    text: String,
    delimiter: Option<u8>,
    latin: bool,
) -> Result<(Vec<Column>, Text), LogError> {
    let mut lines = without_comments(&text, lines(&text), delimiter);
    while lines.last().is_some_and(|(_, place)| text[place.clone()].trim().is_empty()) {
        lines.pop();
    }
    let Some((line, place)) = lines.first().cloned() else {
        return Err(LogError::Empty { path: path.to_owned() });
    };
    let layout = Layout::of(&text, &lines, delimiter);
    let lines = lines.split_off(1);
    let mut read = Text { layout, latin, width: 0, nameless: 0, lines, text };
    let header = read.text[place].trim_start_matches('\u{feff}');
    let mut columns = columns(path, line, header, &read.split(line, header).map_err(|e| e.of(path))?)?;
    read.width = columns.len();
    read.nameless = columns.iter().rev().take_while(|c| c.name.is_empty()).count();
    read.take_units(&mut columns).map_err(|e| e.of(path))?;
    if read.lines.is_empty() {
        return Err(LogError::NoRows { path: path.to_owned() });
    }
    for (line, place) in &read.lines {
        let (last, text) = (place.end == read.text.len(), &read.text[place.clone()]);
        read.check_width(path, *line, text, last)?;
    }
    Ok((columns, read))
}

/// What the header in `line` names, whose cells are `cells`.
fn columns(path: &Path, line: usize, header: &str, cells: &[Cow<'_, str>]) -> Result<Vec<Column>, LogError> {
    if let [only] = cells
        && only.contains([',', ';', '\t'])
    {
        return Err(LogError::OneColumn { path: path.to_owned(), line, header: only.to_string() });
    }
    if cells.iter().all(|c| c.is_empty() || c.parse::<f64>().is_ok()) {
        return Err(LogError::NoHeader { path: path.to_owned(), line, row: header.to_owned() });
    }
    let columns: Vec<Column> = cells.iter().map(|c| Column::new(c)).collect();
    let mut seen = HashMap::new();
    for (i, column) in columns.iter().enumerate().filter(|(_, c)| !c.name.is_empty()) {
        if let Some(other) = seen.insert(&column.name, i) {
            let (path, column) = (path.to_owned(), column.name.clone());
            return Err(LogError::DuplicateColumn { path, line, first: other + 1, second: i + 1, column });
        }
    }
    Ok(columns)
}

/// A line in which a quote is not closed.
struct OpenQuote {
    line: usize,
}

impl OpenQuote {
    fn of(self, path: &Path) -> LogError {
        LogError::OpenQuote { path: path.to_owned(), line: self.line }
    }
}

impl Text {
    /// Takes the line after the header for units, if it has no number where the next one has some.
    fn take_units(&mut self, columns: &mut [Column]) -> Result<(), OpenQuote> {
        let [(line, first), (next, second), ..] = &self.lines[..] else { return Ok(()) };
        let cells = self.split(*line, &self.text[first.clone()])?;
        let numbers = |cells: &[Cow<'_, str>]| cells.iter().any(|cell| cell.parse::<f64>().is_ok());
        let rows_follow = self.split(*next, &self.text[second.clone()]).is_ok_and(|cells| numbers(&cells));
        let told = cells.iter().any(|cell| !cell.is_empty());
        if cells.len() != columns.len() || numbers(&cells) || !told || !rows_follow {
            return Ok(());
        }
        let units: Vec<String> =
            cells.iter().map(|cell| cell.trim_matches(['[', ']', '(', ')', ' ']).to_owned()).collect();
        for (column, unit) in columns.iter_mut().zip(units).filter(|(column, _)| column.unit.is_empty()) {
            column.unit = unit;
        }
        self.lines.remove(0);
        Ok(())
    }

    /// What was decided about how the file is written.
    pub(crate) fn notes(&self) -> Vec<Note> {
        let delimiter = self.layout.delimiter;
        let written = (delimiter != ',' || self.layout.decimal_comma)
            .then_some(Note::Layout { delimiter, decimal_comma: self.layout.decimal_comma });
        let latin = self.latin.then_some(Note::Latin);
        // Whether the last number may be cut off.
        let abrupt = (!self.text.ends_with(['\n', '\r'])).then_some(Note::EndsAbruptly);
        written.into_iter().chain(latin).chain(abrupt).collect()
    }

    fn check_width(&self, path: &Path, line: usize, text: &str, last: bool) -> Result<(), LogError> {
        let cells = match self.split(line, text) {
            Err(_) if last => 0,
            cells => cells.map_err(|e| e.of(path))?.len(),
        };
        if cells == self.width {
            return Ok(());
        }
        let (path, expected): (PathBuf, usize) = (path.to_owned(), self.width);
        Err(match () {
            () if last && cells < expected => LogError::CutOff { path, line, text: text.to_owned() },
            () if text.trim().is_empty() => LogError::EmptyLine { path, line },
            () => LogError::Width { path, line, cells, expected },
        })
    }

    /// The cells of `line`, as many as the header has where those left out or too many at its end are empty.
    fn split<'a>(&self, line: usize, text: &'a str) -> Result<Vec<Cow<'a, str>>, OpenQuote> {
        let delimiter = self.layout.delimiter;
        let mut cells: Vec<Cow<'a, str>> = if text.contains('"') {
            if text.matches('"').count() % 2 == 1 {
                return Err(OpenQuote { line });
            }
            split(text, delimiter).into_iter().map(Cow::Owned).collect()
        } else if delimiter == ' ' {
            text.split_whitespace().map(Cow::Borrowed).collect()
        } else {
            text.split(delimiter).map(|c| Cow::Borrowed(c.trim())).collect()
        };
        if self.width == 0 {
            return Ok(cells);
        }
        if self.layout.decimal_comma {
            for cell in cells.iter_mut().filter(|cell| cell.contains(',')) {
                *cell = Cow::Owned(cell.replacen(',', ".", 1));
            }
        }
        while cells.len() > self.width && cells.last().is_some_and(|cell| cell.is_empty()) {
            cells.pop();
        }
        if cells.len() < self.width && cells.len() + self.nameless >= self.width {
            cells.resize(self.width, Cow::Borrowed(""));
        }
        Ok(cells)
    }

    /// The lines after the header, checked before: their numbers in the file, and their cells.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (usize, Vec<Cow<'_, str>>)> {
        self.lines.iter().filter_map(|&(line, ref place)| {
            let cells = self.split(line, &self.text[place.clone()]).ok()?;
            Some((line, cells))
        })
    }
}

/// Whether `bytes` are text of one byte a letter, as some programs write `°` and `µ`.
fn is_latin(bytes: &[u8]) -> bool {
    bytes.iter().all(|b| matches!(b, b'\t' | b'\n' | b'\r' | 0x20..=0x7e | 0xa0..=0xff))
}
