//! Candidate terms with a variable below: forces over a mass, flows over a volume, speeds over a length.

use super::general::squares_and_products;
use super::{Extent, Input, Role, Term, complexity};
use crate::expr::{Expr, Function};

/// Quotients θ/d by every straight variable d (no angle) of `inputs` (n + k) whose values have one sign, as `extents` tells, and in which no d cancels. `rates` has the
/// state that is the rate of each state, if one is (n):
///
/// - 1/d, a/d, a b/d of straight variables a, b other than d,
/// - w/d of waves w, the sine and cosine of angles and of other states that have a rate,
/// - 1/d², a/d².
pub(crate) fn quotients(inputs: &[Input], rates: &[Option<usize>], extents: &[Extent]) -> Vec<Term> {
    let (angles, straight): (Vec<usize>, Vec<usize>) =
        (0..inputs.len()).partition(|&i| matches!(inputs[i].role, Role::Angle | Role::Turning));
    let roles: Vec<Role> = inputs.iter().map(|i| i.role).collect();
    let names: Vec<String> = inputs.iter().map(|i| i.name.clone()).collect();
    let of = |expr: Expr| {
        let (name, complexity) = (expr.display(&names).to_string(), complexity(&expr, &roles));
        Term { expr, name, complexity, rate: None, shape: None }
    };
    let turning = straight.iter().filter(|&&a| inputs[a].role == Role::Plain && rates[a].is_some());
    let of_angle = |&a: &usize| [Function::Sin, Function::Cos].map(|f| Expr::wave(f, 1, Expr::Variable(a)));
    let waves: Vec<Expr> = angles.iter().chain(turning).flat_map(of_angle).collect();
    let mut terms = Vec::new();
    for &d in straight.iter().filter(|&&d| extents[d].low > 0.0 || extents[d].high < 0.0) {
        let others: Vec<usize> = straight.iter().copied().filter(|&a| a != d).collect();
        let single: Vec<Expr> =
            std::iter::once(Expr::Constant(1.0)).chain(others.iter().map(|&a| Expr::Variable(a))).collect();
        let products = squares_and_products(&others);
        let over =
            |power: i32| move |above: Expr| of(Expr::Div(Box::new(above), Box::new(Expr::Variable(d).to_power(power))));
        terms.extend(single.iter().cloned().chain(products).chain(waves.iter().cloned()).map(over(1)));
        terms.extend(single.into_iter().map(over(2)));
    }
    terms
}

/// The variable below in a term of [`quotients`].
pub(crate) fn divisor(term: &Term) -> Option<usize> {
    match &term.expr {
        Expr::Div(_, below) => below.max_variable(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_one_sign_divides_and_nothing_cancels() {
        let inputs = [Input::new("v", Role::Rate), Input::new("m", Role::Plain), Input::new("F", Role::Control)];
        let extents = [Extent::of(&[-1.0, 1.0]), Extent::of(&[2.0, 3.0]), Extent::of(&[0.0, 5.0])];
        let terms = quotients(&inputs, &[None; 2], &extents);
        let names: Vec<String> = terms.iter().map(|t| t.name.replace(' ', "")).collect();
        assert_eq!(
            names,
            ["1/m", "v/m", "F/m", "v^2/m", "F^2/m", "v*F/m", "1/m^2", "v/m^2", "F/m^2"].map(String::from)
        );
        assert!(terms.iter().all(|t| divisor(t) == Some(1)));
    }
}
