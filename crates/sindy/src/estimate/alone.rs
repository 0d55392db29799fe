//! Parts of a system that need none of its other states: what these do wrong cannot spoil them.

use std::cell::Cell;

use ndarray::Axis;

use super::account::{Doubt, Estimate};
use super::problem::{Alone, Problem, Separate};
use super::search::accounted;
use crate::Expr;
use crate::data::Segment;
use crate::library::Term;
use crate::motion::Stepping;

/// Part of the budget of a search for each part of a system.
const SHARE: f64 = 0.05;

/// Times that parts are looked for beside those already found.
const PASSES: usize = 2;

impl Estimate {
    /// The same where equations that no terms explain leave others as they were found without them: the states are fitted to all equations, and follow those that are wrong, too. That the terms of such a state may seem
    /// as good is no doubt, either.
    pub(super) fn with_separate(&mut self, alone: &[Alone]) {
        let unexplained: Vec<usize> =
            (0..self.doubts.len()).filter(|&i| self.doubts[i].is_some_and(Doubt::is_spoilt)).collect();
        for (i, alone) in alone.iter().enumerate() {
            let Some(alone) = alone.as_ref().filter(|alone| alone.support == self.fits[i].support) else { continue };
            let terms = &self.terms;
            let has =
                |j: usize| unexplained.iter().any(|&s| s != i && (terms[j].expr.has(s) || terms[j].rate == Some(s)));
            let fit = &mut self.fits[i];
            fit.ties.retain(|tie| !tie.iter().any(|&j| has(j)));
            if fit.ties.is_empty() && unexplained.iter().any(|&s| s != i) {
                fit.coefficients.clone_from(&alone.coefficients);
                fit.residual = alone.residual;
                fit.reached_floor = true;
                self.errors[i].clone_from(&alone.errors);
                self.doubts[i] = None;
            }
        }
    }
}

impl Problem<'_> {
    /// Per state: its equation, if it is adequate in a part of the system that has no other states, without terms that have parameters inside. Empty if there is none.
    pub(super) fn alone(&self, stepping: Stepping) -> Vec<Alone> {
        let n = self.rates.len();
        let chains = self.chains();
        let mut found: Vec<Alone> = vec![None; n];
        let mut known: Vec<usize> = Vec::new();
        if self.constraints.iter().any(|c| !c.is_empty()) {
            return Vec::new();
        }
        for _ in 0..PASSES {
            let before = known.len();
            for chain in &chains {
                let states = [&known[..], chain].concat();
                if known.contains(&chain[0]) || states.len() == n || !self.watch.go_on() {
                    continue;
                }
                if let Some(equations) = self.of_states(&states, &found, stepping) {
                    states.iter().zip(equations).for_each(|(&i, equation)| found[i] = equation);
                    known = states;
                }
            }
            if known.len() == before {
                break;
            }
        }
        if known.is_empty() { Vec::new() } else { found }
    }

    /// Each state with its rate, the rate of that, and so on.
    fn chains(&self) -> Vec<Vec<usize>> {
        let n = self.rates.len();
        let heads = (0..n).filter(|i| !self.rates.contains(&Some(*i)));
        heads.map(|head| std::iter::successors(Some(head), |&i| self.rates[i]).take(n).collect()).collect()
    }

    /// The equations of `states` without the others; `None` if they are not adequate.
    fn of_states(&self, states: &[usize], known: &[Alone], stepping: Stepping) -> Option<Vec<Alone>> {
        let n = self.rates.len();
        let place = |i: usize| match i {
            i if i < n => states.iter().position(|&k| k == i),
            i => Some(states.len() + i - n),
        };
        let others: Vec<usize> = (0..n).filter(|i| !states.contains(i)).collect();
        let inside = |t: &Term| {
            !others.iter().any(|&i| t.expr.has(i)) && t.rate.is_none_or(|l| states.contains(&l)) && t.shape.is_none()
        };
        let chosen: Vec<usize> = (0..self.terms.len()).filter(|&j| inside(&self.terms[j])).collect();
        let placed = |&j: &usize| {
            let term = &self.terms[j];
            Term {
                expr: term.expr.replaced(&|i| place(i).map(Expr::Variable)),
                rate: term.rate.and_then(place),
                ..term.clone()
            }
        };
        let terms: Vec<Term> = chosen.iter().map(placed).collect();
        let of = |s: &Segment| Segment {
            x: s.x.select(Axis(1), states),
            relative: s.relative.as_ref().map(|r| r.select(Axis(1), states)),
            ..s.clone()
        };
        let segments: Vec<Segment> = self.segments.iter().map(of).collect();
        let rates: Vec<Option<usize>> = states.iter().map(|&i| self.rates[i].and_then(place)).collect();
        let floor: Vec<f64> = states.iter().map(|&i| self.floor[i]).collect();
        let back = |j: usize| chosen.iter().position(|&k| k == j);
        let told = |&i: &usize| -> Alone {
            let known = known[i].as_ref()?;
            let support = known.support.iter().map(|&j| back(j)).collect::<Option<_>>()?;
            Some(Separate { support, ..known.clone() })
        };
        let known: Vec<Alone> = states.iter().map(told).collect();
        let spent = Cell::new(0);
        let part = Problem {
            terms: &terms,
            n_plain: chosen.iter().filter(|&&j| j < self.n_plain).count(),
            of_parts: None,
            instead: None,
            mechanics: &[],
            rates: &rates,
            constraints: &[],
            segments: &segments,
            floor: &floor,
            alone: &known,
            budget: (SHARE * self.budget as f64) as u64,
            spent: &spent,
            ..*self
        };
        let found = accounted(&part, (None, None), stepping)?.found;
        if found.doubts.iter().any(Option::is_some) || found.stepping.is_continuous() != stepping.is_continuous() {
            return None;
        }
        let equation = |(k, fit): (usize, &crate::solve::Selected)| -> Alone {
            rates[k].is_none().then(|| Separate {
                support: fit.support.iter().map(|&j| chosen[j]).collect(),
                coefficients: fit.coefficients.clone(),
                errors: found.errors[k].clone(),
                residual: fit.residual,
            })
        };
        Some(found.fits.iter().enumerate().map(equation).collect())
    }
}
