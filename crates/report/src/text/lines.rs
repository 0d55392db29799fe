//! Lines that are too long for a terminal, broken where they are read best.

use textwrap::core::{Word, display_width};
use textwrap::{Options, WordSeparator, WrapAlgorithm, wrap};

/// Columns by which the rest of a broken line stands further to the right.
const HANGING: usize = 4;

/// `text` with every line that is longer than `width` columns broken: an equation before a sign between its terms, another line between words.
///
/// ```
/// let text = "dv/dt = −0.5 v + 2 (v − w) u + 3 u\n";
/// assert_eq!(sindyna_report::text::fitted(text, 24), "dv/dt = −0.5 v\n    + 2 (v − w) u + 3 u\n");
/// ```
#[must_use]
pub fn fitted(text: &str, width: usize) -> String {
    text.split_inclusive('\n').map(|line| broken(line, width)).collect()
}

fn broken(line: &str, width: usize) -> String {
    let bare = line.trim_end_matches('\n');
    if display_width(bare) <= width {
        return line.to_owned();
    }
    let inner = bare.trim_start_matches(' ');
    let first = " ".repeat(bare.len() - inner.len());
    let rest = " ".repeat(first.len() + HANGING);
    let separator = if inner.contains(" = ") { WordSeparator::Custom(terms) } else { WordSeparator::AsciiSpace };
    let options = Options::new(width)
        .initial_indent(&first)
        .subsequent_indent(&rest)
        .word_separator(separator)
        .wrap_algorithm(WrapAlgorithm::FirstFit)
        .break_words(false);
    wrap(inner, options).join("\n") + &line[bare.len()..]
}

/// The terms of an equation, each with its sign: a sign inside parentheses is part of a term.
fn terms(equation: &str) -> Box<dyn Iterator<Item = Word<'_>> + '_> {
    let (mut depth, mut begun, mut words) = (0_usize, 0, Vec::new());
    for (at, c) in equation.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            // A sign between terms has blanks on both sides.
            '+' | '-' | '−' if depth == 0 && at > begun => {
                let after = &equation[at + c.len_utf8()..];
                if equation[..at].ends_with(' ') && !equation[..at].ends_with("= ") && after.starts_with(' ') {
                    words.push(Word::from(&equation[begun..at]));
                    begun = at;
                }
            }
            _ => {}
        }
    }
    words.push(Word::from(&equation[begun..]));
    Box::new(words.into_iter())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_equation_is_broken_before_the_sign_of_a_term_and_nowhere_else() {
        let text =
            "  v̇ = −0.0645554 v + 0.0971933 ω²·sin(θ + 0.00166667) − 0.0971933 cos(θ + 0.00166667)·ω̇ + 6.45554 u\n";
        let expected = "  v̇ = −0.0645554 v + 0.0971933 ω²·sin(θ + 0.00166667)
      − 0.0971933 cos(θ + 0.00166667)·ω̇ + 6.45554 u\n";
        assert_eq!(fitted(text, 60), expected);
        assert_eq!(fitted(text, 110), text);
        for width in 60..110 {
            assert!(fitted(text, width).lines().all(|line| display_width(line) <= width), "{width}");
        }
    }

    #[test]
    fn prose_is_broken_between_words_and_a_long_path_is_left_whole() {
        let text = "warning: the inputs hardly move\nrecord: /a/long/path/that/has/no/blank/in/it (model.json)\n";
        let expected = "warning: the inputs\n    hardly move\nrecord:\n    /a/long/path/that/has/no/blank/in/it\n    (model.json)\n";
        assert_eq!(fitted(text, 20), expected);
    }
}
