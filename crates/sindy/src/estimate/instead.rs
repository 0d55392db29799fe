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
        let places = self.places_inside(best, i);
        let mut found: Vec<(&Place, Found)> = Vec::new();
        for place in &places {
            if !self.may_spend() {
                return Vec::new();
            }
            let looked = self.looked(along, i, place);
            found.extend(problem.linearised_inside((along, i), place, &looked).into_iter().map(|found| (place, found)));
        }
        found.sort_by(|a, b| a.1.score.total_cmp(&b.1.score));
        found.truncate(CLOSELY);
        let proposed = |(place, found)| problem.with_parameters((along, i), place, found);
        self.best_of_families(found.into_iter().filter_map(proposed).collect())
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

    /// Terms that may stand at `place` in equation `i` of `along`, each with some of its parameters.
    fn looked(&self, along: &Hypothesis, i: usize, place: &Place) -> Vec<(usize, Vec<f64>)> {
        let (mut looked, elsewhere) = (Vec::<(usize, Vec<f64>)>::new(), self.elsewhere(along, i));
        for &j in &place.shaped {
            let Some(shape) = &self.terms[j].shape else { continue };
            let known =
                along.inside.iter().find(|(k, _)| *k == j && elsewhere.contains(k)).map(|(_, at)| vec![at.clone()]);
            let all = known.or_else(|| shape.between(SCANNED)).unwrap_or_else(|| vec![shape.start()]);
            let is_new = |at: &Vec<f64>| !looked.iter().any(|(k, other)| self.are_alike(&[*k], &[j]) && other == at);
            looked.extend(all.into_iter().filter(is_new).map(|at| (j, at)).collect::<Vec<_>>());
        }
        looked
    }

    /// Of each family of terms `looked` at, which may stand at `place` in equation `i`, linearised at its parameters, what explains most beside plain terms there.
    fn linearised_inside(
        &self,
        (along, i): (&Hypothesis, usize),
        place: &Place,
        looked: &[(usize, Vec<f64>)],
    ) -> Vec<Found> {
        let (own, elsewhere) = (&along.supports[i], self.elsewhere(along, i));
        let (mut terms, first) = (self.terms.to_vec(), self.terms.len());
        let mut inside = Vec::with_capacity(looked.len());
        for (j, at) in looked {
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
        for (inside, (j, at)) in inside.iter().zip(looked) {
            let (inside, parameters) = (columns(inside), self.n_parameters(&[*j]));
            let Some(rest) = inside.iter().try_fold(rest.clone(), |rest, &c| rest.and(c)) else { continue };
            let (ways, work) = rest.forward(&columns(&place.beside), most - parameters);
            self.charge(work);
            let scored = |(chosen, left): (Vec<usize>, f64)| {
                let beside = chosen.iter().map(|&c| choice[c]);
                let kept: Vec<usize> = place.kept.iter().copied().chain(beside).collect();
                let support = [&kept[..], &[*j]].concat();
                (likelihood(triangle.n_rows(), support.len(), (left, least)) + self.penalty(&support), kept)
            };
            let best = ways.into_iter().map(scored).min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((score, kept)) = best else { continue };
            let known = found.iter().position(|other| self.are_alike(&[other.term], &[*j]));
            if known.is_some_and(|at| found[at].score <= score) {
                continue;
            }
            let all: Vec<usize> = columns(&kept).into_iter().chain(inside).collect();
            let target = triangle.n_columns() - 1;
            // With its slopes a coefficient says nothing of its own.
            let own = triangle.solve_unit(&all[..=kept.len()], target).last().copied().unwrap_or(0.0);
            let coefficients = triangle.solve_unit(&all, target);
            let best = Found { term: *j, at: at.clone(), kept, coefficients, own, score, base };
            match known {
                Some(at) => found[at] = best,
                None => found.push(best),
            }
        }
        found
    }

    /// What was `found` for equation `i` of `along`, with its parameters fitted and the terms beside it chosen anew; `None` if it explains much less than the terms of `along` do.
    fn with_parameters(&self, (along, i): (&Hypothesis, usize), place: &Place, mut found: Found) -> Option<Proposal> {
        let shape = self.terms[found.term].shape.as_ref()?;
        for _ in 0..REFINED {
            let changes = found.coefficients[found.kept.len() + 1..].iter();
            let step: Vec<f64> = changes.map(|change| (change / found.own).clamp(-BELIEVED, BELIEVED)).collect();
            let part =
                |part: &f64| found.at.iter().zip(&step).map(|(v, change)| v + part * change).collect::<Vec<f64>>();
            let to = PARTS.iter().map(part).find(|at| shape.is_within(at));
            let stays = step.iter().all(|change| change.abs() < STAYS);
            let Some(at) = to.filter(|_| !stays && self.may_spend()) else { break };
            found = self.linearised_inside((along, i), place, &[(found.term, at)]).pop()?;
        }
        let Found { term, at, kept, coefficients, own, score, base } = found;
        let slopes = (0..coefficients.len() - kept.len() - 1).collect();
        let candidate = Candidate { term, slopes };
        let support = [&kept[..], &[term]].concat();
        let proposal = self.proposed((&candidate, &at), support, coefficients, (score, own))?;
        (score - base <= NEAR).then_some(proposal)
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
    /// Coefficients of these, of the term, and of its slopes; and that of the term without slopes.
    coefficients: Vec<f64>,
    own: f64,
    score: f64,
    /// The score of the terms that it takes the place of.
    base: f64,
}
