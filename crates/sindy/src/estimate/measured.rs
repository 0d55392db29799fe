//! Terms with parameters inside, along the measured path: which candidates are worth a fit, and where their parameters are.

use ndarray::{Array2, Axis, concatenate, s};

use super::inside::{Candidate, FAMILIES};
use super::problem::Problem;
use super::propose::{Effort, THOROUGHLY};
use super::regression::{Inside, Proposal, Regression};
use super::search::{TIMES, measured};
use crate::Triangle;
use crate::data::Signals;
use crate::design::Path;
use crate::library::{Shape, Term};
use crate::motion::Stepping;

/// Terms beside one with parameters inside, at most, in equations that are looked for from nothing.
const OTHERS: usize = 8;

/// What is spent on ranking candidates along the measured path, after which the best families are looked at thoroughly.
const RANKING: Effort = Effort { budget: 500, starts: 1 };

/// Times that a candidate is linearised again, at most, and the change of its parameters below which it is not.
const REFINED: usize = 4;
const STAYS: f64 = 0.01;

/// Families of which the best are proposed, once their parameters are refined.
const FINALISTS: usize = 8;

impl Problem<'_> {
    /// Proposals for equation `i` along the measured path beside equations with the terms `supports`, some of which have parameters `inside`; only of
    /// terms in other equations, if `shared`, or only of others.
    pub(super) fn measured_inside(
        &self,
        (supports, inside, stepping): (&[Vec<usize>], &[Inside], Stepping),
        signals: &Signals,
        i: usize,
        shared: bool,
    ) -> Vec<Proposal> {
        let (mut terms, mut candidates) = self.candidates_inside(supports, i);
        candidates.retain(|c| c.slopes.is_empty() == shared);
        if candidates.is_empty() {
            return Vec::new();
        }
        for (j, fitted) in inside {
            if let Some(shape) = &self.terms[*j].shape {
                terms[*j].expr = shape.at(fitted);
            }
        }
        let path = measured(signals, stepping);
        let theta = self.averaged(&terms, &path);
        let plain = self.choice(i);
        let all: Vec<usize> = plain.iter().copied().chain(candidates.iter().flat_map(Candidate::columns)).collect();
        let errors = self.errors(&signals.sigma, None);
        let Some((triangle, _)) = self.rows(&theta, &all, i, &signals.sigma, &errors) else { return Vec::new() };
        let without = triangle.with_others(plain.len(), &[all.len()]);
        let least = self.least(i..=i, &signals.sigma);
        let without = self.subsets(i, (without, least), plain.clone(), None, (OTHERS + 1, RANKING));
        let bar = without.best(1.0, |support| self.penalty(support)).score;
        let mut first = plain.len();
        let mut ranked: Vec<(f64, &Candidate, Triangle)> = Vec::new();
        for candidate in candidates.iter().take_while(|_| self.may_spend()) {
            let inside: Vec<usize> = candidate.columns().enumerate().map(|(at, _)| first + at).collect();
            first += inside.len();
            let own = triangle.with_others(plain.len(), &[&inside[..], &[all.len()]].concat());
            let order = (plain.len()..plain.len() + inside.len()).chain(0..plain.len()).chain([own.n_columns() - 1]);
            let own = own.combined(&order.map(|c| vec![(c, 1.0)]).collect::<Vec<_>>());
            let others = own.trailing(inside.len());
            let roughly = self.subsets(i, (others, least), plain.clone(), None, (OTHERS, RANKING));
            let inside = self.penalty(&[candidate.term]);
            ranked.push((roughly.best(1.0, |support| self.penalty(support)).score + inside, candidate, own));
        }
        // Of no use is what explains no more than the other terms do.
        ranked.retain(|r| r.0 < bar);
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let rows = Rows { i, theta: &theta, path: &path, plain: &plain, sigma: &signals.sigma, errors: &errors };
        let mut finalists: Vec<(&Candidate, Linearised)> = Vec::new();
        for (_, candidate, triangle) in ranked {
            let known = finalists.iter().any(|(other, _)| self.are_alike(&[candidate.term], &[other.term]));
            if !known && finalists.len() < FINALISTS {
                finalists.push((candidate, Linearised { at: self.start_of(candidate), triangle }));
            }
        }
        // Where parameters begin is not where they end.
        let mut promising: Vec<(f64, &Candidate, Linearised)> = finalists
            .into_iter()
            .take_while(|_| self.may_spend())
            .filter_map(|(candidate, begun)| {
                let others = self.others(&rows, &begun, RANKING);
                let (proposal, ended) = self.refined(&rows, candidate, (begun, &others), (1.0, RANKING))?;
                Some((proposal.score, candidate, ended))
            })
            .collect();
        promising.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut proposals: Vec<Proposal> = Vec::new();
        for (_, candidate, begun) in promising.into_iter().take(FAMILIES).take_while(|_| self.may_spend()) {
            let others = self.others(&rows, &begun, THOROUGHLY);
            for times in TIMES {
                let refined = self.refined(&rows, candidate, (begun.clone(), &others), (times, THOROUGHLY));
                proposals.extend(refined.map(|r| r.0).filter(|p| !proposals.contains(p)));
            }
        }
        proposals
    }

    /// The best proposal with `candidate` if every term costs `times` what it does, linearised at first as `now`, where the other terms are those of
    /// `others`, and again where the parameters are told to be, until these stay; and its linearisation.
    fn refined(
        &self,
        rows: &Rows<'_>,
        candidate: &Candidate,
        (mut now, others): (Linearised, &Regression),
        (times, effort): (f64, Effort),
    ) -> Option<(Proposal, Linearised)> {
        let mut best: Option<(Proposal, Linearised)> = None;
        for round in 0..=REFINED {
            let again = (round > 0).then(|| self.others(rows, &now, effort));
            let chosen = again.as_ref().unwrap_or(others).best(times, |support| self.penalty(support));
            let Some(proposal) = self.proposed_at(rows, candidate, &now, &chosen.support) else { break };
            let fitted = proposal.inside.first().map_or_else(Vec::new, |(_, fitted)| fitted.clone());
            let stays = fitted.iter().zip(&now.at).all(|(new, old)| (new - old).abs() < STAYS);
            if best.as_ref().is_none_or(|(b, _)| proposal.score < b.score) {
                best = Some((proposal, now));
            }
            if stays || !self.may_spend() {
                break;
            }
            let Some(triangle) = self.linearised_at(rows, candidate, &fitted) else { break };
            now = Linearised { at: fitted, triangle };
        }
        best
    }

    /// The best terms beside a candidate that is linearised as `now`.
    fn others(&self, rows: &Rows<'_>, now: &Linearised, effort: Effort) -> Regression {
        let Rows { i, plain, sigma, .. } = rows;
        let n_inside = now.triangle.n_columns() - 1 - plain.len();
        let others = (now.triangle.trailing(n_inside), self.least(*i..=*i, sigma));
        self.subsets(*i, others, plain.to_vec(), None, (OTHERS, effort))
    }

    /// The proposal of `candidate`, linearised as `now`, with the terms `others`.
    fn proposed_at(
        &self,
        rows: &Rows<'_>,
        candidate: &Candidate,
        now: &Linearised,
        others: &[usize],
    ) -> Option<Proposal> {
        let Rows { i, plain, sigma, .. } = rows;
        let (n_inside, least) = (1 + candidate.slopes.len(), self.least(*i..=*i, sigma));
        let place = |j: &usize| plain.iter().position(|k| k == j).map(|at| n_inside + at);
        let kept: Vec<usize> = others.iter().filter_map(place).collect();
        let columns: Vec<usize> = kept.iter().copied().chain(0..n_inside).collect();
        let support: Vec<usize> = others.iter().copied().chain([candidate.term]).collect();
        let (score, xi) = self.scored_columns((&now.triangle, least), &columns, &support);
        // Where it is far from the end, as here, its own coefficient beside its slopes may have the wrong sign; a step of Gauss–Newton takes the one without these.
        let target = now.triangle.n_columns() - 1;
        let own = now.triangle.solve_unit(&columns[..support.len()], target).last().copied()?;
        self.proposed((candidate, &now.at), support, xi, (score, own))
    }

    /// Where fits of the parameters inside `candidate` start.
    pub(super) fn start_of(&self, candidate: &Candidate) -> Vec<f64> {
        self.terms[candidate.term].shape.as_ref().map_or_else(Vec::new, Shape::start)
    }

    /// The triangle of `candidate` with parameters as `fitted`, its slopes there, the plain terms, and the rate.
    fn linearised_at(&self, rows: &Rows<'_>, candidate: &Candidate, fitted: &[f64]) -> Option<Triangle> {
        let Rows { i, theta, path, plain, sigma, errors } = rows;
        let term = &self.terms[candidate.term];
        let mut inside = vec![Term { expr: term.shape.as_ref()?.at(fitted), shape: None, ..term.clone() }];
        inside.extend(self.slopes(candidate.term, fitted));
        let columns = self.averaged(&inside, path);
        let with = |(theta, own): (&Array2<f64>, &Array2<f64>)| {
            concatenate![Axis(1), theta.slice(s![.., ..self.n_plain]), own.view()]
        };
        let theta: Vec<Array2<f64>> = theta.iter().zip(&columns).map(with).collect();
        let choice: Vec<usize> = (self.n_plain..self.n_plain + inside.len()).chain(plain.iter().copied()).collect();
        Some(self.rows(&theta, &choice, *i, sigma, errors)?.0)
    }
}

/// A candidate linearised.
#[derive(Clone)]
struct Linearised {
    /// The parameters inside it, as they are fitted.
    at: Vec<f64>,
    /// Its columns, the plain terms that the equation may have, and the rate.
    triangle: Triangle,
}

/// What the regressions of one equation along a path are made of.
struct Rows<'a> {
    i: usize,
    /// Averages of the terms over each step (T, F), the plain ones first, per segment.
    theta: &'a [Array2<f64>],
    path: &'a Path<'a>,
    /// Plain terms that the equation may have.
    plain: &'a [usize],
    /// Standard deviations of the noise (n).
    sigma: &'a [f64],
    /// Those of the rates by errors of the path (T, n), per segment.
    errors: &'a [Array2<f64>],
}
