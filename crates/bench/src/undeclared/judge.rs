//! What found equations are worth.

use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use sindyna_core::Seed;

use super::generate::generate;
use super::system::System;
use crate::equations::{Equations, Term};
use crate::points::{Points, Structure};

/// Points of the box.
const POINTS: usize = 500;

/// Recordings whose range of states is the box.
const RECORDINGS: usize = 10;

/// Deviation of the rates beyond which equations are wrong whatever their terms: identities that do not determine the motion.
const NOTHING_LIKE: f64 = 0.5;

/// Judges equations of one system.
///
/// Points are drawn uniformly from the range of the states in clean recordings and from the range of the inputs. An equation is
/// right if the true rates satisfy it with exactly one set of coefficients, none of them zero, and, where the true equations are
/// explicit, if it has no more terms than the true one. Implicit equations of motion can be written in several ways, and each
/// counts.
pub struct Judge {
    states: Vec<String>,
    variables: Vec<String>,
    points: Points,
    truth: Vec<Vec<Term>>,
    compiled: Equations,
    judged: Vec<usize>,
    bounds: Vec<(f64, f64)>,
}

/// One equation against the true one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The state whose rate it is.
    pub state: String,
    /// Terms found, with their coefficients.
    pub found: Vec<(String, f64)>,
    /// True terms, with theirs.
    pub truth: Vec<(String, f64)>,
    /// Whether the terms are the true ones.
    pub right: bool,
    /// True terms that were not found.
    pub missing: Vec<String>,
    /// Terms found that are not true.
    pub spurious: Vec<String>,
    /// Largest |found/true − 1| of a coefficient; none unless right.
    pub coefficient_error: Option<f64>,
    /// (found − true)/standard error of each coefficient; none unless right and told by the method.
    pub standardised: Option<Vec<f64>>,
}

/// All judged equations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Whether every equation is right.
    pub right: bool,
    /// Largest relative error of a coefficient; none unless right.
    pub coefficient_error: Option<f64>,
    /// RMS error of the rates over the box, as part of their spread, in the worst equation; none where it is not finite.
    pub deviation: Option<f64>,
    /// The equations, but for those that only say that a state is the rate of another.
    pub equations: Vec<Judged>,
}

/// Part of its true value by which a parameter inside a term may be off for the term to count as the true one.
const OFF: f64 = 0.3;

/// A term without spaces, brackets and the numbers that are not powers, and these numbers.
fn family(text: &str) -> (String, Vec<f64>) {
    let (mut family, mut numbers, mut number) = (String::new(), Vec::new(), String::new());
    let mut before = ' ';
    for c in text.chars().filter(|c| *c != ' ').chain([' ']) {
        let goes_on = !number.is_empty() || !(before.is_alphanumeric() || before == '^' || before == '_');
        if (c.is_ascii_digit() || c == '.') && goes_on {
            number.push(c);
            continue;
        }
        numbers.extend(number.parse::<f64>().ok());
        number.clear();
        before = c;
        if !"() ".contains(c) {
            family.push(c);
        }
    }
    (family, numbers)
}

/// Whether two terms are the same but for numbers inside them, which are nearly the same.
fn nearly_the_same(found: &str, truth: &str) -> bool {
    let ((one, estimates), (other, values)) = (family(found), family(truth));
    one == other
        && estimates.len() == values.len()
        && estimates.iter().zip(values).all(|(e, v)| (e - v).abs() <= OFF * v.abs())
}

