//! Terms from text, such as `v^2*sin(x)`.

use std::f64::consts::PI;

use super::several::{angle, complement, exceeds, larger, smaller, tolerance};
use super::{Expr, Function};

/// Why a term could not be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParseError {
    /// Something else should stand here.
    #[error("`{text}`: expected {expected} at position {position}, found {found}")]
    Unexpected {
        /// The whole term.
        text: String,
        /// What would have been right.
        expected: &'static str,
        /// What stands there.
        found: String,
        /// Position in the text, counted in characters from 1.
        position: usize,
    },
    /// A name that is neither a variable nor a function.
    #[error("`{text}`: no {what} named `{name}` (position {position}); known: {known}")]
    UnknownName {
        /// The whole term.
        text: String,
        /// Whether a variable or a function was looked for.
        what: &'static str,
        /// The name.
        name: String,
        /// Names that would be right.
        known: String,
        /// Position in the text, counted in characters from 1.
        position: usize,
    },
    /// A tolerance that nothing is within.
    #[error(
        "`{text}`: tolerance(a, low, high, margin) needs low ≤ high and a margin of at least 0 (position {position})"
    )]
    Tolerance {
        /// The whole term.
        text: String,
        /// Position in the text, counted in characters from 1.
        position: usize,
    },
    /// More operators than any term needs.
    #[error("`{text}`: more than {limit} operators")]
    TooLong {
        /// The beginning of the term.
        text: String,
        /// Operators allowed.
        limit: usize,
    },
    /// Parentheses nested deeper than any term needs.
    #[error("`{text}`: nested deeper than {limit} levels")]
    TooDeep {
        /// The whole term.
        text: String,
        /// Levels allowed.
        limit: usize,
    },
}

/// Levels of nesting allowed.
const MAX_DEPTH: usize = 64;

/// Operators allowed. A sum of many terms is a tree as deep as it is long, and trees are walked by recursion.
const MAX_OPERATORS: usize = 1000;

/// Reads a term over the variables `names`.
///
/// Grammar: numbers, `pi`, names, `+ - * / ^`, parentheses, the functions of [`Function::ALL`] as `sin(x)`, and `max(a, b)`, `min(a, b)`,
/// `clip(a, low, high)`, `atan2(y, x)` and `tolerance(a, low, high, margin)`: 1 between `low` and `high`, and outside a Gaussian that is 0.1 at the distance `margin` (0 for a margin of 0). A comparison in parentheses,
/// `(a < b)` or with `<=`, `>`, `>=`, is 1 where it holds, else 0. Powers are numbers and bind tighter than a sign: `-x^2` is −(x²); one that is not whole, `x^0.7`, is `exp(0.7*log(x))`. `·`, `−` and raised digits (`x²`) are read as well.
///
/// # Errors
/// [`ParseError`] with the position of the first thing that does not fit.
///
/// # Examples
/// ```
/// let names = ["x".to_string(), "v".to_string()];
/// let term = sindyna_sindy::parse("v^2*sin(x)", &names)?;
/// assert_eq!(term.eval(&[0.5, 3.0]), 9.0 * 0.5_f64.sin());
/// assert_eq!(term.pretty(&names).to_string(), "v²·sin x");
/// # Ok::<(), sindyna_sindy::ParseError>(())
/// ```
pub fn parse(text: &str, names: &[String]) -> Result<Expr, ParseError> {
    let mut parser = Parser { text, chars: text.chars().collect(), at: 0, names, depth: 0, operators: 0 };
    let expr = parser.sum()?;
    parser.skip_space();
    if parser.at < parser.chars.len() {
        let compares = parser.peek().is_some_and(|c| COMPARISONS.contains(&c));
        let expected = if compares {
            "an operator or the end (a comparison stands in parentheses)"
        } else {
            "an operator or the end"
        };
        return Err(parser.unexpected(expected));
    }
    Ok(expr)
}

/// Whether `c` may begin a name.
pub(crate) fn begins_name(c: char) -> bool {
    (c.is_alphabetic() && raised_digit(c).is_none()) || c == '_'
}

/// Whether `c` may go on in a name. Dots over letters (`θ̇`) are combining marks.
pub(crate) fn continues_name(c: char) -> bool {
    (c.is_alphanumeric() && raised_digit(c).is_none()) || c == '_' || ('\u{300}'..='\u{36f}').contains(&c)
}

fn raised_digit(c: char) -> Option<u32> {
    ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'].iter().position(|&d| d == c).map(|d| d as u32)
}

/// What begins a comparison.
const COMPARISONS: [char; 4] = ['<', '>', '≤', '≥'];

/// Functions of several terms, beside `max`.
const MIN: &str = "min";
const CLIP: &str = "clip";
const TOLERANCE: &str = "tolerance";
const ATAN2: &str = "atan2";

