//! Where an expression needs parentheses.

use super::Expr;

/// How tightly a piece of code holds together; a looser one needs parentheses inside a tighter one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Tie {
    Sum,
    Product,
    Sign,
    Power,
    Atom,
}

impl Tie {
    /// That of `expr`, written without parentheses.
    pub(crate) fn of(expr: &Expr) -> Self {
        match expr {
            Expr::Add(..) | Expr::Sub(..) => Self::Sum,
            Expr::Mul(..) | Expr::Div(..) => Self::Product,
            Expr::Neg(_) => Self::Sign,
            Expr::Power(..) => Self::Power,
            Expr::Constant(c) if c.is_sign_negative() => Self::Sign,
            Expr::Constant(_) | Expr::Variable(_) | Expr::Call(..) => Self::Atom,
        }
    }
}
