//! How far-fetched a term is.

use super::Role;
use crate::expr::{Expr, Function};

/// What the modulus of a control costs more.
const RARE: u32 = 6;

/// The complexity of `expr`; factors add up.
///
/// Powers count their degree and the sine or cosine of an angle its frequency, all times two. A power of an angle is
/// dearer than its sine by one, because an equation of motion must not change when the angle goes round once
/// (θ̇² sin θ, not θ̇² θ). Waves of lengths are rarer, and those of rates and controls hardly ever mean anything. A modulus
/// counts one, so that v² is meant where v·|v| is the same, that of a control more, since propellers are rarer than cubes, and a positive part what its argument does; other functions count one factor.
pub(crate) fn complexity(expr: &Expr, roles: &[Role]) -> u32 {
    match expr {
        Expr::Constant(_) => 2,
        Expr::Variable(i) => match roles.get(*i) {
            Some(Role::Angle | Role::Turning) => 3,
            _ => 2,
        },
        Expr::Mul(a, b) => match (&**a, &**b) {
            (Expr::Constant(_), other) | (other, Expr::Constant(_)) => complexity(other, roles),
            _ => complexity(a, roles) + complexity(b, roles),
        },
        Expr::Power(a, n) => complexity(a, roles).saturating_mul(n.unsigned_abs()),
        Expr::Call(Function::Sin | Function::Cos, argument) => wave(argument, roles),
        Expr::Call(Function::Abs, argument) => {
            let is_control = matches!(**argument, Expr::Variable(i) if roles.get(i) == Some(&Role::Control));
            1 + complexity(argument, roles) + if is_control { RARE } else { 0 }
        }
        Expr::Call(Function::PositivePart, argument) => complexity(argument, roles),
        Expr::Call(_, argument) => 2 + complexity(argument, roles),
        Expr::Neg(a) => complexity(a, roles),
        Expr::Add(a, b) | Expr::Sub(a, b) => complexity(a, roles) + complexity(b, roles),
        Expr::Div(a, b) => complexity(a, roles) + complexity(b, roles) + 2,
    }
}

/// The complexity of the sine or cosine of `argument`.
fn wave(argument: &Expr, roles: &[Role]) -> u32 {
    let (frequency, inner) = match argument {
        Expr::Mul(k, inner) => match **k {
            Expr::Constant(k) => (k.abs().round().max(1.0) as u32, &**inner),
            _ => (1, argument),
        },
        _ => (1, argument),
    };
    let Expr::Variable(i) = inner else { return 2 * frequency + complexity(inner, roles) };
    let rarity = match roles.get(*i) {
        Some(Role::Angle | Role::Turning) => 0,
        Some(Role::Plain) | None => 2,
        Some(Role::Rate | Role::Control) => 8,
    };
    2 * frequency + rarity
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;

    #[test]
    fn simple_terms_come_before_far_fetched_ones() {
        let names: Vec<_> = ["θ", "x", "v", "u"].map(String::from).into();
        let roles = [Role::Angle, Role::Plain, Role::Rate, Role::Control];
        let cost = |text| complexity(&parse(text, &names).expect("a term"), &roles);
        let ladder =
            ["1", "v", "sin(θ)", "θ", "v^2", "sin(x)", "v^2*sin(θ)", "v^2*θ", "cos(3*x)", "sin(v)", "cos(3*u)"];
        for pair in ladder.windows(2) {
            assert!(cost(pair[0]) <= cost(pair[1]), "{} is dearer than {}", pair[0], pair[1]);
        }
        assert!(cost("sin(θ)") < cost("θ"));
    }
}
