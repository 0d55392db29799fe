//! Conditions such as `abs(x) > 1.9 or v < -3`: comparisons of two terms, joined.

use anyhow::{Context as _, bail};
use sindyna_sindy::{Expr, parse};

/// Levels of parentheses around comparisons.
const MAX_DEPTH: usize = 64;

/// A condition on numbered variables. A comparison with NaN does not hold.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Condition {
    Compare(Expr, Comparison, Expr),
    All(Vec<Self>),
    Any(Vec<Self>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Comparison {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}

impl Condition {
    /// Reads a condition over the variables `names`.
    ///
    /// Grammar: comparisons `a < b` (also `<=`, `>`, `>=`, `≤`, `≥`) of terms as [`parse`] reads them, joined by `and`
    /// and `or`, where `and` binds tighter; parentheses may stand around any of it.
    pub(super) fn parse(text: &str, names: &[String]) -> anyhow::Result<Self> {
        read(text, names, 0)
    }

    /// The same with what `by` has for each variable.
    pub(super) fn replaced(self, by: &dyn Fn(usize) -> Option<Expr>) -> Self {
        let all = |parts: Vec<Self>| parts.into_iter().map(|part| part.replaced(by)).collect();
        match self {
            Self::Compare(left, comparison, right) => Self::Compare(left.replaced(by), comparison, right.replaced(by)),
            Self::All(parts) => Self::All(all(parts)),
            Self::Any(parts) => Self::Any(all(parts)),
        }
    }

    /// Whether it holds at z.
    pub(super) fn holds(&self, z: &[f64]) -> bool {
        match self {
            Self::Compare(left, comparison, right) => {
                let (a, b) = (left.eval(z), right.eval(z));
                match comparison {
                    Comparison::Less => a < b,
                    Comparison::LessEqual => a <= b,
                    Comparison::Greater => a > b,
                    Comparison::GreaterEqual => a >= b,
                }
            }
            Self::All(parts) => parts.iter().all(|p| p.holds(z)),
            Self::Any(parts) => parts.iter().any(|p| p.holds(z)),
        }
    }
}

fn read(text: &str, names: &[String], depth: usize) -> anyhow::Result<Condition> {
    if depth > MAX_DEPTH {
        bail!("parentheses nested deeper than {MAX_DEPTH} levels");
    }
    for (word, join) in [("or", Condition::Any as fn(Vec<Condition>) -> Condition), ("and", Condition::All)] {
        let parts = split_at_word(text, word);
        if parts.len() > 1 {
            let parts = parts.into_iter().map(|part| read(part, names, depth + 1));
            return Ok(join(parts.collect::<anyhow::Result<_>>()?));
        }
    }
    let text = text.trim();
    let found = comparisons(text);
    let [(at, length, comparison)] = found[..] else {
        if let (true, Some(inner)) = (found.is_empty(), inside_parentheses(text)) {
            return read(inner, names, depth + 1);
        }
        bail!(
            "`{text}` has {} comparisons, expected one of `<`, `<=`, `>`, `>=` between two formulas; \
             join several with `and` or `or`",
            found.len()
        );
    };
    let side = |side: &str| parse(side.trim(), names).with_context(|| format!("in `{text}`"));
    Ok(Condition::Compare(side(&text[..at])?, comparison, side(&text[at + length..])?))
}

/// The characters outside all parentheses, with their positions in bytes.
fn outside(text: &str) -> impl Iterator<Item = (usize, char)> {
    let mut depth = 0_i32;
    text.char_indices().filter(move |&(_, c)| {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        depth == 0 && c != ')'
    })
}

/// The comparisons outside all parentheses: where, how many bytes, which.
fn comparisons(text: &str) -> Vec<(usize, usize, Comparison)> {
    let comparison = |(at, c): (usize, char)| {
        let equal = text[at + c.len_utf8()..].starts_with('=');
        let found = match c {
            '<' if equal => Comparison::LessEqual,
            '>' if equal => Comparison::GreaterEqual,
            '<' => Comparison::Less,
            '>' => Comparison::Greater,
            '≤' => Comparison::LessEqual,
            '≥' => Comparison::GreaterEqual,
            _ => return None,
        };
        Some((at, c.len_utf8() + usize::from(equal), found))
    };
    outside(text).filter_map(comparison).collect()
}

/// `text` cut at every `word` that stands alone outside all parentheses.
fn split_at_word<'a>(text: &'a str, word: &str) -> Vec<&'a str> {
    let in_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut parts = Vec::new();
    let mut begin = 0;
    for (at, _) in outside(text) {
        let (before, after) = text.split_at(at);
        let Some(rest) = after.strip_prefix(word) else { continue };
        if !before.ends_with(in_name) && !rest.starts_with(in_name) {
            parts.push(&text[begin..at]);
            begin = at + word.len();
        }
    }
    parts.push(&text[begin..]);
    parts
}

/// What stands in the one pair of parentheses around all of `text`.
fn inside_parentheses(text: &str) -> Option<&str> {
    let inner = text.strip_prefix('(')?.strip_suffix(')')?;
    outside(text).next().is_none().then_some(inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<String> {
        ["next_x", "next_θ", "world"].map(String::from).to_vec()
    }

    #[test]
    fn conditions_mean_what_they_say() {
        for (text, holds, fails) in [
            ("abs(next_x) > 1.9", [-2.0, 0.0, 0.0], [1.9, 0.0, 0.0]),
            ("next_x >= 1", [1.0, 0.0, 0.0], [0.9, 0.0, 0.0]),
            ("next_x ≤ next_θ", [1.0, 1.0, 0.0], [1.1, 1.0, 0.0]),
            ("next_x<0 or next_θ<0", [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]),
            // `and` binds tighter than `or`.
            ("next_x > 0 or next_θ > 0 and world > 0", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ("(next_x > 0 or next_θ > 0) and world > 0", [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
            ("((next_x + 1) * (next_θ - 1) <= 0)", [0.0, 0.5, 0.0], [0.0, 2.0, 0.0]),
            // `or` inside a name is no word.
            ("world > 1", [0.0, 0.0, 2.0], [0.0, 0.0, f64::NAN]),
        ] {
            let condition = Condition::parse(text, &names()).unwrap();
            assert!(condition.holds(&holds), "{text} at {holds:?}");
            assert!(!condition.holds(&fails), "{text} at {fails:?}");
        }
    }

    #[test]
    fn what_is_no_condition_is_named() {
        for (text, says) in [
            ("next_x", "`next_x` has 0 comparisons"),
            ("next_x = 1", "0 comparisons"),
            ("-1 < next_x < 1", "2 comparisons"),
            ("next_x > 1 and", "`` has 0 comparisons"),
            ("next_y > 1", "no variable named `next_y`"),
            ("next_x > ", "expected a number, a name"),
            ("(next_x > 1", "0 comparisons"),
            ("next_x) > 1", "`next_x) > 1` has 0 comparisons"),
            ("next_x => 1", "found `=`"),
        ] {
            let refusal = format!("{:#}", Condition::parse(text, &names()).unwrap_err());
            assert!(refusal.contains(says), "{text}: {refusal}");
        }
        assert!(Condition::parse(&"(".repeat(100_000), &names()).is_err());
        assert!(Condition::parse(&format!("{}x > 1{}", "(".repeat(1000), ")".repeat(1000)), &names()).is_err());
    }
}
