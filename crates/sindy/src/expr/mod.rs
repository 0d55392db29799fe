//! Terms of an equation as small expression trees: built, parsed, printed and evaluated here.

use serde::{Deserialize, Serialize};
mod compiled;
mod derivative;
mod function;
mod nested;
mod parse;
mod pretty;
mod print;
mod several;
mod summands;
mod tape;
mod tie;

pub use compiled::Compiled;
pub use function::Function;
pub use parse::{ParseError, parse};
pub(crate) use parse::{begins_name, continues_name};
pub use pretty::Pretty;
pub use print::Printed;
pub(crate) use tape::Tape;
pub(crate) use tie::Tie;

/// A term: a function of the variables z = (x; u), which are numbered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub enum Expr {
    /// A fixed number.
    Constant(f64),
    /// Variable number `.0` of z.
    Variable(usize),
    /// −a.
    Neg(Box<Expr>),
    /// a + b.
    Add(Box<Expr>, Box<Expr>),
    /// a − b.
    Sub(Box<Expr>, Box<Expr>),
    /// a · b.
    Mul(Box<Expr>, Box<Expr>),
    /// a / b.
    Div(Box<Expr>, Box<Expr>),
    /// a to a whole power.
    Power(Box<Expr>, i32),
    /// A function of a.
    Call(Function, Box<Expr>),
}

impl Expr {
    /// The value at z.
    ///
    /// # Panics
    /// If a variable lies beyond `z`.
    #[must_use]
    pub fn eval(&self, z: &[f64]) -> f64 {
        match self {
            Self::Constant(c) => *c,
            Self::Variable(i) => z[*i],
            Self::Neg(a) => -a.eval(z),
            Self::Add(a, b) => a.eval(z) + b.eval(z),
            Self::Sub(a, b) => a.eval(z) - b.eval(z),
            Self::Mul(a, b) => a.eval(z) * b.eval(z),
            Self::Div(a, b) => a.eval(z) / b.eval(z),
            Self::Power(a, n) => power(a.eval(z), *n),
            Self::Call(f, a) => f.eval(a.eval(z)),
        }
    }

    /// The largest variable number in use, if any.
    #[must_use]
    pub fn max_variable(&self) -> Option<usize> {
        match self {
            Self::Constant(_) => None,
            Self::Variable(i) => Some(*i),
            Self::Neg(a) | Self::Power(a, _) | Self::Call(_, a) => a.max_variable(),
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => {
                a.max_variable().max(b.max_variable())
            }
        }
    }

    /// Operators and functions in the term.
    fn operators(&self) -> usize {
        match self {
            Self::Constant(_) | Self::Variable(_) => 0,
            Self::Neg(a) | Self::Power(a, _) | Self::Call(_, a) => 1 + a.operators(),
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => 1 + a.operators() + b.operators(),
        }
    }

    /// Whether variable `i` is in the term.
    #[must_use]
    pub fn has(&self, i: usize) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Variable(j) => *j == i,
            Self::Neg(a) | Self::Power(a, _) | Self::Call(_, a) => a.has(i),
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => a.has(i) || b.has(i),
        }
    }

    /// The term with `offsets` added to its variables; variables beyond them and offsets of zero change nothing.
    #[must_use]
    pub fn shifted(&self, offsets: &[f64]) -> Self {
        self.replaced(&|i| {
            let by = offsets.get(i).copied().filter(|v| *v != 0.0)?;
            let variable = Box::new(Self::Variable(i));
            Some(if by < 0.0 {
                Self::Sub(variable, Box::new(Self::Constant(-by)))
            } else {
                Self::Add(variable, Box::new(Self::Constant(by)))
            })
        })
    }

    /// The term with what `by` has for each variable; those it has nothing for stay.
    #[must_use]
    pub fn replaced(&self, by: &dyn Fn(usize) -> Option<Self>) -> Self {
        let of = |a: &Self| Box::new(a.replaced(by));
        match self {
            Self::Constant(_) => self.clone(),
            Self::Variable(i) => by(*i).unwrap_or_else(|| self.clone()),
            Self::Neg(a) => Self::Neg(of(a)),
            Self::Add(a, b) => Self::Add(of(a), of(b)),
            Self::Sub(a, b) => Self::Sub(of(a), of(b)),
            Self::Mul(a, b) => Self::Mul(of(a), of(b)),
            Self::Div(a, b) => Self::Div(of(a), of(b)),
            Self::Power(a, n) => Self::Power(of(a), *n),
            Self::Call(f, a) => Self::Call(*f, of(a)),
        }
    }

    /// Whether the term is the number 1.
    #[must_use]
    pub fn is_one(&self) -> bool {
        matches!(self, Self::Constant(c) if c.to_bits() == 1_f64.to_bits())
    }

    /// a · b, with factors of 1 left out.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        if self.is_one() {
            other
        } else if other.is_one() {
            self
        } else {
            Self::Mul(Box::new(self), Box::new(other))
        }
    }

    /// a^c, of a that is positive where c is not whole: then it is e^(c log a).
    pub(crate) fn raised(self, exponent: f64) -> Self {
        if exponent.fract() == 0.0 && exponent.abs() <= f64::from(i32::MAX) {
            return Self::Power(Box::new(self), exponent as i32);
        }
        let log = Self::Call(Function::Log, Box::new(self));
        Self::Call(Function::Exp, Box::new(Self::Mul(Box::new(Self::Constant(exponent)), Box::new(log))))
    }

    /// a and c of e^(c log a), which is the power a^c.
    #[must_use]
    pub fn as_power(&self) -> Option<(&Self, &Self)> {
        let Self::Call(Function::Exp, exponent) = self else { return None };
        let Self::Mul(c, log) = &**exponent else { return None };
        let Self::Call(Function::Log, a) = &**log else { return None };
        matches!(**c, Self::Constant(_) | Self::Variable(_)).then_some((&**a, &**c))
    }

    /// a to a whole power, with a power of 1 left out.
    #[must_use]
    pub fn to_power(self, exponent: i32) -> Self {
        match exponent {
            0 => Self::Constant(1.0),
            1 => self,
            _ => Self::Power(Box::new(self), exponent),
        }
    }

    /// f(k · a), with a k of 1 left out.
    #[must_use]
    pub fn wave(function: Function, k: usize, a: Self) -> Self {
        let argument = if k == 1 { a } else { Self::Mul(Box::new(Self::Constant(k as f64)), Box::new(a)) };
        Self::Call(function, Box::new(argument))
    }
}

/// The one way powers are computed, so that trees and tapes agree to the last bit.
pub(crate) fn power(base: f64, exponent: i32) -> f64 {
    match exponent {
        2 => base * base,
        3 => base * base * base,
        n => base.powi(n),
    }
}
