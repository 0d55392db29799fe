//! The candidate terms of a system about which nothing is known but the roles of its variables.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use super::{Extent, Input, Role, Term, complexity};
use crate::expr::{Expr, Function};

/// The complexity a derivative adds to the term it is multiplied by.
const OF_A_RATE: u32 = 3;

/// Highest frequency of waves of lengths.
const FREQUENCIES: usize = 3;

/// Candidate terms over the variables `inputs` (n + k), where `rates` has the state that is the rate of each state, if one is (n), and whose values on all data are
/// those of `extents`.
///
/// With a, b straight variables (no angles), q, r rates, w waves (sine and cosine of angles, of twice an angle, of sums and
/// differences of two):
///
/// - 1, a, a², a³, a b, a² b, and a b u of an input u: polynomials up to degree three,
/// - a·|a| and sign a of states, drag and dry friction; u·|u| of inputs of both signs, propellers; of states that stay positive √a, a·ln a, growth by Gompertz, and sign a only if
///   they are rates,
/// - u·√a of inputs u and states a that stay positive, valves; sign(a − b)·√|a − b| of states that are neither angles nor rates and have values in common, tanks
///   that are joined,
/// - w, a·w, a²·w, q r·w with simple waves; angles themselves: torsion springs,
/// - tan u, v·tan u of a state or another input, and an input that stays within ±π/2: steering; sin u of one in radians: tilt,
/// - v̇, v̇·w for the derivative of every rate: the entries of a mass matrix,
/// - a·ḃ of states that are neither angles nor rates: ratios with denominators such as 1 + a, multiplied by these,
/// - sin ka, cos ka, k = 1, 2, 3, of states that are neither angles nor rates, and that have a rate, and may turn, or go through half a period or more: less of a wave is a
///   parabola.
pub(crate) fn general(inputs: &[Input], rates: &[Option<usize>], extents: &[Extent]) -> Vec<Term> {
    let of = |wanted: fn(Role) -> bool| (0..inputs.len()).filter(move |&i| wanted(inputs[i].role)).collect::<Vec<_>>();
    let angles = of(|r| matches!(r, Role::Angle | Role::Turning));
    let straight = of(|r| !matches!(r, Role::Angle | Role::Turning));
    let states = of(|r| matches!(r, Role::Plain | Role::Rate));
    let (lengths, controls) = (of(|r| r == Role::Plain), of(|r| r == Role::Control));
    let speeds: Vec<usize> = of(|r| r == Role::Rate);
    let of_states: BTreeSet<usize> = rates.iter().flatten().copied().collect();
    let mut terms = Terms::new(inputs);
    terms.add(Expr::Constant(1.0), None);
    for power in 1..=3 {
        straight.iter().for_each(|&a| terms.add(variable(a).to_power(power), None));
    }
    for (a, b) in pairs(&straight) {
        terms.add(variable(a).times(variable(b)), None);
    }
    for &a in &straight {
        straight.iter().filter(|&&b| b != a).for_each(|&b| terms.add(variable(a).to_power(2).times(variable(b)), None));
    }
    for &a in &states {
        terms.add(variable(a).times(call(Function::Abs, variable(a))), None);
        let positive = extents[a].low > 0.0;
        if inputs[a].role == Role::Rate || !positive {
            terms.add(call(Function::Sign, variable(a)), None);
        }
        if positive {
            let root = call(Function::Sqrt, variable(a));
            terms.add(root.clone(), None);
            terms.add(variable(a).times(call(Function::Log, variable(a))), None);
            controls.iter().for_each(|&u| terms.add(variable(u).times(root.clone()), None));
        }
    }
    let both = |u: &&usize| extents[**u].low < 0.0 && extents[**u].high > 0.0;
    for &u in controls.iter().filter(both) {
        terms.add(variable(u).times(call(Function::Abs, variable(u))), None);
    }
    for (a, b) in pairs(&states) {
        controls.iter().for_each(|&u| terms.add(variable(a).times(variable(b)).times(variable(u)), None));
    }
    let meet = |&(a, b): &(usize, usize)| extents[a].low < extents[b].high && extents[b].low < extents[a].high;
    for (a, b) in pairs(&lengths).into_iter().filter(meet) {
        let difference = Expr::Sub(Box::new(variable(a)), Box::new(variable(b)));
        let root = call(Function::Sqrt, call(Function::Abs, difference.clone()));
        terms.add(call(Function::Sign, difference).times(root), None);
    }
    let single: Vec<Expr> = angles.iter().flat_map(|&a| waves(variable(a))).collect();
    let twice = angles.iter().flat_map(|&a| [Function::Sin, Function::Cos].map(|f| Expr::wave(f, 2, variable(a))));
    let sums = pairs(&angles).into_iter().flat_map(|(a, b)| {
        let (a, b) = (Box::new(variable(a)), Box::new(variable(b)));
        [Expr::Add(a.clone(), b.clone()), Expr::Sub(a, b)].into_iter().flat_map(waves)
    });
    let all: Vec<Expr> = single.iter().cloned().chain(twice).chain(sums).collect();
    angles.iter().filter(|&&a| inputs[a].role == Role::Angle).for_each(|&a| terms.add(variable(a), None));
    for wave in &all {
        terms.add(wave.clone(), None);
        for product in squares_and_products(&speeds) {
            terms.add(product.times(wave.clone()), None);
        }
    }
    for wave in &single {
        for &a in &straight {
            terms.add(variable(a).times(wave.clone()), None);
            terms.add(variable(a).to_power(2).times(wave.clone()), None);
        }
    }
    for &u in controls.iter().filter(|&&u| -FRAC_PI_2 < extents[u].low && extents[u].high < FRAC_PI_2) {
        terms.add(call(Function::Tan, variable(u)), None);
        let others = controls.iter().filter(|&&v| v != u);
        for &v in states.iter().chain(others) {
            terms.add(variable(v).times(call(Function::Tan, variable(u))), None);
        }
    }
    for &u in controls.iter().filter(|&&u| inputs[u].in_radians) {
        terms.add(call(Function::Sin, variable(u)), None);
    }
    if !angles.is_empty() {
        for &l in &of_states {
            terms.add(Expr::Constant(1.0), Some(l));
            all.iter().for_each(|wave| terms.add(wave.clone(), Some(l)));
        }
    }
    // Ratios with denominators 1 + x: equations of states that are no rates, multiplied by theirs.
    for &l in lengths.iter().filter(|l| !of_states.contains(l)) {
        lengths.iter().for_each(|&a| terms.add(variable(a), Some(l)));
    }
    for k in 1..=FREQUENCIES {
        lengths.iter().filter(|&&a| rates[a].is_some() || extents[a].turns(k as f64)).for_each(|&a| {
            [Function::Sin, Function::Cos].into_iter().for_each(|f| terms.add(Expr::wave(f, k, variable(a)), None));
        });
    }
    terms.terms
}

