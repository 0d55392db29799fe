//! Terms as people write them: `ω²·sin θ`, `cos 3x`.

use std::fmt;

use super::{Expr, Function};
use sindyna_core::number::coefficient as readable;

/// Text of a term for people; made by [`Expr::pretty`]. Not meant to be read back.
#[derive(Debug, Clone, Copy)]
pub struct Pretty<'a> {
    expr: &'a Expr,
    names: &'a [String],
}

impl Expr {
    /// The term as people write it: `ω²·sin θ`.
    #[must_use]
    pub fn pretty<'a>(&'a self, names: &'a [String]) -> Pretty<'a> {
        Pretty::new(self, names)
    }
}

impl<'a> Pretty<'a> {
    pub(super) fn new(expr: &'a Expr, names: &'a [String]) -> Self {
        Self { expr, names }
    }

    fn with(&self, expr: &'a Expr) -> Self {
        Self { expr, names: self.names }
    }

    /// The text as it stands behind a coefficient.
    pub(crate) fn as_factor(&self) -> String {
        self.factor(self.expr)
    }

    /// The text in parentheses where it would fall apart as a factor.
    fn factor(&self, expr: &'a Expr) -> String {
        let text = self.with(expr).to_string();
        match expr {
            Expr::Add(..) | Expr::Sub(..) | Expr::Neg(_) => format!("({text})"),
            Expr::Constant(c) if *c < 0.0 => format!("({text})"),
            _ => text,
        }
    }

    fn argument(&self, function: Function, expr: &'a Expr) -> String {
        let text = self.with(expr).to_string();
        let rest = function.rest();
        let bare = match expr {
            _ if !rest.is_empty() => false,
            Expr::Variable(_) => !text.contains(' '),
            Expr::Mul(a, b) => {
                matches!((&**a, &**b), (Expr::Constant(_), Expr::Variable(_))) && !text.contains([' ', '('])
            }
            _ => false,
        };
        if bare { format!(" {text}") } else { format!("({text}{rest})") }
    }
}

impl fmt::Display for Pretty<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.expr {
            Expr::Constant(c) => f.write_str(&readable(*c)),
            Expr::Variable(i) => match self.names.get(*i) {
                Some(name) => f.write_str(name),
                None => write!(f, "z{i}"),
            },
            Expr::Neg(a) => write!(f, "−{}", self.factor(a)),
            Expr::Add(a, b) => write!(f, "{} + {}", self.with(a), self.with(b)),
            Expr::Sub(a, b) => write!(f, "{} − {}", self.with(a), self.factor(b)),
            // A number stands right before a name: 3x, but 3·(x + y).
            Expr::Mul(a, b) => match (&**a, &**b) {
                (Expr::Constant(_), Expr::Variable(_)) => write!(f, "{}{}", self.factor(a), self.with(b)),
                _ => write!(f, "{}·{}", self.factor(a), self.factor(b)),
            },
            Expr::Div(a, b) => match &**b {
                Expr::Mul(..) | Expr::Div(..) => write!(f, "{}/({})", self.factor(a), self.with(b)),
                _ => write!(f, "{}/{}", self.factor(a), self.factor(b)),
            },
            Expr::Power(a, n) => match &**a {
                Expr::Call(function, inner) if *n > 1 => {
                    write!(f, "{function}{}{}", superscript(*n), self.argument(*function, inner))
                }
                Expr::Variable(_) if !self.with(a).to_string().contains(' ') => {
                    write!(f, "{}{}", self.with(a), superscript(*n))
                }
                _ => write!(f, "({}){}", self.with(a), superscript(*n)),
            },
            Expr::Call(function, a) => match self.expr.as_power() {
                Some((base @ Expr::Variable(_), exponent)) if !self.with(base).to_string().contains(' ') => {
                    write!(f, "{}^{}", self.with(base), self.with(exponent))
                }
                Some((base, exponent)) => write!(f, "({})^{}", self.with(base), self.with(exponent)),
                None => write!(f, "{function}{}", self.argument(*function, a)),
            },
        }
    }
}

/// `n` in raised digits.
fn superscript(n: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        _ => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c as usize - '0' as usize],
    };
    n.to_string().chars().map(raised).collect()
}
