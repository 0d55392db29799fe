//! The libraries of the paper, by rule.

use super::{Input, Library, Term, complexity};
use crate::expr::Expr;

/// States from which the paper uses products of states instead of waves.
const MANY_STATES: usize = 4;

/// Highest frequency of the paper's waves.
const FREQUENCIES: usize = 3;

/// The paper's terms over z = (x; u), of which the first `n_states` are states.
///
/// - Four states or more: {1, a, a², ab, a²b} with a ≠ b, 41 terms over 5 variables (P = 4 × 41 = 164).
/// - Fewer: {1, a, a², sin ka, cos ka} with k = 1, 2, 3, 25 terms over 3 variables (P = 2 × 25 = 50) and 33 over 4
///   (P = 3 × 33 = 99).
///
/// # References
/// Arora, da Silva, Moss (2022), §4 and table 1. The text lists states only; its P counts the control too.
pub(crate) fn paper(inputs: &[Input], n_states: usize) -> Vec<Term> {
    let names = names(inputs);
    if n_states >= MANY_STATES {
        return with_roles(products(&names), inputs);
    }
    let squares = Library::Polynomial { degree: 2, interaction: false, bias: true };
    from_library(&squares.plus(Library::fourier(FREQUENCIES)), inputs)
}

/// Another reading of the paper's 33 terms for the pendulum: all products up to degree 2 of states and control (15 over
/// 4 variables), and waves of the states alone (18 of 3).
pub(crate) fn paper_degree2(inputs: &[Input], n_states: usize) -> Vec<Term> {
    let states: Vec<usize> = (0..n_states).collect();
    from_library(&Library::polynomial(2).plus(Library::fourier(FREQUENCIES).of(&states)), inputs)
}

fn names(inputs: &[Input]) -> Vec<String> {
    inputs.iter().map(|i| i.name.clone()).collect()
}

fn from_library(library: &Library, inputs: &[Input]) -> Vec<Term> {
    with_roles(library.terms(&names(inputs)).expect("polynomials and waves are never empty or too many"), inputs)
}

/// {1, a, a², ab, a²b}, a ≠ b.
fn products(names: &[String]) -> Vec<Term> {
    let n = names.len();
    let mut factors = vec![vec![]];
    factors.extend((0..n).map(|a| vec![(a, 1)]));
    factors.extend((0..n).map(|a| vec![(a, 2)]));
    factors.extend((0..n).flat_map(|a| (a + 1..n).map(move |b| vec![(a, 1), (b, 1)])));
    factors.extend((0..n).flat_map(|a| (0..n).filter(move |&b| b != a).map(move |b| vec![(a, 2), (b, 1)])));
    factors.into_iter().map(|f| product(&f, names)).collect()
}

fn product(factors: &[(usize, i32)], names: &[String]) -> Term {
    let power = |&(i, n): &(usize, i32)| if n == 1 { names[i].clone() } else { format!("{}^{n}", names[i]) };
    let name = factors.iter().map(power).collect::<Vec<_>>().join(" ");
    let factors = factors.iter().map(|&(i, n)| Expr::Variable(i).to_power(n));
    let expr = factors.fold(Expr::Constant(1.0), Expr::times);
    Term { expr, name: if name.is_empty() { "1".into() } else { name }, complexity: 0, rate: None, shape: None }
}

/// The same terms with the complexity their variables' roles give them.
pub(super) fn with_roles(mut terms: Vec<Term>, inputs: &[Input]) -> Vec<Term> {
    let roles: Vec<_> = inputs.iter().map(|i| i.role).collect();
    for term in &mut terms {
        term.complexity = complexity(&term.expr, &roles);
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::Role;

    fn inputs(names: &[&str]) -> Vec<Input> {
        names.iter().map(|n| Input::new(n, Role::Plain)).collect()
    }

    #[test]
    fn sizes_are_those_of_the_papers_table() {
        let cart_pole = paper(&inputs(&["x", "v", "θ", "ω", "F"]), 4);
        assert_eq!(4 * cart_pole.len(), 164);
        let mountain_car = paper(&inputs(&["x", "v", "u"]), 2);
        assert_eq!(2 * mountain_car.len(), 50);
        let seen = inputs(&["c", "s", "ω", "u"]);
        assert_eq!(3 * paper(&seen, 3).len(), 99);
        assert_eq!(3 * paper_degree2(&seen, 3).len(), 99);
    }

    #[test]
    fn products_are_listed_by_kind() {
        let names: Vec<_> = paper(&inputs(&["a", "b", "c", "d"]), 4).into_iter().map(|t| t.name).collect();
        assert_eq!(names[..6], ["1", "a", "b", "c", "d", "a^2"]);
        assert_eq!(names[9..11], ["a b", "a c"]);
        assert_eq!(names[15..17], ["a^2 b", "a^2 c"]);
        assert_eq!(names.last().map(String::as_str), Some("d^2 c"));
    }
}
