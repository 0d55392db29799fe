//! Equations that the data allow beside the likeliest ones.

use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use serde::{Deserialize, Serialize};
use sindyna_core::Rng;

use super::hypothesis::Hypothesis;
use super::problem::Problem;
use crate::library::Term;
use crate::{Expr, Triangle};

/// Equations as they are written into a model: their terms, and per state the numbers of these and the coefficients.
pub(crate) type Written = (Vec<Term>, Vec<(Vec<usize>, Vec<f64>)>);

/// One set of terms with the distribution of its coefficients.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Member {
    /// Its probability beside the others, not normalised.
    odds: f64,
    supports: Vec<Vec<usize>>,
    /// Coefficients, then parameters inside terms.
    xi: Vec<f64>,
    /// Factor of what the data tell of these; `None` if they were drawn already.
    factor: Option<Triangle>,
    /// Terms with parameters inside.
    free: Vec<usize>,
}

/// Sets of terms by how well they explain the data, each with the distribution of its coefficients.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Posterior {
    terms: Vec<Term>,
    /// The term that is a declared rate, of each state.
    rates: Vec<Option<usize>>,
    /// Terms of each equation with coefficients that are given.
    given: Vec<Vec<(usize, f64)>>,
    members: Vec<Member>,
}

impl Problem<'_> {
    /// What the data allow: `best`, and hypotheses about as good.
    pub(super) fn posterior(&self, best: &Hypothesis, others: &[Hypothesis]) -> Posterior {
        let member = |h: &Hypothesis| Member {
            // The score is minus twice the logarithm of the probability.
            odds: (0.5 * (best.score - h.score)).exp(),
            supports: h.supports.clone(),
            xi: h.fit.xi.clone(),
            factor: Some(h.fit.triangle.clone()),
            free: self.free(&h.supports),
        };
        let rate = |v: &Option<usize>| {
            v.and_then(|v| self.terms.iter().position(|t| t.rate.is_none() && t.expr == Expr::Variable(v)))
        };
        let mut given = self.given();
        given.resize(self.rates.len(), Vec::new());
        Posterior {
            terms: self.terms.to_vec(),
            rates: self.rates.iter().map(rate).collect(),
            given,
            members: std::iter::once(best).chain(others).map(member).collect(),
        }
    }
}

impl Posterior {
    /// Equations with the terms `supports` of `terms`, whose coefficients were `drawn`.
    pub(crate) fn of_draws(
        terms: Vec<Term>,
        rates: &[Option<usize>],
        supports: &[Vec<usize>],
        drawn: Vec<Vec<f64>>,
    ) -> Self {
        let place = |v: usize| terms.iter().position(|t| t.rate.is_none() && t.expr == Expr::Variable(v));
        let rates: Vec<Option<usize>> = rates.iter().map(|rate| rate.and_then(place)).collect();
        let own =
            |(support, rate): (&Vec<usize>, &Option<usize>)| if rate.is_some() { Vec::new() } else { support.clone() };
        let supports: Vec<Vec<usize>> = supports.iter().zip(&rates).map(own).collect();
        let member = |xi| Member { odds: 1.0, supports: supports.clone(), xi, factor: None, free: Vec::new() };
        let members = drawn.into_iter().map(member).collect();
        Self { given: vec![Vec::new(); rates.len()], terms, rates, members }
    }

    /// Draws equations; `None` if the data do not determine those that the draw fell on.
    pub(crate) fn draw(&self, rng: &mut Rng) -> Option<Written> {
        let total: f64 = self.members.iter().map(|m| m.odds).sum();
        let mut at = rng.random_range(0.0..1.0) * total;
        let chosen = self.members.iter().find(|m| {
            at -= m.odds;
            at < 0.0
        });
        let member = chosen.or(self.members.first())?;
        let Some(factor) = &member.factor else { return Some(self.written(member, &member.xi)) };
        let z: Vec<f64> = member.xi.iter().map(|_| StandardNormal.sample(rng)).collect();
        let delta = factor.whitened_inverse(&z)?;
        let xi: Vec<f64> = member.xi.iter().zip(&delta).map(|(xi, delta)| xi + delta).collect();
        Some(self.written(member, &xi))
    }

    /// The equations of `member` with the coefficients and parameters `xi`.
    fn written(&self, member: &Member, xi: &[f64]) -> Written {
        let (mut rest, mut equations) = (xi, Vec::new());
        for ((support, rate), given) in member.supports.iter().zip(&self.rates).zip(&self.given) {
            let (own, later) = rest.split_at(support.len());
            rest = later;
            let (support, own) = match rate {
                Some(term) => (vec![*term], vec![1.0]),
                None => (support.clone(), own.to_vec()),
            };
            let (places, values): (Vec<usize>, Vec<f64>) = given.iter().copied().unzip();
            equations.push(([support, places].concat(), [own, values].concat()));
        }
        let mut terms = self.terms.clone();
        for &j in &member.free {
            let Some(shape) = terms[j].shape.take() else { continue };
            let (own, later) = rest.split_at(shape.len());
            terms[j].expr = shape.at(own);
            rest = later;
        }
        (terms, equations)
    }
}
