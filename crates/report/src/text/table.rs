//! Text side by side, or one below the other where it is too wide.

use textwrap::core::display_width;

/// Between two texts that stand side by side.
const GAP: &str = "    ";

/// Between two columns of a table.
const BETWEEN: &str = "   ";

/// Two titled lists of lines, side by side if they fit into `width` columns; an empty one on the right is left out.
#[must_use]
pub fn beside(left: (&str, &[String]), right: (&str, &[String]), width: usize) -> String {
    let wide = |(title, lines): (&str, &[String])| {
        lines.iter().map(|line| display_width(line)).chain([display_width(title)]).max().unwrap_or(0)
    };
    if right.1.is_empty() {
        return left.1.iter().fold(left.0.to_owned() + "\n", |text, line| text + line + "\n");
    }
    if wide(left) + wide(right) + GAP.len() > width { below(left, right) } else { columns(left, right, wide(left)) }
}

fn columns(left: (&str, &[String]), right: (&str, &[String]), width: usize) -> String {
    let line = |l: &str, r: &str| format!("{}{GAP}{r}", padded(l, width)).trim_end().to_owned() + "\n";
    let mut text = line(left.0, right.0);
    for i in 0..left.1.len().max(right.1.len()) {
        text += &line(left.1.get(i).map_or("", String::as_str), right.1.get(i).map_or("", String::as_str));
    }
    text
}

fn below(first: (&str, &[String]), second: (&str, &[String])) -> String {
    let block = |(title, lines): (&str, &[String])| {
        let lines: String = lines.iter().map(|l| format!("  {l}\n")).collect();
        format!("{title}\n{lines}")
    };
    block(first) + &block(second)
}

/// Rows of cells, the columns lined up. Where they are wider than `width`, the first column becomes headings of the others.
///
/// ```
/// let rows = [["task", "method", "return"], ["cart-pole", "sindy", "500"], ["cart-pole", "sac", "494"]];
/// let rows = rows.map(|row| row.map(String::from));
/// let narrow = sindyna_report::text::aligned(&rows, 20);
/// assert_eq!(narrow, "task\n  method   return\ncart-pole\n  sindy    500\n  sac      494\n");
/// ```
#[must_use]
pub fn aligned<const N: usize>(rows: &[[String; N]], width: usize) -> String {
    let rows: Vec<&[String]> = rows.iter().map(<[String; N]>::as_slice).collect();
    lined_up(&rows, width).concat()
}

/// The same, a piece of text for each row.
fn lined_up(rows: &[&[String]], width: usize) -> Vec<String> {
    let columns = rows.first().map_or(0, |row| row.len());
    let widths: Vec<usize> =
        (0..columns).map(|i| rows.iter().map(|row| display_width(&row[i])).max().unwrap_or(0)).collect();
    if widths.iter().sum::<usize>() + BETWEEN.len() * columns.saturating_sub(1) > width && columns > 1 {
        return under_headings(rows, width);
    }
    let line = |row: &&[String]| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| padded(cell, *width));
        cells.collect::<Vec<_>>().join(BETWEEN).trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

fn under_headings(rows: &[&[String]], width: usize) -> Vec<String> {
    let others: Vec<&[String]> = rows.iter().map(|row| &row[1..]).collect();
    let others = lined_up(&others, width.saturating_sub(2));
    let before = std::iter::once(None).chain(rows.iter().map(|row| Some(&row[0])));
    let piece = |((row, before), others): ((&&[String], Option<&String>), String)| {
        let heading = if before == Some(&row[0]) { String::new() } else { format!("{}\n", row[0]) };
        heading + &others.lines().map(|line| format!("  {line}\n")).collect::<String>()
    };
    rows.iter().zip(before).zip(others).map(piece).collect()
}

/// `text` with blanks up to `width` columns: marks over letters take none.
fn padded(text: &str, width: usize) -> String {
    text.to_owned() + &" ".repeat(width.saturating_sub(display_width(text)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_padded_by_what_is_seen() {
        let found = ["θ̈ = 15·sin θ".to_owned(), "x".to_owned()];
        let text = beside(("found", &found), ("true", &["same".to_owned()]), 110);
        assert_eq!(text, "found           true\nθ̈ = 15·sin θ    same\nx\n");
    }

    #[test]
    fn cells_line_up() {
        let rows = [["a", "bcd"], ["long", "e"]].map(|row| row.map(str::to_owned));
        assert_eq!(aligned(&rows, 10), "a      bcd\nlong   e\n");
    }

    #[test]
    fn what_is_too_wide_stands_below() {
        let long = ["x".repeat(100)];
        let text = beside(("found", &long), ("true", &["a long enough equation".to_owned()]), 110);
        assert_eq!(text, format!("found\n  {}\ntrue\n  a long enough equation\n", long[0]));
    }

    #[test]
    fn no_line_of_a_table_is_wider_than_the_terminal() {
        let rows = [
            ["task", "method", "solved", "real steps"],
            ["cart-pole-swing-up", "least-squares", "10 of 10", "1,234"],
            ["cart-pole-swing-up", "sindy", "9 of 10", "10"],
        ];
        let rows = rows.map(|row| row.map(str::to_owned));
        for width in [20, 36, 40, 60, 80] {
            let text = aligned(&rows, width);
            assert!(text.lines().all(|line| display_width(line) <= width), "{width}:\n{text}");
            assert_eq!(text.matches("cart-pole-swing-up").count(), if width < 60 { 1 } else { 2 }, "{text}");
        }
    }
}
