//! Signs, moduli and positive parts, told apart from where they jump: between two jumps they are smooth.

use crate::expr::{Expr, Function};

/// The arguments of sign, modulus and positive part in some terms. With a variable m for the sign of each of them the terms are smooth: sign(a) is m,
/// |a| is m a, max(a, 0) is (1 + m) a/2. √|a| stays what it is: √(m a) ends where a jumps, in the middle of a step.
#[derive(Debug, Clone)]
pub(crate) struct Switches {
    /// Number of the first variable m.
    first: usize,
    /// The arguments, those within others before them.
    arguments: Vec<Expr>,
}

/// a of |a|.
fn modulus(expr: &Expr) -> Option<&Expr> {
    match expr {
        Expr::Call(Function::Abs, a) => Some(a),
        _ => None,
    }
}

impl Switches {
    /// The switches in `terms` that depend on one of `n_states` states; their signs are variables from number `first` on.
    pub(super) fn among<'a>(terms: impl Iterator<Item = &'a Expr>, n_states: usize, first: usize) -> Self {
        let mut switches = Self { first, arguments: Vec::new() };
        terms.for_each(|term| switches.gather(term, n_states));
        switches
    }

    fn gather(&mut self, expr: &Expr, n_states: usize) {
        match expr {
            Expr::Constant(_) | Expr::Variable(_) => {}
            Expr::Neg(a) | Expr::Power(a, _) => self.gather(a, n_states),
            Expr::Add(a, b) | Expr::Sub(a, b) | Expr::Mul(a, b) | Expr::Div(a, b) => {
                self.gather(a, n_states);
                self.gather(b, n_states);
            }
            Expr::Call(Function::Sqrt, a) if modulus(a).is_some() => self.gather(modulus(a).unwrap_or(a), n_states),
            Expr::Call(f, a) => {
                self.gather(a, n_states);
                let jumps = matches!(f, Function::Sign | Function::Abs | Function::PositivePart)
                    && (0..n_states).any(|i| a.has(i));
                if jumps && !self.arguments.contains(a) {
                    self.arguments.push((**a).clone());
                }
            }
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.arguments.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.arguments.is_empty()
    }

    pub(super) fn arguments(&self) -> &[Expr] {
        &self.arguments
    }

    /// `expr` with the variable m wherever it has one of those functions of one of the arguments.
    pub(crate) fn smooth(&self, expr: &Expr) -> Expr {
        let of = |a: &Expr| Box::new(self.smooth(a));
        match expr {
            Expr::Constant(_) | Expr::Variable(_) => expr.clone(),
            Expr::Neg(a) => Expr::Neg(of(a)),
            Expr::Power(a, n) => Expr::Power(of(a), *n),
            Expr::Add(a, b) => Expr::Add(of(a), of(b)),
            Expr::Sub(a, b) => Expr::Sub(of(a), of(b)),
            Expr::Mul(a, b) => Expr::Mul(of(a), of(b)),
            Expr::Div(a, b) => Expr::Div(of(a), of(b)),
            Expr::Call(Function::Sqrt, a) if modulus(a).is_some() => {
                let inside = Expr::Call(Function::Abs, of(modulus(a).unwrap_or(a)));
                Expr::Call(Function::Sqrt, Box::new(inside))
            }
            Expr::Call(f, a) => {
                let sign =
                    || self.arguments.iter().position(|known| *known == **a).map(|j| Expr::Variable(self.first + j));
                match f {
                    Function::Sign => sign().unwrap_or_else(|| Expr::Call(*f, of(a))),
                    Function::Abs => match sign() {
                        Some(sign) => Expr::Mul(Box::new(sign), of(a)),
                        None => Expr::Call(*f, of(a)),
                    },
                    Function::PositivePart => match sign() {
                        Some(sign) => {
                            let half =
                                Expr::Constant(0.5).times(Expr::Add(Box::new(Expr::Constant(1.0)), Box::new(sign)));
                            Expr::Mul(Box::new(half), of(a))
                        }
                        None => Expr::Call(*f, of(a)),
                    },
                    _ => Expr::Call(*f, of(a)),
                }
            }
        }
    }
}
