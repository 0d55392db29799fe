//! Equations with terms that have parameters inside.

use super::exchange::NEAR;
use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::regression::{Inside, Proposal};
use super::search::SAMPLE;
use crate::Triangle;
use crate::data::{Signals, sample_of, stretches};
use crate::library::{Shape, Term};

/// Terms of an equation that leaves noise alone, up to which none is looked for that explains it with fewer.
pub(super) const SIMPLE: usize = 4;

/// Operations for a number of a small regression.
const SOLVED: usize = 20;

/// Candidates that are looked at together.
const BATCH: usize = 12;

/// Part of all that may be spent on fits, for these.
const SHARE: f64 = 0.4;

/// Terms with parameters inside that are looked for in one equation, one after the other.
const TERMS: usize = 2;

/// Terms with parameters inside that are looked at in all of long data.
const RANKED: usize = 24;

/// Families proposed at a time.
pub(super) const FAMILIES: usize = 3;

/// Change of the logarithm of a parameter that is believed of one linearisation.
pub(super) const BELIEVED: f64 = 1.0;

/// A term with parameters inside, and the derivatives of the term by these, as terms.
pub(super) struct Candidate {
    pub(super) term: usize,
    pub(super) slopes: Vec<usize>,
}

impl Candidate {
    pub(super) fn columns(&self) -> impl Iterator<Item = usize> {
        std::iter::once(self.term).chain(self.slopes.iter().copied())
    }
}

