//! How a text file is laid out: line breaks, comments, what separates cells, which mark decimals have.

use std::ops::Range;

/// What may separate cells, in the order in which it is tried; a space stands for any blanks.
const DELIMITERS: [char; 5] = ['\t', ';', ',', '|', ' '];

/// Lines that are looked at.
const SAMPLE: usize = 100;

/// Number (from 1) and place of a line.
pub(crate) type Line = (usize, Range<usize>);

/// How the cells of a file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) delimiter: char,
    /// Whether decimals stand behind a comma.
    pub(crate) decimal_comma: bool,
}

impl Layout {
    /// The layout of `lines`, the first of which is the header; `given` separates cells if it is known.
    pub(crate) fn of(text: &str, lines: &[Line], given: Option<u8>) -> Self {
        let sample: Vec<&str> = lines.iter().take(SAMPLE).map(|(_, place)| &text[place.clone()]).collect();
        let delimiter = given.map_or_else(|| delimiter(&sample), char::from);
        let comma = |cell: &str| cell.contains(',') && !cell.contains('.') && number(&cell.replacen(',', ".", 1));
        let point = |cell: &str| cell.contains('.') && number(cell);
        let cells = || sample.iter().skip(1).flat_map(|line| split(line, delimiter));
        let decimal_comma = delimiter != ',' && cells().any(|c| comma(&c)) && !cells().any(|c| point(&c));
        Self { delimiter, decimal_comma }
    }
}

fn number(cell: &str) -> bool {
    cell.trim().parse::<f64>().is_ok()
}

/// What separates the cells of `lines`: what gives all of them as many cells as the header, two or more.
fn delimiter(lines: &[&str]) -> char {
    let Some((header, rows)) = lines.split_first() else { return ',' };
    // The last line may be cut off.
    let rows = if rows.len() > 1 { &rows[..rows.len() - 1] } else { rows };
    let width = |line: &str, d: char| split(line, d).len();
    let filled = |line: &str, d: char| split(line, d).iter().rposition(|c| !c.is_empty()).map_or(0, |last| last + 1);
    let fits = |d: &char| {
        let header_width = width(header, *d);
        header_width > 1
            && rows.iter().all(|row| width(row, *d) == header_width || filled(row, *d) == filled(header, *d))
    };
    let several = |d: &char| width(header, *d) > 1;
    let found = DELIMITERS.iter().find(|d| fits(d)).or_else(|| [',', ';', '\t', '|'].iter().find(|d| several(d)));
    found.copied().unwrap_or(',')
}

/// The cells of `line`; `"…"` may hold delimiters, and `""` is a quote there. A quote that is not closed ends with the line.
pub(crate) fn split(line: &str, delimiter: char) -> Vec<String> {
    let (mut cells, mut cell, mut quoted) = (Vec::new(), String::new(), false);
    let blanks = delimiter == ' ';
    let mut chars = if blanks { line.trim() } else { line }.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => cell.extend(chars.next()),
            '"' => quoted = !quoted,
            c if !quoted && (c == delimiter || (blanks && c == '\t')) => {
                while blanks && chars.peek().is_some_and(|c| [' ', '\t'].contains(c)) {
                    chars.next();
                }
                cells.push(std::mem::take(&mut cell).trim().to_owned());
            }
            c => cell.push(c),
        }
    }
    cells.push(cell.trim().to_owned());
    cells
}

/// Number (from 1) and place of every line, line breaks left out; lines may end in carriage returns alone.
pub(crate) fn lines(text: &str) -> Vec<Line> {
    let breaks = if text.contains('\n') { '\n' } else { '\r' };
    let mut begin = 0;
    let place = |line: &str| {
        let place = begin..begin + line.trim_end_matches(['\n', '\r']).len();
        begin += line.len();
        place
    };
    text.split_inclusive(breaks).map(place).enumerate().map(|(i, place)| (i + 1, place)).collect()
}

/// Takes away the lines that begin with `#`, `%` or `//`, but for one that names the columns: the last before the numbers, if it has
/// as many cells.
pub(crate) fn without_comments(text: &str, mut lines: Vec<Line>, given: Option<u8>) -> Vec<Line> {
    let bare = |place: &Range<usize>| text[place.clone()].trim_start_matches(['\u{feff}', '#', '%', '/', ' ']);
    let comment = |place: &Range<usize>| {
        let line = text[place.clone()].trim_start_matches('\u{feff}').trim_start();
        ["#", "%", "//"].iter().any(|mark| line.starts_with(mark))
    };
    let leading = lines.iter().take_while(|(_, place)| comment(place)).count();
    let end = lines.len().min(leading + 1);
    if let [.., (_, names), (_, first)] = &mut lines[..end] {
        let row = &text[first.clone()];
        let same = |d: char| {
            let cells = split(row, d);
            let numbers = cells.iter().all(|cell| cell.is_empty() || number(&cell.replacen(',', ".", 1)));
            numbers && split(bare(names), d).len() == cells.len()
        };
        let known = given
            .map_or_else(|| DELIMITERS.iter().any(|d| split(row, *d).len() > 1 && same(*d)), |d| same(char::from(d)));
        if leading > 0 && known {
            names.start = names.end - bare(names).len();
        }
    }
    lines.retain(|(_, place)| !comment(place));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delimiters_and_decimal_commas_are_found() {
        for (text, delimiter, decimal_comma) in [
            ("t,x\n0,1\n1,2\n", ',', false),
            ("t;x\n0;1,5\n1;2,5\n", ';', true),
            ("t;x\n0;1.5\n1;2,5\n", ';', false),
            ("t\tx y\n0\t1\n", '\t', false),
            ("t  x\n0   1\n 1  2\n", ' ', false),
            ("t, x\n0, 1\n1, 2\n", ',', false),
            ("t|x\n0|1\n", '|', false),
            ("t;\"a,b\";c\n0;1;2\n", ';', false),
            ("t,x,\n0,1\n1,2\n", ',', false),
            ("x\n1\n2\n", ',', false),
            ("t x\n0 1,5\n1 2,5\n2 3", ' ', true),
        ] {
            assert_eq!(Layout::of(text, &lines(text), None), Layout { delimiter, decimal_comma }, "{text:?}");
        }
        assert_eq!(split(" 1  \"a b\"\t2 ", ' '), ["1", "a b", "2"]);
        assert_eq!(lines("a\rb\r").len(), 2);
    }
}
