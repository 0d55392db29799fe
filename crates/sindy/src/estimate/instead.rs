//! One term with parameters inside instead of several of the same variables.
//!
//! Sums of powers, products, exponentials and waves say within noise what a single function of the same variables says, and no term after the other leads from
//! these to that.

use super::exchange::NEAR;
use super::hypothesis::Hypothesis;
use super::inside::{BELIEVED, Candidate, FAMILIES};
use super::problem::Problem;
use super::regression::{Proposal, likelihood};
use super::rest::Rest;
use super::search::SAMPLE;
use crate::Triangle;
use crate::data::{sample_of, stretches};
use crate::library::Term;

/// Values of a single parameter where terms are linearised, between its bounds.
const SCANNED: usize = 8;

/// Families that are looked at more closely, of those that explain most.
const CLOSELY: usize = 2 * FAMILIES;

/// Times that a term is linearised where its parameters are best, at most, and the parts of a step that are tried then.
const REFINED: usize = 4;
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.1];

/// Change of a parameter below which it is not fitted further.
const STAYS: f64 = 0.01;

impl Problem<'_> {
    /// Proposals for equation `i` of `best` with one term that has parameters inside in place of all terms that are functions of no other variables than it is, beside plain terms of these variables, where
    /// they have no more parameters: the best of each of the best families. Of long data a part tells them.
    pub(super) fn instead(&self, best: &Hypothesis, i: usize) -> Vec<Proposal> {
        let sample = self.is_long().then(|| sample_of(self.segments, SAMPLE));
        let part = sample.as_ref().map(|_| best.part_of(&stretches(self.segments, SAMPLE)));
        let problem = Problem { segments: sample.as_deref().unwrap_or(self.segments), ..*self };
        let along = part.as_ref().unwrap_or(best);
        let mut found: Vec<Found> = Vec::new();
        for place in self.places_inside(best, i) {
            if !self.may_spend() {
                return Vec::new();
            }
            found.extend(problem.scanned((along, i), &place));
        }
        found.sort_by(|a, b| a.score.total_cmp(&b.score));
        found.truncate(CLOSELY);
        self.best_of_families(
            found.into_iter().filter_map(|found| problem.with_parameters((along, i), found)).collect(),
        )
    }

    /// Where terms with parameters inside may stand in equation `i` of `best`: one place for each set of variables that they are functions of.
    fn places_inside(&self, best: &Hypothesis, i: usize) -> Vec<Place> {
        let own = &best.supports[i];
        let is_free = |j: usize| self.terms[j].rate.is_none_or(|rate| rate == i) && !self.required(i).contains(&j);
        let mut places: Vec<Place> = Vec::new();
        for j in self.n_plain..self.terms.len() {
            let variables = self.variables(j);
            if let Some(place) = places.iter_mut().find(|place| place.variables == variables) {
                place.shaped.push(j);
                continue;
            }
            let within =
                |k: usize| is_free(k) && self.variables(k).iter().zip(&variables).all(|(has, may)| *may || !has);
            let (group, kept): (Vec<usize>, Vec<usize>) = own.iter().partition(|&&k| within(k));
            let plain = self.choice(i).into_iter().filter(|&k| self.terms[k].rate.is_none() && within(k));
            let beside = plain.filter(|k| !kept.contains(k)).collect();
            places.push(Place { variables, group, kept, beside, shaped: vec![j] });
        }
        places.retain(|Place { group, .. }| {
            let moving: Vec<&usize> = group.iter().filter(|&&k| !self.is_constant(k)).collect();
            moving.len() > 1 && moving.iter().any(|&&k| !self.is_variable(k))
        });
        let elsewhere = self.elsewhere(best, i);
        for place in &mut places {
            let (kept, parameters) = (self.free(&[place.kept.clone()]), self.n_parameters(&place.group));
            place.shaped.retain(|&j| {
                let is_new = self.is_unlike(&kept, j) && (self.is_unlike(&elsewhere, j) || elsewhere.contains(&j));
                is_new && self.n_parameters(&[j]) <= parameters && self.may_be_tried(i, j)
            });
        }
        places.retain(|place| !place.shaped.is_empty());
        places
    }

    /// Terms with parameters inside of the other equations than `i` of `best`: a parameter is the same in all of them.
    fn elsewhere(&self, best: &Hypothesis, i: usize) -> Vec<usize> {
        let others = best.supports.iter().enumerate().filter(|(l, _)| *l != i);
        self.free(&others.map(|(_, support)| support.clone()).collect::<Vec<_>>())
    }

    /// Of each family that may stand at `place` in equation `i`, linearised at some of its parameters, what explains most beside plain terms there.
    fn scanned(&self, (along, i): (&Hypothesis, usize), place: &Place) -> Vec<Found> {
        let (mut looked, elsewhere) = (Vec::<(usize, Vec<f64>)>::new(), self.elsewhere(along, i));
        for &j in &place.shaped {
            let Some(shape) = &self.terms[j].shape else { continue };
            let known =
                along.inside.iter().find(|(k, _)| *k == j && elsewhere.contains(k)).map(|(_, at)| vec![at.clone()]);
            let all = known.or_else(|| shape.between(SCANNED)).unwrap_or_else(|| vec![shape.start()]);
            let is_new = |at: &Vec<f64>| !looked.iter().any(|(k, other)| self.are_alike(&[*k], &[j]) && other == at);
            looked.extend(all.into_iter().filter(is_new).map(|at| (j, at)).collect::<Vec<_>>());
        }
        let own = &along.supports[i];
        let (mut terms, first) = (self.terms.to_vec(), self.terms.len());
        let mut inside = Vec::with_capacity(looked.len());
        for (j, at) in &looked {
            let (begins, Some(shape)) = (terms.len(), &self.terms[*j].shape) else { continue };
            terms.push(Term { expr: shape.at(at), shape: None, ..self.terms[*j].clone() });
            terms.extend(if elsewhere.contains(j) { Vec::new() } else { self.slopes(*j, at) });
            inside.push((begins..terms.len()).collect::<Vec<_>>());
        }
        let beside: Vec<usize> = place.beside.iter().copied().filter(|k| !own.contains(k)).collect();
        let choice: Vec<usize> = own.iter().copied().chain(beside).chain(first..terms.len()).collect();
        let Some(triangle) = self.triangle_near(&terms, along, i, &choice) else { return Vec::new() };
        let column = |j: &usize| choice.iter().position(|k| k == j);
        let columns = |terms: &[usize]| terms.iter().filter_map(column).collect::<Vec<_>>();
        let least = self.least_near(along);
        let base = self.scored_columns((&triangle, least), &columns(own), own).0;
        let rest = Rest::without(&triangle, columns(&place.kept).into_iter());
        let most = self.n_parameters(&place.group);
        let mut found: Vec<Found> = Vec::new();
        for (inside, (j, at)) in inside.iter().zip(&looked) {
            let own = self.n_parameters(&[*j]);
            let Some(rest) = columns(inside).into_iter().try_fold(rest.clone(), |rest, c| rest.and(c)) else {
                continue;
            };
            let (ways, work) = rest.forward(&columns(&place.beside), most - own);
            self.charge(work);
            let told = |(chosen, left): (Vec<usize>, f64)| {
                let beside = chosen.iter().map(|&c| choice[c]);
                let kept: Vec<usize> = place.kept.iter().copied().chain(beside).collect();
                let support = [&kept[..], &[*j]].concat();
                let score = likelihood(triangle.n_rows(), support.len(), (left, least)) + self.penalty(&support);
                Found { term: *j, at: at.clone(), kept, score, base }
            };
            let best = ways.into_iter().map(told).min_by(|a, b| a.score.total_cmp(&b.score));
            let Some(best) = best else { continue };
            match found.iter_mut().find(|other| self.are_alike(&[other.term], &[*j])) {
                Some(other) if other.score <= best.score => {}
                Some(other) => *other = best,
                None => found.push(best),
            }
        }
        found
    }

    /// What was `found` for equation `i` of `along`, with its parameters fitted and without the terms that are not missed then; `None` if it explains much less than the terms of `along` do.
    fn with_parameters(&self, (along, i): (&Hypothesis, usize), found: Found) -> Option<Proposal> {
        let Found { term, mut at, kept, base, .. } = found;
        let others = along.supports[i].iter().copied().filter(|j| !kept.contains(j));
        let all = kept.iter().copied().chain(others).collect();
        let free = !self.elsewhere(along, i).contains(&term);
        let replaced = Replaced { along, i, term, free, kept: &kept, all };
        let mut now = self.scores(&replaced, &[at.clone()])?.pop()?;
        for _ in 0..if free { REFINED } else { 0 } {
            let Some(step) = self.step(&replaced, &at).filter(|_| self.may_spend()) else { break };
            if step.iter().all(|change| change.abs() < STAYS) {
                break;
            }
            let shape = self.terms[term].shape.as_ref()?;
            let part = |part: &f64| at.iter().zip(&step).map(|(v, change)| v + part * change).collect::<Vec<f64>>();
            let tried: Vec<Vec<f64>> = PARTS.iter().map(part).filter(|at| shape.is_within(at)).collect();
            let scores = self.scores(&replaced, &tried)?;
            let better = tried.into_iter().zip(scores).min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((to, better)) = better.filter(|(_, better)| *better < now) else { break };
            (at, now) = (to, better);
        }
        let (triangle, columns) = self.around(&replaced, &at)?;
        let candidate = Candidate { term, slopes: columns[1..].to_vec() };
        let triangle = (&triangle, self.least_near(along));
        let proposal = self.with_fewer(triangle, (&kept, &candidate, &at), columns, i)?;
        (proposal.score - base <= NEAR).then_some(proposal)
    }

    /// The score of the terms of `replaced` with each of the parameters `looked`.
    fn scores(&self, replaced: &Replaced<'_>, looked: &[Vec<f64>]) -> Option<Vec<f64>> {
        let Replaced { along, i, term, kept, all, .. } = replaced;
        let (least, mut terms) = (self.least_near(along), self.terms.to_vec());
        let first = terms.len();
        for at in looked {
            let expr = self.terms[*term].shape.as_ref()?.at(at);
            terms.push(Term { expr, shape: None, ..self.terms[*term].clone() });
        }
        let choice: Vec<usize> = all.iter().copied().chain(first..terms.len()).collect();
        let triangle = self.triangle_near(&terms, along, *i, &choice)?;
        let support = [&kept[..], &[*term]].concat();
        let columns = |at: usize| (0..kept.len()).chain([all.len() + at]).collect::<Vec<_>>();
        let of = |at: usize| self.scored_columns((&triangle, least), &columns(at), &support).0;
        Some((0..looked.len()).map(of).collect())
    }

    /// What a step of Gauss–Newton changes of the parameters inside the term of `replaced`, which are `at`.
    fn step(&self, replaced: &Replaced<'_>, at: &[f64]) -> Option<Vec<f64>> {
        let (triangle, inside) = self.around(replaced, at)?;
        let least = self.least_near(replaced.along);
        let support = [replaced.kept, &[replaced.term]].concat();
        let columns: Vec<usize> = (0..replaced.kept.len()).chain(inside).collect();
        // From where the coefficient is without the slopes: with them it says nothing of its own.
        let (_, without) = self.scored_columns((&triangle, least), &columns[..support.len()], &support);
        let (_, with) = self.scored_columns((&triangle, least), &columns, &support);
        let coefficient = without.last().copied().filter(|c| *c != 0.0)?;
        let changes = with[support.len()..].iter().map(|change| (change / coefficient).clamp(-BELIEVED, BELIEVED));
        Some(changes.collect()).filter(|step: &Vec<f64>| step.iter().all(|change| change.is_finite()))
    }

    /// The triangle of all terms of `replaced`, its term with parameters inside, which are `at`, and the derivatives of that by these; also the columns of the latter.
    fn around(&self, replaced: &Replaced<'_>, at: &[f64]) -> Option<(Triangle, Vec<usize>)> {
        let Replaced { along, i, term, free, all, .. } = replaced;
        let mut terms = self.terms.to_vec();
        let first = terms.len();
        let expr = self.terms[*term].shape.as_ref()?.at(at);
        terms.push(Term { expr, shape: None, ..self.terms[*term].clone() });
        terms.extend(if *free { self.slopes(*term, at) } else { Vec::new() });
        let choice: Vec<usize> = all.iter().copied().chain(first..terms.len()).collect();
        Some((self.triangle_near(&terms, along, *i, &choice)?, (all.len()..choice.len()).collect()))
    }

    /// Of which states and inputs the term `j` is a function.
    fn variables(&self, j: usize) -> Vec<bool> {
        (0..self.rates.len() + self.n_controls).map(|v| self.terms[j].expr.has(v)).collect()
    }
}

/// Where terms with parameters inside may stand in an equation.
struct Place {
    /// Of which states and inputs they are functions.
    variables: Vec<bool>,
    /// The terms that they take the place of, and those that stay.
    group: Vec<usize>,
    kept: Vec<usize>,
    /// Plain terms that may stand beside them.
    beside: Vec<usize>,
    /// These terms.
    shaped: Vec<usize>,
}

/// A term with parameters inside for an equation.
struct Found {
    term: usize,
    /// Its parameters.
    at: Vec<f64>,
    /// The terms beside it.
    kept: Vec<usize>,
    score: f64,
    /// The score of the terms that it takes the place of.
    base: f64,
}

/// Terms of an equation that others take the place of.
struct Replaced<'a> {
    along: &'a Hypothesis,
    /// The equation.
    i: usize,
    /// The term with parameters inside, and those that stand beside it.
    term: usize,
    kept: &'a [usize],
    /// Whether no other equation has it.
    free: bool,
    /// These, and the other terms of the equation.
    all: Vec<usize>,
}
