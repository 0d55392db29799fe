//! Partial derivatives of terms, as terms.

use super::{Expr, Function};

impl Expr {
    /// ∂/∂z of the term for variable number `variable`; `None` where it is zero everywhere.
    ///
    /// |a| has the derivative sign(a), max(a, 0) the derivative (1 + sign(a))/2, sign(a) the derivative zero: right but for a = 0.
    #[must_use]
    pub fn derivative(&self, variable: usize) -> Option<Self> {
        match self {
            Self::Constant(_) => None,
            Self::Variable(i) => (*i == variable).then_some(Self::Constant(1.0)),
            Self::Neg(a) => a.derivative(variable).map(negative),
            Self::Add(a, b) => match (a.derivative(variable), b.derivative(variable)) {
                (Some(a), Some(b)) => Some(Self::Add(Box::new(a), Box::new(b))),
                (a, b) => a.or(b),
            },
            Self::Sub(a, b) => match (a.derivative(variable), b.derivative(variable)) {
                (Some(a), Some(b)) => Some(Self::Sub(Box::new(a), Box::new(b))),
                (a, b) => a.or_else(|| b.map(negative)),
            },
            Self::Mul(a, b) => {
                let left = a.derivative(variable).map(|d| d.times((**b).clone()));
                let right = b.derivative(variable).map(|d| d.times((**a).clone()));
                match (left, right) {
                    (Some(a), Some(b)) => Some(Self::Add(Box::new(a), Box::new(b))),
                    (a, b) => a.or(b),
                }
            }
            Self::Div(a, b) => {
                let over = |d: Self| Self::Div(Box::new(d), b.clone());
                let left = a.derivative(variable).map(over);
                let square = Self::Power(b.clone(), 2);
                let right =
                    b.derivative(variable).map(|d| Self::Div(Box::new(d.times((**a).clone())), Box::new(square)));
                match (left, right) {
                    (Some(a), Some(b)) => Some(Self::Sub(Box::new(a), Box::new(b))),
                    (a, b) => a.or_else(|| b.map(negative)),
                }
            }
            Self::Power(a, n) => {
                let inner = a.derivative(variable)?;
                let outer = match n {
                    0 => return None,
                    1 => return Some(inner),
                    n => Self::Constant(f64::from(*n)).times((**a).clone().to_power(n - 1)),
                };
                Some(inner.times(outer))
            }
            Self::Call(f, a) => {
                let inner = a.derivative(variable)?;
                outer(*f, a).map(|outer| inner.times(outer))
            }
        }
    }
}

/// f′(a); `None` where it is zero everywhere.
fn outer(f: Function, a: &Expr) -> Option<Expr> {
    let call = |f| Expr::Call(f, Box::new(a.clone()));
    let one = || Box::new(Expr::Constant(1.0));
    let square = |e| Box::new(Expr::Power(Box::new(e), 2));
    Some(match f {
        Function::Sin => call(Function::Cos),
        Function::Cos => negative(call(Function::Sin)),
        Function::Tan => Expr::Add(one(), square(call(Function::Tan))),
        Function::Exp => call(Function::Exp),
        Function::Log => Expr::Div(one(), Box::new(a.clone())),
        Function::Sqrt => Expr::Div(Box::new(Expr::Constant(0.5)), Box::new(call(Function::Sqrt))),
        Function::Abs => call(Function::Sign),
        Function::Sign => return None,
        Function::Tanh => Expr::Sub(one(), square(call(Function::Tanh))),
        Function::Atan => Expr::Div(one(), Box::new(Expr::Add(one(), square(a.clone())))),
        Function::PositivePart => Expr::Constant(0.5).times(Expr::Add(one(), Box::new(call(Function::Sign)))),
    })
}

fn negative(a: Expr) -> Expr {
    match a {
        Expr::Constant(c) => Expr::Constant(-c),
        Expr::Neg(a) => *a,
        a => Expr::Neg(Box::new(a)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    #[test]
    fn derivatives_are_those_of_differences() {
        let names = ["x".to_owned(), "y".to_owned()];
        for text in [
            "3",
            "x",
            "-x*y",
            "x^3*sin(2*y)",
            "x/(1+y^2)",
            "tan(x)*exp(y)",
            "log(2+x)-sqrt(y)",
            "abs(x)*x",
            "tanh(x/0.1)",
            "cos(x-y)*(x+y)",
            "sign(x)*y",
            "y*max(x-0.5, 0)",
            "clip(x*y, -1, 0.5)",
            "x^-2",
            "1/x",
        ] {
            let term = parse(text, &names).expect("a term");
            let at = [0.7, 1.3];
            for i in 0..2 {
                let exact = term.derivative(i).map_or(0.0, |d| d.eval(&at));
                let by = |h: f64| {
                    let mut z = at;
                    z[i] += h;
                    term.eval(&z)
                };
                let difference = (by(1e-6) - by(-1e-6)) / 2e-6;
                assert!((exact - difference).abs() < 1e-7, "{text} by {i}: {exact}, {difference}");
            }
        }
    }
}
