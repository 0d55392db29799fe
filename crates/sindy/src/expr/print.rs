//! Terms as plain text that the parser reads back.

use std::fmt;

use super::{Expr, Tie};

/// Text of a term; made by [`Expr::display`].
#[derive(Debug, Clone, Copy)]
pub struct Printed<'a> {
    expr: &'a Expr,
    names: &'a [String],
}

impl Expr {
    /// The term as text that [`parse`](super::parse()) reads back, with `names` for the variables.
    #[must_use]
    pub fn display<'a>(&'a self, names: &'a [String]) -> Printed<'a> {
        Printed::new(self, names)
    }
}

impl<'a> Printed<'a> {
    pub(super) fn new(expr: &'a Expr, names: &'a [String]) -> Self {
        Self { expr, names }
    }
}

impl Printed<'_> {
    /// Writes `expr`, in parentheses if it is looser than `at_least`.
    fn write(&self, f: &mut fmt::Formatter<'_>, expr: &Expr, at_least: Tie) -> fmt::Result {
        if Tie::of(expr) < at_least {
            f.write_str("(")?;
            self.write(f, expr, Tie::Sum)?;
            return f.write_str(")");
        }
        let mut pair = |a: &Expr, sign: &str, b: &Expr, left: Tie, right: Tie| {
            self.write(f, a, left)?;
            f.write_str(sign)?;
            self.write(f, b, right)
        };
        match expr {
            // What the parser reads from the left binds to the left, so only the right operand needs more.
            Expr::Add(a, b) => pair(a, " + ", b, Tie::Sum, Tie::Product),
            Expr::Sub(a, b) => pair(a, " - ", b, Tie::Sum, Tie::Product),
            Expr::Mul(a, b) => pair(a, "*", b, Tie::Product, Tie::Sign),
            Expr::Div(a, b) => pair(a, "/", b, Tie::Product, Tie::Sign),
            // A number right after the sign would be read as a negative number.
            Expr::Neg(a) if matches!(**a, Expr::Constant(_)) => {
                f.write_str("-(")?;
                self.write(f, a, Tie::Sum)?;
                f.write_str(")")
            }
            Expr::Neg(a) => {
                f.write_str("-")?;
                self.write(f, a, Tie::Power)
            }
            Expr::Power(a, n) => {
                self.write(f, a, Tie::Atom)?;
                write!(f, "^{n}")
            }
            Expr::Call(function, a) => {
                write!(f, "{function}(")?;
                self.write(f, a, Tie::Sum)?;
                write!(f, "{})", function.rest())
            }
            Expr::Constant(c) => {
                let text = format!("{c:?}");
                f.write_str(text.strip_suffix(".0").unwrap_or(&text))
            }
            Expr::Variable(i) => match self.names.get(*i) {
                Some(name) => f.write_str(name),
                None => write!(f, "z{i}"),
            },
        }
    }
}

impl fmt::Display for Printed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, self.expr, Tie::Sum)
    }
}