impl Problem<'_> {
    /// Tries terms with parameters inside in each equation that leaves more than noise or has many terms. What is better than `found`, if anything is.
    pub(super) fn search_inside(&self, found: &Hypothesis, signals: &Signals) -> Option<Hypothesis> {
        self.with_share(SHARE, |problem| problem.search_inside_within(found, signals))
    }

    /// Whether no equation has so many terms that one with parameters inside may be meant by them.
    pub(super) fn is_simple(&self, hypothesis: &Hypothesis) -> bool {
        hypothesis.supports.iter().all(|support| support.len() <= SIMPLE)
    }

    fn search_inside_within(&self, found: &Hypothesis, signals: &Signals) -> Option<Hypothesis> {
        let unsettled = |h: &Hypothesis, i: usize| h.supports[i].len() > SIMPLE || !self.is_noise(h, i);
        let of = |i: &usize| self.rates[*i].is_none() && unsettled(found, *i);
        let mut equations: Vec<usize> = (0..self.rates.len()).filter(of).collect();
        // What is wrong with one shows in others too, but less.
        let left = |i: &usize| found.fit.left[*i] / signals.sigma[*i];
        equations.sort_by(|a, b| left(b).total_cmp(&left(a)));
        if equations.is_empty() || self.n_plain == self.terms.len() {
            return None;
        }
        let mut best = found.clone();
        let again: Vec<usize> = if equations.len() > 1 { equations.clone() } else { Vec::new() };
        for (at, &i) in equations.iter().chain(&again).enumerate() {
            if !unsettled(&best, i) {
                continue;
            }
            if !self.may_spend() {
                break;
            }
            let mut tried = vec![best.supports[i].clone()];
            for round in 0..TERMS {
                // Once others have been found, with their parameters.
                let shared = at >= equations.len();
                let of = (&best.supports[..], &best.inside[..], best.flow.stepping());
                // Along the measured path first: near equations that are far from the true ones all candidates look alike, at a high price.
                let measured = if round == 0 { self.measured_inside(of, signals, i, shared) } else { Vec::new() };
                let better = self.best_of(measured, &best, i, &mut tried);
                let near = || self.best_of(self.propose_inside(&best, i), &best, i, &mut tried);
                let Some(better) = better.or_else(near) else { break };
                best = better;
                if self.is_noise(&best, i) {
                    break;
                }
            }
        }
        (best.score < found.score).then_some(best)
    }

    /// Proposals for equation `i` with one more term that has parameters inside, and with fewer of the others: the best families near
    /// `along`, with all states and the coefficients of the other equations free. Of long data a part tells which terms are worth looking at in all.
    pub(super) fn propose_inside(&self, along: &Hypothesis, i: usize) -> Vec<Proposal> {
        let (terms, mut candidates) = self.candidates_inside(&along.supports, i);
        if self.is_long() && candidates.len() > RANKED {
            let sample = sample_of(self.segments, SAMPLE);
            let part = along.part_of(&stretches(self.segments, SAMPLE));
            let told = Problem { segments: &sample, ..*self }.near_inside(&terms, &candidates, &part, i);
            let mut told: Vec<(f64, Candidate)> =
                told.into_iter().map(|n| n.map_or(f64::INFINITY, |(change, _)| change)).zip(candidates).collect();
            told.sort_by(|a, b| a.0.total_cmp(&b.0));
            candidates = told.into_iter().take(RANKED).map(|(_, candidate)| candidate).collect();
        }
        let near = self.near_inside(&terms, &candidates, along, i).into_iter().flatten();
        self.best_of_families(near.filter(|(change, _)| *change <= NEAR).map(|(_, proposal)| proposal).collect())
    }

    /// For each of `candidates` for equation `i`, the proposal that has it near `along`, and how much its score is above that of the terms of `along`.
    fn near_inside(
        &self,
        terms: &[Term],
        candidates: &[Candidate],
        along: &Hypothesis,
        i: usize,
    ) -> Vec<Option<(f64, Proposal)>> {
        let (own, least) = (&along.supports[i], self.least_near(along));
        let mut found = Vec::with_capacity(candidates.len());
        for batch in candidates.chunks(BATCH) {
            let choice: Vec<usize> = own.iter().copied().chain(batch.iter().flat_map(Candidate::columns)).collect();
            let Some(triangle) = self.triangle_near(terms, along, i, &choice) else {
                found.extend(batch.iter().map(|_| None));
                continue;
            };
            let base = self.scored_columns((&triangle, least), &(0..own.len()).collect::<Vec<_>>(), own).0;
            let mut first = own.len();
            for candidate in batch {
                let columns: Vec<usize> = (first..=first + candidate.slopes.len()).collect();
                first += columns.len();
                let proposal = self.with_fewer((&triangle, least), (own, candidate), columns, i);
                found.push(proposal.map(|proposal| (proposal.score - base, proposal)));
            }
        }
        found
    }

    /// The best proposal of each of the best families.
    pub(super) fn best_of_families(&self, mut found: Vec<Proposal>) -> Vec<Proposal> {
        found.sort_by(|a, b| a.score.total_cmp(&b.score));
        let mut families: Vec<Proposal> = Vec::new();
        for proposal in found {
            if families.len() < FAMILIES && !families.iter().any(|f| self.are_alike(&f.support, &proposal.support)) {
                families.push(proposal);
            }
        }
        families
    }

    /// Whether two sets of terms are the same but for where parameters inside them begin.
    pub(super) fn are_alike(&self, a: &[usize], b: &[usize]) -> bool {
        let alike = |j: usize, k: usize| match (&self.terms[j].shape, &self.terms[k].shape) {
            (Some(one), Some(other)) => one.is_like(other),
            _ => j == k,
        };
        a.len() == b.len() && a.iter().all(|&j| b.iter().any(|&k| alike(j, k)))
    }

    /// The terms of the problem with derivatives of those with parameters inside, and which of them may be added to equation `i`.
    pub(super) fn candidates_inside(&self, supports: &[Vec<usize>], i: usize) -> (Vec<Term>, Vec<Candidate>) {
        let mut terms = self.terms.to_vec();
        let used = self.free(supports);
        let mut candidates = Vec::new();
        for j in self.n_plain..self.terms.len() {
            let Some(shape) = self.terms[j].shape.as_ref().filter(|shape| self.may_be_tried(i, j, shape)) else {
                continue;
            };
            let is_like = |k: &&usize| self.terms[**k].shape.as_ref().is_some_and(|other| other.is_like(shape));
            // A parameter is the same in all equations.
            match used.iter().find(is_like) {
                Some(&k) if k == j && !supports[i].contains(&j) => {
                    candidates.push(Candidate { term: j, slopes: Vec::new() });
                }
                Some(_) => {}
                None => {
                    let slopes = self.slopes(j, &shape.start());
                    let first = terms.len();
                    terms.extend(slopes);
                    candidates.push(Candidate { term: j, slopes: (first..terms.len()).collect() });
                }
            }
        }
        (terms, candidates)
    }

    /// Whether the term `j`, which has parameters inside, may be tried in equation `i`: kinks from the other side are written once they are found.
    fn may_be_tried(&self, i: usize, j: usize, shape: &Shape) -> bool {
        self.allows_inside(i, j) && shape.kink() != Some(-1.0)
    }

    /// Whether the term `j`, which has parameters inside, may be added to equation `i` of `best`, which has none of its family.
    pub(super) fn may_be_added(&self, best: &Hypothesis, i: usize, j: usize) -> bool {
        let used = self.free(&best.supports);
        let is_new = |shape: &&Shape| {
            used.iter().all(|&k| self.terms[k].shape.as_ref().is_none_or(|other| !other.is_like(shape)))
        };
        self.terms[j].shape.as_ref().filter(is_new).is_some_and(|shape| self.may_be_tried(i, j, shape))
    }

    /// The derivatives of the term `j` by the parameters inside it where these are as `fitted`, as terms.
    pub(super) fn slopes(&self, j: usize, fitted: &[f64]) -> Vec<Term> {
        let Some(shape) = &self.terms[j].shape else { return Vec::new() };
        let slope = |k: usize| Some(Term { expr: shape.slope(k, fitted)?, shape: None, ..self.terms[j].clone() });
        (0..shape.len()).filter_map(slope).collect()
    }

    /// Whether equation `i` may have the term `j`, which has parameters inside: no term of the same variables is forbidden, which it might be next to.
    fn allows_inside(&self, i: usize, j: usize) -> bool {
        let n_variables = self.rates.len() + self.n_controls;
        let same = |k: &usize| {
            let (a, b) = (&self.terms[j].expr, &self.terms[*k].expr);
            self.terms[*k].rate.is_none() && (0..n_variables).all(|v| a.has(v) == b.has(v))
        };
        self.constraints.get(i).is_none_or(|c| !c.forbidden.iter().any(same))
    }

    /// The score of the terms `support`, whose columns are `columns`, and their coefficients.
    pub(super) fn scored_columns(
        &self,
        (triangle, least): (&Triangle, f64),
        columns: &[usize],
        support: &[usize],
    ) -> (f64, Vec<f64>) {
        let target = triangle.n_columns() - 1;
        let rows = triangle.n_rows() as f64;
        self.charge((SOLVED * target * columns.len() * columns.len()) as u64);
        let xi = triangle.solve_unit(columns, target);
        let left = triangle.residual_norm(columns, &xi, target).powi(2);
        let free = (rows - columns.len() as f64).max(1.0);
        (rows * (left / free).max(least).max(f64::MIN_POSITIVE).ln() + self.penalty(support), xi)
    }

    /// The best of the sets of terms `own`, the first columns of `triangle`, that has `candidate`, which has the columns `inside`: one term
    /// after the other is left out, the one that is missed least.
    fn with_fewer(
        &self,
        triangle: (&Triangle, f64),
        (own, candidate): (&[usize], &Candidate),
        inside: Vec<usize>,
        i: usize,
    ) -> Option<Proposal> {
        let of = |kept: &[usize]| {
            let columns = [kept, &inside].concat();
            let support: Vec<usize> = kept.iter().map(|&c| own[c]).chain([candidate.term]).collect();
            let (score, xi) = self.scored_columns(triangle, &columns, &support);
            (score, support, xi)
        };
        let mut kept: Vec<usize> = (0..own.len()).collect();
        let mut best = of(&kept);
        loop {
            let without = |c: usize| kept.iter().copied().filter(|k| *k != c).collect::<Vec<_>>();
            let fewer =
                kept.iter().filter(|&&c| !self.required(i).contains(&own[c])).map(|&c| (without(c), of(&without(c))));
            let Some((columns, scored)) = fewer.min_by(|a, b| a.1.0.total_cmp(&b.1.0)) else { break };
            kept = columns;
            if scored.0 < best.0 {
                best = scored;
            }
        }
        let (score, support, xi) = best;
        let own = xi.get(support.len() - 1).copied()?;
        self.proposed((candidate, &self.start_of(candidate)), support, xi, (score, own))
    }

    /// The proposal of the terms `support`, of which `candidate` is the last, linearised where its parameters are `at`, with coefficients `xi` that are followed
    /// by those of its slopes; its parameters change by these, as parts of the coefficient `own` of the candidate.
    pub(super) fn proposed(
        &self,
        (candidate, at): (&Candidate, &[f64]),
        support: Vec<usize>,
        xi: Vec<f64>,
        (score, own): (f64, f64),
    ) -> Option<Proposal> {
        let (coefficients, changes) = xi.split_at(support.len());
        if !score.is_finite() || own == 0.0 || xi.iter().any(|c| !c.is_finite()) {
            return None;
        }
        let mut inside: Vec<Inside> = Vec::new();
        if let Some(shape) = self.terms[candidate.term].shape.as_ref().filter(|_| !changes.is_empty()) {
            let moved = |(v, change): (&f64, &f64)| v + (change / own).clamp(-BELIEVED, BELIEVED);
            let fitted: Vec<f64> = at.iter().zip(changes).map(moved).collect();
            let fitted = if shape.is_within(&fitted) { fitted } else { at.to_vec() };
            inside.push((candidate.term, fitted));
        }
        let mut told: Vec<(usize, f64)> = support.into_iter().zip(coefficients.iter().copied()).collect();
        told.sort_by_key(|(j, _)| *j);
        let (support, coefficients) = told.into_iter().unzip();
        Some(Proposal { support, coefficients, inside, score, residual: 0.0 })
    }
}