/// Terms as they are gathered, each once.
struct Terms {
    roles: Vec<Role>,
    names: Vec<String>,
    terms: Vec<Term>,
}

impl Terms {
    fn new(inputs: &[Input]) -> Self {
        Self {
            roles: inputs.iter().map(|i| i.role).collect(),
            names: inputs.iter().map(|i| i.name.clone()).collect(),
            terms: Vec::new(),
        }
    }

    fn add(&mut self, expr: Expr, rate: Option<usize>) {
        if self.terms.iter().any(|t| t.rate == rate && t.expr == expr) {
            return;
        }
        let text = expr.display(&self.names).to_string();
        let (name, complexity) = match rate {
            None => (text, complexity(&expr, &self.roles)),
            Some(l) if expr.is_one() => (format!("d{}/dt", self.names[l]), OF_A_RATE),
            Some(l) => (format!("d{}/dt*{text}", self.names[l]), OF_A_RATE + complexity(&expr, &self.roles)),
        };
        self.terms.push(Term { expr, name, complexity, rate, shape: None });
    }
}

fn variable(i: usize) -> Expr {
    Expr::Variable(i)
}

fn call(f: Function, a: Expr) -> Expr {
    Expr::Call(f, Box::new(a))
}

fn waves(a: Expr) -> [Expr; 2] {
    [call(Function::Sin, a.clone()), call(Function::Cos, a)]
}

fn pairs(of: &[usize]) -> Vec<(usize, usize)> {
    of.iter().enumerate().flat_map(|(at, &a)| of[at + 1..].iter().map(move |&b| (a, b))).collect()
}

pub(super) fn squares_and_products(of: &[usize]) -> Vec<Expr> {
    let squares = of.iter().map(|&a| variable(a).to_power(2));
    squares.chain(pairs(of).into_iter().map(|(a, b)| variable(a).times(variable(b)))).collect()
}
