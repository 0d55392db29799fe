//! Our own library: one rule for every system.

use super::paper::with_roles;
use super::{Input, Role, Term};
use crate::expr::{Expr, Function};

/// Highest frequency of the waves.
const FREQUENCIES: usize = 3;

/// {1, a, a², ab, a²b, sin ka, cos ka} with a ≠ b and k = 1, 2, 3, over recognised coordinates and controls.
///
/// An angle that goes round enters through its sine and cosine alone, also where a product asks for it (ω²·sin θ,
/// cos θ·u); its squares are left to the second frequency (cos 2θ = 1 − 2 sin² θ), so that no term is a combination of
/// others. Over quantities that do not go round the rule holds every term of the paper's libraries.
///
/// With `next` the terms are to explain the next state itself, of which the angle is a part: then it is a term too.
pub(crate) fn auto(inputs: &[Input], next: bool) -> Vec<Term> {
    let turning: Vec<usize> = (0..inputs.len()).filter(|&i| inputs[i].role == Role::Turning).collect();
    let straight: Vec<usize> = (0..inputs.len()).filter(|&i| inputs[i].role != Role::Turning).collect();
    let mut terms = vec![Expr::Constant(1.0)];
    terms.extend(straight.iter().map(|&a| variable(a, 1)));
    terms.extend(turning.iter().filter(|_| next).map(|&t| variable(t, 1)));
    terms.extend(turning.iter().flat_map(|&t| waves(t, 1)));
    terms.extend(straight.iter().map(|&a| variable(a, 2)));
    terms.extend(turning.iter().flat_map(|&t| waves(t, 2)));
    for (at, &a) in straight.iter().enumerate() {
        terms.extend(straight[at + 1..].iter().map(|&b| variable(a, 1).times(variable(b, 1))));
        terms.extend(turning.iter().flat_map(|&t| waves(t, 1)).map(|w| variable(a, 1).times(w)));
    }
    for (at, &s) in turning.iter().enumerate() {
        for &t in &turning[at + 1..] {
            terms.extend(waves(s, 1).into_iter().flat_map(|a| waves(t, 1).map(|b| a.clone().times(b))));
        }
    }
    for &a in &straight {
        terms.extend(straight.iter().filter(|&&b| b != a).map(|&b| variable(a, 2).times(variable(b, 1))));
        terms.extend(turning.iter().flat_map(|&t| waves(t, 1)).map(|w| variable(a, 2).times(w)));
        terms.extend(turning.iter().flat_map(|&t| waves(t, 2)).map(|w| variable(a, 1).times(w)));
    }
    terms.extend(turning.iter().flat_map(|&t| waves(t, 3)));
    for k in 1..=FREQUENCIES {
        terms.extend(straight.iter().flat_map(|&a| waves(a, k)));
    }
    let names: Vec<String> = inputs.iter().map(|i| i.name.clone()).collect();
    let term =
        |expr: Expr| Term { name: expr.display(&names).to_string(), expr, complexity: 0, rate: None, shape: None };
    with_roles(terms.into_iter().map(term).collect(), inputs)
}

fn variable(i: usize, power: i32) -> Expr {
    Expr::Variable(i).to_power(power)
}

fn waves(i: usize, k: usize) -> [Expr; 2] {
    [Function::Sin, Function::Cos].map(|f| Expr::wave(f, k, Expr::Variable(i)))
}

#[cfg(test)]
mod tests {
    use super::super::paper;
    use super::*;

    #[test]
    fn turning_angles_enter_through_waves_only() {
        let inputs = [Input::new("θ", Role::Turning), Input::new("ω", Role::Rate), Input::new("u", Role::Control)];
        let names: Vec<_> = auto(&inputs, false).into_iter().map(|t| t.name).collect();
        for wanted in ["1", "ω", "sin(θ)", "cos(3*θ)", "ω^2*sin(θ)", "u*cos(θ)", "ω^2*u", "sin(ω)"] {
            assert!(names.iter().any(|n| n == wanted), "{wanted} is missing in {names:?}");
        }
        assert!(!names.iter().any(|n| n == "θ" || n == "θ^2"));
        for (i, name) in names.iter().enumerate() {
            assert!(!names[..i].contains(name), "{name} is listed twice");
        }
    }

    #[test]
    fn every_term_of_the_paper_is_there() {
        let inputs = ["x", "v", "u"].map(|n| Input::new(n, Role::Plain));
        let ours = auto(&inputs, false);
        for n_states in [2, 4] {
            for term in paper(&inputs, n_states) {
                assert!(ours.iter().any(|t| t.expr == term.expr), "{} is missing", term.name);
            }
        }
    }
}
