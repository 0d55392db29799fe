//! Terms in the notation of NumPy.

use crate::expr::{Expr, Function, Tie};

/// `expr` over the variables `names`, in parentheses if it is looser than `at_least`.
pub(super) fn numpy(expr: &Expr, names: &[String], at_least: Tie) -> String {
    let part = |e: &Expr, tie| numpy(e, names, tie);
    let code = match expr {
        Expr::Add(a, b) => format!("{} + {}", part(a, Tie::Sum), part(b, Tie::Product)),
        Expr::Sub(a, b) => format!("{} - {}", part(a, Tie::Sum), part(b, Tie::Product)),
        Expr::Mul(a, b) => format!("{} * {}", part(a, Tie::Product), part(b, Tie::Sign)),
        Expr::Div(a, b) => format!("{} / {}", part(a, Tie::Product), part(b, Tie::Sign)),
        Expr::Neg(a) => format!("-{}", part(a, Tie::Power)),
        Expr::Power(a, n) => format!("{}**{n}", part(a, Tie::Atom)),
        Expr::Call(function, a) => {
            let name = match function {
                Function::PositivePart => "maximum",
                Function::Atan => "arctan",
                other => other.name(),
            };
            format!("np.{name}({}{})", part(a, Tie::Sum), function.rest())
        }
        Expr::Constant(c) => number(*c),
        Expr::Variable(i) => names[*i].clone(),
    };
    if Tie::of(expr) < at_least { format!("({code})") } else { code }
}

/// Marks the variables that `expr` holds.
pub(super) fn mark_variables(expr: &Expr, used: &mut [bool]) {
    match expr {
        Expr::Constant(_) => {}
        Expr::Variable(i) => used[*i] = true,
        Expr::Neg(a) | Expr::Power(a, _) | Expr::Call(_, a) => mark_variables(a, used),
        Expr::Add(a, b) | Expr::Sub(a, b) | Expr::Mul(a, b) | Expr::Div(a, b) => {
            mark_variables(a, used);
            mark_variables(b, used);
        }
    }
}

/// Every digit of `value`; Rust and Python read the same decimals.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;

    #[test]
    fn parentheses_stand_where_python_needs_them() {
        let names = ["x".to_owned(), "v".to_owned()];
        for (term, code) in [
            ("v^2*sin(3*x)", "v**2 * np.sin(3.0 * x)"),
            ("-x^2", "-x**2"),
            ("(-x)^2", "(-x)**2"),
            ("(-2)^3", "(-2.0)**3"),
            ("x/(v*x)", "x / (v * x)"),
            ("x-(v-x)", "x - (v - x)"),
            ("x*(-v)", "x * -v"),
            ("(x*v)^-1", "(x * v)**-1"),
            ("-(x*v)", "-(x * v)"),
            ("1e-9*sign(x)", "1e-9 * np.sign(x)"),
            ("max(x-v, 0)", "np.maximum(x - v, 0)"),
        ] {
            let parsed = parse(term, &names).expect("a term");
            assert_eq!(numpy(&parsed, &names, Tie::Sum), code, "{term}");
        }
    }
}
