//! Text side by side, or one below the other where it is too wide.

/// Columns of a terminal that nobody has to widen.
const WIDTH: usize = 110;

/// Two titled lists of lines, side by side if they fit; an empty one on the right is left out.
#[must_use]
pub fn beside(left: (&str, &[String]), right: (&str, &[String])) -> String {
    let width =
        |(title, lines): (&str, &[String])| lines.iter().map(|l| columns_of(l)).chain([title.len()]).max().unwrap_or(0);
    if right.1.is_empty() {
        return left.1.iter().fold(left.0.to_owned() + "\n", |text, line| text + line + "\n");
    }
    if width(left) + width(right) + GAP.len() > WIDTH { below(left, right) } else { columns(left, right, width(left)) }
}

const GAP: &str = "    ";

fn columns(left: (&str, &[String]), right: (&str, &[String]), width: usize) -> String {
    let line = |l: &str, r: &str| {
        let padding = " ".repeat(width - columns_of(l));
        format!("{l}{padding}{GAP}{r}").trim_end().to_owned() + "\n"
    };
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

/// Rows of cells, the columns lined up.
#[must_use]
pub fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let widths: Vec<usize> = (0..N).map(|i| rows.iter().map(|row| columns_of(&row[i])).max().unwrap_or(0)).collect();
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| cell.clone() + &" ".repeat(width - columns_of(cell)));
        cells.collect::<Vec<_>>().join("   ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// Places `text` takes on a terminal: marks over letters take none.
fn columns_of(text: &str) -> usize {
    text.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).count()
}

#[cfg(test)]
mod tests {
    #[test]
    fn columns_are_padded_by_what_is_seen() {
        let found = ["θ̈ = 15·sin θ".to_owned(), "x".to_owned()];
        let text = super::beside(("found", &found), ("true", &["same".to_owned()]));
        assert_eq!(text, "found           true\nθ̈ = 15·sin θ    same\nx\n");
    }

    #[test]
    fn cells_line_up() {
        let rows = [["a", "bcd"], ["long", "e"]].map(|row| row.map(str::to_owned));
        assert_eq!(super::aligned(&rows), "a      bcd\nlong   e\n");
    }

    #[test]
    fn what_is_too_wide_stands_below() {
        let long = ["x".repeat(100)];
        let text = super::beside(("found", &long), ("true", &["a long enough equation".to_owned()]));
        assert_eq!(text, format!("found\n  {}\ntrue\n  a long enough equation\n", long[0]));
    }
}
