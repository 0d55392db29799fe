//! Terms of mechanics: what the equations of jointed bodies are made of, before they are solved for accelerations.

use super::auto::auto;
use super::{Input, Role, Term, complexity};
use crate::expr::{Expr, Function};

/// The complexity a derivative adds to the term it is multiplied by.
const OF_A_RATE: u32 = 3;

/// Candidate terms in two tiers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tiers {
    pub(crate) terms: Vec<Term>,
    /// How many of them, the first ones, are tried before the others.
    pub(crate) core: usize,
}

impl Tiers {
    /// All `terms` in the first tier.
    pub(crate) fn flat(terms: Vec<Term>) -> Self {
        Self { core: terms.len(), terms }
    }
}

/// The terms of [`auto`], and for jointed bodies those of Lagrange's equations before they are solved for accelerations.
///
/// Where angles are declared, the first tier is, with w = sin, cos of an angle, of twice an angle, of the sum and the
/// difference of two, and rates q, r:
///
/// - 1, w, lengths and other states that are no rates: weights and springs,
/// - q: friction; u, u·w: controls, and forces along axes that turn with a body,
/// - q r·w: centrifugal and Coriolis forces,
/// - v̇, w·v̇ for the derivative v̇ of every rate: the entries of a mass matrix. The equations are linear in their coefficients
///   where solved for the accelerations they would be ratios.
///
/// Without angles it is {1, a, a², ab, a²b} and sin ka, cos ka, k = 1, 2, 3, of states that are no rates. The second tier
/// adds q·w, q² and all of [`auto`]. `rates` are the states that are declared to be rates.
pub(crate) fn mechanical(inputs: &[Input], rates: &[usize]) -> Tiers {
    let of = |wanted: fn(Role) -> bool| (0..inputs.len()).filter(move |&i| wanted(inputs[i].role)).collect::<Vec<_>>();
    let angles = of(|r| matches!(r, Role::Angle | Role::Turning));
    let (lengths, speeds, controls) = (of(|r| r == Role::Plain), of(|r| r == Role::Rate), of(|r| r == Role::Control));
    let single: Vec<Expr> = angles.iter().flat_map(|&a| waves(Expr::Variable(a))).collect();
    let twice =
        angles.iter().flat_map(|&a| [Function::Sin, Function::Cos].map(|f| Expr::wave(f, 2, Expr::Variable(a))));
    let pairs = pairs(&angles).into_iter().flat_map(|(a, b)| between(a, b));
    let all_waves: Vec<Expr> = single.iter().cloned().chain(twice).chain(pairs).collect();

    let mut terms = Terms { inputs, terms: Vec::new() };
    if angles.is_empty() {
        for term in auto(inputs, false) {
            let is_wave = matches!(term.expr, Expr::Call(..));
            if !is_wave || term.expr.max_variable().is_some_and(|i| inputs[i].role == Role::Plain) {
                terms.add(term.expr, None);
            }
        }
    } else {
        terms.add(Expr::Constant(1.0), None);
        for &i in lengths.iter().chain(&speeds).chain(&controls) {
            terms.add(Expr::Variable(i), None);
        }
        for wave in &all_waves {
            terms.add(wave.clone(), None);
            for product in products(&speeds) {
                terms.add(product.times(wave.clone()), None);
            }
        }
        for wave in &single {
            controls.iter().for_each(|&u| terms.add(Expr::Variable(u).times(wave.clone()), None));
        }
        for &l in rates {
            terms.add(Expr::Constant(1.0), Some(l));
            for wave in &all_waves {
                terms.add(wave.clone(), Some(l));
            }
        }
    }
    let core = terms.terms.len();
    for term in auto(inputs, false) {
        terms.add(term.expr, None);
    }
    for wave in &single {
        for &i in lengths.iter().chain(&speeds).chain(&controls) {
            terms.add(Expr::Variable(i).times(wave.clone()), None);
        }
    }
    Tiers { terms: terms.terms, core }
}

/// Terms as they are gathered, each once.
struct Terms<'a> {
    inputs: &'a [Input],
    terms: Vec<Term>,
}

impl Terms<'_> {
    fn add(&mut self, expr: Expr, rate: Option<usize>) {
        if self.terms.iter().any(|t| t.rate == rate && t.expr == expr) {
            return;
        }
        self.terms.push(term(self.inputs, expr, rate));
    }
}

/// `expr` times the derivative of the state `rate`, if there is one.
pub(crate) fn term(inputs: &[Input], expr: Expr, rate: Option<usize>) -> Term {
    let names: Vec<String> = inputs.iter().map(|i| i.name.clone()).collect();
    let roles: Vec<Role> = inputs.iter().map(|i| i.role).collect();
    let (name, complexity) = match rate {
        None => (expr.display(&names).to_string(), complexity(&expr, &roles)),
        Some(l) if expr.is_one() => (format!("d{}/dt", names[l]), OF_A_RATE),
        Some(l) => (format!("d{}/dt*{}", names[l], expr.display(&names)), OF_A_RATE + complexity(&expr, &roles)),
    };
    Term { expr, name, complexity, rate, shape: None }
}

fn waves(a: Expr) -> [Expr; 2] {
    [Function::Sin, Function::Cos].map(|f| Expr::Call(f, Box::new(a.clone())))
}

/// Waves of the sum and the difference of two angles.
fn between(a: usize, b: usize) -> Vec<Expr> {
    let [a, b] = [a, b].map(|i| Box::new(Expr::Variable(i)));
    let sum = Expr::Add(a.clone(), b.clone());
    [sum, Expr::Sub(a, b)].into_iter().flat_map(waves).collect()
}

fn pairs(of: &[usize]) -> Vec<(usize, usize)> {
    of.iter().enumerate().flat_map(|(at, &a)| of[at + 1..].iter().map(move |&b| (a, b))).collect()
}

/// q² and q r.
fn products(of: &[usize]) -> Vec<Expr> {
    let squares = of.iter().map(|&a| Expr::Variable(a).to_power(2));
    squares.chain(pairs(of).into_iter().map(|(a, b)| Expr::Variable(a).times(Expr::Variable(b)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cart_poles_equations_can_be_written() {
        let roles = [Role::Plain, Role::Rate, Role::Angle, Role::Rate, Role::Control];
        let inputs: Vec<Input> = ["x", "v", "θ", "ω", "F"].iter().zip(roles).map(|(n, r)| Input::new(n, r)).collect();
        let Tiers { terms, core } = mechanical(&inputs, &[1, 3]);
        let names: Vec<&str> = terms[..core].iter().map(|t| t.name.as_str()).collect();
        for wanted in ["F", "ω^2*sin(θ)", "dω/dt*cos(θ)", "sin(θ)", "dv/dt*cos(θ)", "ω^2*cos(θ)", "v", "dv/dt*sin(θ)"]
        {
            assert!(names.contains(&wanted), "{wanted} is missing in {names:?}");
        }
        for (i, name) in names.iter().enumerate() {
            assert!(!names[..i].contains(name), "{name} is listed twice");
        }
    }
}