struct Parser<'a> {
    text: &'a str,
    chars: Vec<char>,
    at: usize,
    names: &'a [String],
    depth: usize,
    operators: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    fn skip_space(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// Takes the next character if it is one of `wanted`.
    fn take(&mut self, wanted: &[char]) -> Option<char> {
        self.skip_space();
        let c = self.peek().filter(|c| wanted.contains(c))?;
        self.at += 1;
        Some(c)
    }

    fn unexpected(&self, expected: &'static str) -> ParseError {
        let found = self.peek().map_or_else(|| "the end".to_owned(), |c| format!("`{c}`"));
        ParseError::Unexpected { text: self.text.to_owned(), expected, found, position: self.at + 1 }
    }

    fn deeper(&mut self) -> Result<(), ParseError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(ParseError::TooDeep { text: self.text.to_owned(), limit: MAX_DEPTH });
        }
        Ok(())
    }

    fn longer(&mut self) -> Result<(), ParseError> {
        self.operators += 1;
        if self.operators > MAX_OPERATORS { Err(self.too_long()) } else { Ok(()) }
    }

    /// A term that was made of others, some of which may stand in it more than once.
    fn made(&self, term: Expr) -> Result<Expr, ParseError> {
        if term.operators() > MAX_OPERATORS { Err(self.too_long()) } else { Ok(term) }
    }

    fn too_long(&self) -> ParseError {
        let text = self.text.chars().take(40).chain("…".chars()).collect();
        ParseError::TooLong { text, limit: MAX_OPERATORS }
    }

    fn sum(&mut self) -> Result<Expr, ParseError> {
        self.deeper()?;
        let mut left = self.product()?;
        while let Some(sign) = self.take(&['+', '-', '−']) {
            self.longer()?;
            let right = self.product()?;
            left = match sign {
                '+' => Expr::Add(Box::new(left), Box::new(right)),
                _ => Expr::Sub(Box::new(left), Box::new(right)),
            };
        }
        self.depth -= 1;
        Ok(left)
    }

    fn product(&mut self) -> Result<Expr, ParseError> {
        let mut left = self.signed()?;
        while let Some(sign) = self.take(&['*', '·', '/']) {
            self.longer()?;
            let right = self.signed()?;
            left = match sign {
                '/' => Expr::Div(Box::new(left), Box::new(right)),
                _ => Expr::Mul(Box::new(left), Box::new(right)),
            };
        }
        Ok(left)
    }

    fn signed(&mut self) -> Result<Expr, ParseError> {
        if self.take(&['-', '−']).is_none() {
            return self.raised();
        }
        self.skip_space();
        // `-2` is a number of its own, `-2^2` and `-x` are not.
        let number = self.peek().is_some_and(|c| c.is_ascii_digit() || c == '.');
        self.deeper()?;
        let inner = self.signed()?;
        self.depth -= 1;
        Ok(match inner {
            Expr::Constant(c) if number => Expr::Constant(-c),
            other => Expr::Neg(Box::new(other)),
        })
    }

    fn raised(&mut self) -> Result<Expr, ParseError> {
        let base = self.atom()?;
        if self.take(&['^']).is_some() {
            return self.exponent().map(|exponent| base.raised(exponent));
        }
        let mut exponent = 0_u32;
        while let Some(digit) = self.peek().and_then(raised_digit) {
            exponent = exponent.saturating_mul(10).saturating_add(digit);
            self.at += 1;
        }
        match i32::try_from(exponent) {
            Ok(0) => Ok(base),
            Ok(n) => Ok(Expr::Power(Box::new(base), n)),
            Err(_) => Err(self.unexpected("a smaller power")),
        }
    }

    fn exponent(&mut self) -> Result<f64, ParseError> {
        let sign = if self.take(&['-', '−']).is_some() { -1.0 } else { 1.0 };
        self.skip_space();
        let begin = self.at;
        while self.peek().is_some_and(|c| c.is_ascii_digit() || c == '.') {
            self.at += 1;
        }
        let digits: String = self.chars[begin..self.at].iter().collect();
        match digits.parse::<f64>() {
            Ok(n) if n <= f64::from(i32::MAX) => Ok(sign * n),
            _ => {
                self.at = begin;
                Err(self.unexpected("a number as the power"))
            }
        }
    }

    fn atom(&mut self) -> Result<Expr, ParseError> {
        self.skip_space();
        match self.peek() {
            Some('(') => self.parenthesis(),
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if begins_name(c) => self.name(),
            _ => Err(self.unexpected("a number, a name or `(`")),
        }
    }

    fn parenthesis(&mut self) -> Result<Expr, ParseError> {
        self.at += 1;
        let left = self.sum()?;
        let inner = match self.take(&COMPARISONS) {
            None => left,
            Some(sign) => {
                let equal = matches!(sign, '≤' | '≥') || self.peek() == Some('=');
                if matches!(sign, '<' | '>') && equal {
                    self.at += 1;
                }
                let right = self.sum()?;
                let (small, large) = if matches!(sign, '<' | '≤') { (left, right) } else { (right, left) };
                // small ≤ large where small does not exceed large.
                if equal { complement(exceeds(small, large)) } else { exceeds(large, small) }
            }
        };
        match self.take(&[')']) {
            Some(_) => Ok(inner),
            None => Err(self.unexpected("`)`")),
        }
    }

    /// As many terms between parentheses, with commas between them.
    fn arguments<const N: usize>(&mut self) -> Result<[Expr; N], ParseError> {
        self.at += 1;
        let mut all = [const { Expr::Constant(0.0) }; N];
        for (at, argument) in all.iter_mut().enumerate() {
            *argument = self.sum()?;
            let (end, expected) = if at + 1 < N { (',', "`,`") } else { (')', "`)`") };
            self.take(&[end]).ok_or_else(|| self.unexpected(expected))?;
        }
        Ok(all)
    }

    fn number(&mut self) -> Result<Expr, ParseError> {
        let begin = self.at;
        let digit = |c: char| c.is_ascii_digit() || c == '.';
        while self.peek().is_some_and(digit) {
            self.at += 1;
        }
        if self.peek().is_some_and(|c| c == 'e' || c == 'E') {
            let sign = usize::from(matches!(self.chars.get(self.at + 1), Some('+' | '-')));
            if self.chars.get(self.at + 1 + sign).is_some_and(char::is_ascii_digit) {
                self.at += 1 + sign;
                while self.peek().is_some_and(|c| c.is_ascii_digit()) {
                    self.at += 1;
                }
            }
        }
        let digits: String = self.chars[begin..self.at].iter().collect();
        match digits.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Expr::Constant(value)),
            _ => {
                self.at = begin;
                Err(self.unexpected("a finite number"))
            }
        }
    }

    fn name(&mut self) -> Result<Expr, ParseError> {
        let begin = self.at;
        while self.peek().is_some_and(continues_name) {
            self.at += 1;
        }
        let name: String = self.chars[begin..self.at].iter().collect();
        let unknown = |what, known: Vec<&str>| ParseError::UnknownName {
            text: self.text.to_owned(),
            what,
            name: name.clone(),
            known: known.join(", "),
            position: begin + 1,
        };
        if self.peek() == Some('(') {
            let known = || Function::ALL.iter().map(|f| f.name()).chain([MIN, CLIP, ATAN2, TOLERANCE]).collect();
            return match (Function::named(&name), name.as_str()) {
                (Some(Function::PositivePart), _) => {
                    self.arguments().map(|[a, b]| larger(a, b)).and_then(|term| self.made(term))
                }
                (Some(function), _) => Ok(Expr::Call(function, Box::new(self.parenthesis()?))),
                (None, MIN) => self.arguments().map(|[a, b]| smaller(a, b)).and_then(|term| self.made(term)),
                (None, CLIP) => {
                    let clipped = |[a, low, high]: [Expr; 3]| smaller(larger(a, low), high);
                    self.arguments().map(clipped).and_then(|term| self.made(term))
                }
                (None, ATAN2) => self.arguments().map(|[y, x]| angle(y, x)).and_then(|term| self.made(term)),
                (None, TOLERANCE) => {
                    let [a, low, high, margin] = self.arguments()?;
                    let falls = matches!((&low, &high), (Expr::Constant(low), Expr::Constant(high)) if low > high);
                    if falls || matches!(margin, Expr::Constant(margin) if margin < 0.0) {
                        let (text, position) = (self.text.to_owned(), begin + 1);
                        return Err(ParseError::Tolerance { text, position });
                    }
                    self.made(tolerance(a, low, high, margin))
                }
                (None, _) => Err(unknown("function", known())),
            };
        }
        match self.names.iter().position(|n| *n == name) {
            Some(i) => Ok(Expr::Variable(i)),
            None if ["pi", "π"].contains(&name.as_str()) => Ok(Expr::Constant(PI)),
            None => Err(unknown("variable", self.names.iter().map(String::as_str).collect())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_term_without_end_is_refused() {
        let names = ["x".to_owned()];
        let long = |operator: &str, n: usize| vec!["x"; n].join(operator);
        for operator in ["+", "*", "-", "/"] {
            assert!(parse(&long(operator, 500), &names).is_ok());
            let error = parse(&long(operator, 100_000), &names).expect_err("too long");
            assert!(error.to_string().ends_with("…`: more than 1000 operators"), "{error}");
        }
    }
}
