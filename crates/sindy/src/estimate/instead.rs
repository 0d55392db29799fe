//! One term with parameters inside instead of several of the same variables.
//!
//! Sums of powers, exponentials and waves say within noise what a single function of the same variables says, and no term after the other leads from these to that.

use super::exchange::NEAR;
use super::hypothesis::Hypothesis;
use super::inside::{BELIEVED, Candidate};
use super::problem::Problem;
use super::regression::Proposal;
use super::search::SAMPLE;
use crate::data::{sample_of, stretches};
use crate::library::Term;

/// Values of a single parameter that are looked at, between its bounds.
const SCANNED: usize = 16;

/// Times that a term is linearised where its parameters are best, at most, and the parts of a step that are tried then.
const REFINED: usize = 4;
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.1];

/// Change of a parameter below which it is not fitted further.
const STAYS: f64 = 0.01;

impl Problem<'_> {
    /// Proposals for equation `i` of `best` with one term that has parameters inside in place of all terms that are functions of the same variables, alone or beside a constant or a variable, where these have as
    /// many parameters or more: the best of each of the best families. Of long data a part tells them.
    pub(super) fn instead(&self, best: &Hypothesis, i: usize) -> Vec<Proposal> {
        let own = &best.supports[i];
        let mut groups: Vec<Vec<bool>> = Vec::new();
        let is_free = |j: usize| self.terms[j].rate.is_none() && !self.required(i).contains(&j);
        for &j in own.iter().filter(|&&j| is_free(j)) {
            let variables = self.variables(j);
            if !groups.contains(&variables) {
                groups.push(variables);
            }
        }
        let sample = self.is_long().then(|| sample_of(self.segments, SAMPLE));
        let part = sample.as_ref().map(|_| best.part_of(&stretches(self.segments, SAMPLE)));
        let problem = Problem { segments: sample.as_deref().unwrap_or(self.segments), ..*self };
        let along = part.as_ref().unwrap_or(best);
        let mut found = Vec::new();
        for variables in groups {
            let (group, kept): (Vec<usize>, Vec<usize>) =
                own.iter().partition(|&&j| is_free(j) && self.variables(j) == variables);
            if group.len() < 2 {
                continue;
            }
            let fits = |terms: &[usize]| self.n_parameters(terms) <= self.n_parameters(&group);
            let may = |j: &usize| self.variables(*j) == variables && fits(&[*j]) && self.may_be_added(best, i, *j);
            let is_beside =
                |j: usize| self.is_constant(j) || (self.is_variable(j) && self.variables(j) == variables && is_free(j));
            let beside: Vec<usize> = (0..self.n_plain).filter(|&j| is_beside(j) && !kept.contains(&j)).collect();
            let mut families: Vec<Vec<usize>> = Vec::new();
            for j in (self.n_plain..self.terms.len()).filter(may) {
                match families.iter_mut().find(|family| self.are_alike(&[family[0]], &[j])) {
                    Some(family) => family.push(j),
                    None => families.push(vec![j]),
                }
            }
            for family in families {
                if !self.may_spend() {
                    return Vec::new();
                }
                found.extend(problem.in_place((along, i), &kept, &family));
                for &j in beside.iter().filter(|&&j| fits(&[j, family[0]])) {
                    found.extend(problem.in_place((along, i), &[&kept[..], &[j]].concat(), &family));
                }
            }
        }
        self.best_of_families(found)
    }

    /// The terms `kept` of equation `i` with one of a `family`, whose parameters are fitted along `along`; `None` if it explains much less than the terms of `along` do.
    fn in_place(&self, (along, i): (&Hypothesis, usize), kept: &[usize], family: &[usize]) -> Option<Proposal> {
        let mut looked: Vec<(usize, Vec<f64>)> = Vec::new();
        for &j in family {
            let shape = self.terms[j].shape.as_ref()?;
            match shape.between(SCANNED) {
                Some(values) if looked.is_empty() => looked.extend(values.into_iter().map(|at| (j, at))),
                Some(_) => {}
                None => looked.push((j, shape.start())),
            }
        }
        let own = &along.supports[i];
        let added = kept.iter().copied().filter(|k| !own.contains(k));
        let all: Vec<usize> = own.iter().copied().chain(added).collect();
        let places = kept.iter().filter_map(|k| all.iter().position(|o| o == k)).collect();
        let replaced = Replaced { along, i, kept, all, places };
        let (base, scores) = self.scores(&replaced, &looked)?;
        let ranked = looked.into_iter().zip(scores).min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        let ((j, mut at), mut now) = ranked?;
        for _ in 0..REFINED {
            let Some(step) = self.step(&replaced, j, &at).filter(|_| self.may_spend()) else { break };
            if step.iter().all(|change| change.abs() < STAYS) {
                break;
            }
            let shape = self.terms[j].shape.as_ref()?;
            let part = |part: &f64| at.iter().zip(&step).map(|(v, change)| v + part * change).collect::<Vec<f64>>();
            let tried: Vec<(usize, Vec<f64>)> =
                PARTS.iter().map(part).filter(|at| shape.is_within(at)).map(|at| (j, at)).collect();
            let (_, scores) = self.scores(&replaced, &tried)?;
            let better = tried.into_iter().zip(scores).min_by(|a, b| a.1.0.total_cmp(&b.1.0));
            let Some(((_, to), better)) = better.filter(|(_, better)| better.0 < now.0) else { break };
            (at, now) = (to, better);
        }
        let (score, coefficients) = now;
        let candidate = Candidate { term: j, slopes: Vec::new() };
        let own = coefficients.last().copied().filter(|_| score - base <= NEAR)?;
        let proposal = self.proposed((&candidate, &at), [kept, &[j]].concat(), coefficients, (score, own))?;
        Some(Proposal { inside: vec![(j, at)], ..proposal })
    }

    /// The score of the terms of `along`, and those with one of these in place of some, each with its coefficients.
    fn scores(&self, replaced: &Replaced<'_>, looked: &[(usize, Vec<f64>)]) -> Option<(f64, Vec<Scored>)> {
        let Replaced { along, i, kept, all, places } = replaced;
        let (own, least, mut terms) = (&along.supports[*i], self.least_near(along), self.terms.to_vec());
        let first = terms.len();
        for (j, at) in looked {
            let expr = self.terms[*j].shape.as_ref()?.at(at);
            terms.push(Term { expr, shape: None, ..self.terms[*j].clone() });
        }
        let choice: Vec<usize> = all.iter().copied().chain(first..terms.len()).collect();
        let triangle = self.triangle_near(&terms, along, *i, &choice)?;
        let base = self.scored_columns((&triangle, least), &(0..own.len()).collect::<Vec<_>>(), own).0;
        let of = |(at, (j, _)): (usize, &(usize, Vec<f64>))| {
            let columns = [&places[..], &[all.len() + at]].concat();
            self.scored_columns((&triangle, least), &columns, &[&kept[..], &[*j]].concat())
        };
        Some((base, looked.iter().enumerate().map(of).collect()))
    }

    /// What a step of Gauss–Newton changes of the parameters inside the term `j`, which are `at`.
    fn step(&self, replaced: &Replaced<'_>, j: usize, at: &[f64]) -> Option<Vec<f64>> {
        let Replaced { along, i, kept, all, places } = replaced;
        let (least, mut terms) = (self.least_near(along), self.terms.to_vec());
        terms[j].expr = self.terms[j].shape.as_ref()?.at(at);
        let first = terms.len();
        terms.extend(self.slopes(j, at));
        let candidate = Candidate { term: j, slopes: (first..terms.len()).collect() };
        let choice: Vec<usize> = all.iter().copied().chain(candidate.columns()).collect();
        let triangle = self.triangle_near(&terms, along, *i, &choice)?;
        let columns: Vec<usize> = places.iter().copied().chain(all.len()..choice.len()).collect();
        let support = [&kept[..], &[j]].concat();
        // From where the coefficient is without the slopes: with them it says nothing of its own.
        let (_, without) = self.scored_columns((&triangle, least), &columns[..support.len()], &support);
        let (_, with) = self.scored_columns((&triangle, least), &columns, &support);
        let coefficient = without.last().copied().filter(|c| *c != 0.0)?;
        let changes = with[support.len()..].iter().map(|change| (change / coefficient).clamp(-BELIEVED, BELIEVED));
        Some(changes.collect()).filter(|step: &Vec<f64>| step.iter().all(|change| change.is_finite()))
    }

    /// Of which states and inputs the term `j` is a function.
    fn variables(&self, j: usize) -> Vec<bool> {
        (0..self.rates.len() + self.n_controls).map(|v| self.terms[j].expr.has(v)).collect()
    }
}

/// A score, and the coefficients.
type Scored = (f64, Vec<f64>);

/// Terms of an equation that others take the place of.
struct Replaced<'a> {
    along: &'a Hypothesis,
    /// The equation.
    i: usize,
    /// Terms that stand beside the new one.
    kept: &'a [usize],
    /// Its terms, and those of `kept` that are new; the places of `kept` among them.
    all: Vec<usize>,
    places: Vec<usize>,
}
