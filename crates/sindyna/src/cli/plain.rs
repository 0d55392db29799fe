//! Text for a terminal: what comes out of files may hold anything.

use std::borrow::Cow;

/// Characters of one line of a message; whoever reads it wants to know where, not all of it.
const LONGEST: usize = 1_000;

/// Digits of one number in a message.
const MOST_DIGITS: usize = 40;

/// `text` without the characters that a terminal obeys or that turn the direction of writing; lines stay lines.
pub(crate) fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if obeyed(c) { shown.extend(c.escape_unicode()) } else { shown.push(c) }
    }
    Cow::Owned(shown)
}

/// [`plain`], with long numbers and long lines cut in their middle.
pub(crate) fn message(text: &str) -> String {
    let plain = plain(text);
    plain.split('\n').map(|line| cut(&digits_cut(line))).collect::<Vec<_>>().join("\n")
}

/// Whether a terminal does something else with `c` than to show it.
fn obeyed(c: char) -> bool {
    let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && c != '\n' && c != '\t')
}

fn cut(line: &str) -> String {
    let count = line.chars().count();
    if count <= LONGEST {
        return line.to_owned();
    }
    let (begin, end) = (3 * LONGEST / 4, LONGEST / 4);
    let head: String = line.chars().take(begin).collect();
    let tail: String = line.chars().skip(count - end).collect();
    format!("{head} … {} characters … {tail}", count - begin - end)
}

fn digits_cut(line: &str) -> String {
    let mut shown = String::with_capacity(line.len());
    let mut rest = line;
    while let Some(begin) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, from) = rest.split_at(begin);
        let end = from.find(|c: char| !c.is_ascii_digit()).unwrap_or(from.len());
        let (digits, after) = from.split_at(end);
        shown += before;
        match digits.get(..MOST_DIGITS / 2).filter(|_| digits.len() > MOST_DIGITS) {
            Some(first) => shown += &format!("{first}…({} digits)", digits.len()),
            None => shown += digits,
        }
        rest = after;
    }
    shown + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_shown_instead() {
        assert_eq!(plain("θ̇ = 15 sin θ\n\t[rad]"), "θ̇ = 15 sin θ\n\t[rad]");
        for (text, shown) in [
            ("a\u{1b}[31mb", "a\\u{1b}[31mb"),
            ("a\rb\u{8}", "a\\u{d}b\\u{8}"),
            ("\u{9b}2J", "\\u{9b}2J"),
            ("x\u{202e}y", "x\\u{202e}y"),
        ] {
            assert_eq!(plain(text), shown);
        }
    }

    #[test]
    fn long_lines_and_numbers_are_cut_in_messages() {
        let number = format!("got {}, at most 1e150", "1".repeat(301));
        assert_eq!(message(&number), format!("got {}…(301 digits), at most 1e150", "1".repeat(20)));
        let short = "0.1234567890123456789 of 12\n\nhint: θ";
        assert_eq!(message(short), short);
        let long = format!("error: begin {} end\n\nhint: {}", "θ".repeat(200_000), "a".repeat(2_000));
        let shown = message(&long);
        assert!(shown.starts_with("error: begin θ") && shown.contains(" end\n\nhint: a"), "{shown}");
        assert!(shown.chars().count() < 2_200 && shown.contains("… 199017 characters …"), "{shown}");
    }
}