impl Judge {
    /// A judge of `system`.
    ///
    /// # Errors
    /// If the true equations are miswritten or not those of the right-hand side.
    pub fn new(system: &System) -> anyhow::Result<Self> {
        let (states, truth) = (system.states(), system.equations()?);
        let variables = [system.states(), system.controls()].concat();
        let compiled = Equations::new(&truth, &variables)?;
        let seed = Seed::new(u64::MAX);
        let log = generate(system, RECORDINGS * system.length, 0.0, seed)?;
        let range = |i: usize| {
            let values = log.trajectories.iter().flat_map(|t| t.states.column(i).to_vec());
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let bounds: Vec<(f64, f64)> =
            (0..states.len()).map(range).chain(system.inputs.iter().map(|u| u.range)).collect();
        let (low, high): (Vec<f64>, Vec<f64>) = bounds.iter().copied().unzip();
        let points = Points::new(system.rates(), states.len(), &low, &high, POINTS, &mut seed.stream("box", 0));
        let judge = Self { states, variables, points, truth, compiled, judged: system.judged().collect(), bounds };
        let apart = judge.points.deviation(&judge.compiled, 0..judge.states.len());
        anyhow::ensure!(apart < 1e-5, "the true terms of {} are {apart} away from its rates", system.name());
        Ok(judge)
    }

    /// Range of every state and input.
    #[must_use]
    pub fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    /// Judges the equations found.
    ///
    /// # Errors
    /// If a term cannot be read.
    pub fn judge(&self, found: &[Vec<Term>]) -> anyhow::Result<Verdict> {
        anyhow::ensure!(found.len() == self.truth.len(), "{} equations, not {}", found.len(), self.truth.len());
        let compiled = Equations::new(found, &self.variables).context("what was found")?;
        let deviation = self.points.deviation(&compiled, self.judged.iter().copied());
        let found = &self.with_true_parameters(found);
        let compiled = Equations::new(found, &self.variables)?;
        let equations: Vec<Judged> = self.judged.iter().map(|&i| self.equation(i, &found[i], &compiled)).collect();
        let right = deviation < NOTHING_LIKE && equations.iter().all(|e| e.right);
        let worst = equations.iter().filter_map(|e| e.coefficient_error).fold(0.0, f64::max);
        let coefficient_error = right.then_some(worst);
        Ok(Verdict { right, coefficient_error, deviation: Some(deviation).filter(|d| d.is_finite()), equations })
    }

    /// `found` with the true numbers inside terms that have others there: a parameter is estimated like a coefficient.
    fn with_true_parameters(&self, found: &[Vec<Term>]) -> Vec<Vec<Term>> {
        let own = |term: &Term, row: &Vec<Term>| {
            let alike = |t: &&Term| t.rate == term.rate && nearly_the_same(&term.text, &t.text);
            let text = row.iter().find(alike).map_or(&term.text, |t| &t.text).clone();
            Term { text, ..term.clone() }
        };
        found.iter().zip(&self.truth).map(|(row, truth)| row.iter().map(|t| own(t, truth)).collect()).collect()
    }

    fn equation(&self, i: usize, found: &[Term], compiled: &Equations) -> Judged {
        let (own, truth) = (compiled.row(i), self.compiled.row(i));
        // A ratio multiplied out has the own derivative among its terms.
        let ratio = self.truth[i].iter().any(|t| t.text.contains('/'));
        let implicit = ratio || self.compiled.is_implicit(self.judged.iter().copied());
        let coefficients = match self.points.structure(i, own) {
            Structure::True(coefficients) if implicit || own.len() <= truth.len() => Some(coefficients),
            _ => None,
        };
        let right = coefficients.is_some();
        let label = |t: &Term| t.label(&self.states);
        let labels = |terms: &[Term]| terms.iter().map(|t| (label(t), t.coefficient)).collect();
        let unmatched = |of: usize, terms: &[Term], compiled: &Equations, others: &Equations| {
            let row = compiled.row(of).iter().zip(terms);
            let alone = row.filter(|(t, _)| !others.row(of).iter().any(|o| self.points.same(t, o)));
            if right { Vec::new() } else { alone.map(|(_, t)| label(t)).collect() }
        };
        let error = |coefficients: Vec<f64>| {
            own.iter().zip(coefficients).map(|(t, c)| (t.coefficient() / c - 1.0).abs()).fold(0.0, f64::max)
        };
        Judged {
            state: self.states[i].clone(),
            found: labels(found),
            truth: labels(&self.truth[i]),
            right,
            missing: unmatched(i, &self.truth[i], &self.compiled, compiled),
            spurious: unmatched(i, found, compiled, &self.compiled),
            standardised: coefficients.as_ref().and_then(|true_ones| {
                let z = |(t, c): (&Term, &f64)| Some((t.coefficient - c) / t.error?);
                found.iter().zip(true_ones).map(z).collect()
            }),
            coefficient_error: coefficients.map(error),
        }
    }
}
