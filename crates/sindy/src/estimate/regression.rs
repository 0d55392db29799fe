//! The terms that one regression proposes.

use super::constraints::Constraints;
use crate::Triangle;
use crate::solve::{Candidates, SizeReport, Subset};

/// The regression of one equation.
#[derive(Debug, Clone)]
pub(super) struct Regression {
    /// The best subsets of each size, by columns.
    pub(super) found: Candidates,
    pub(super) triangle: Triangle,
    /// The smallest mean square of what is left that is believed.
    pub(super) least: f64,
    /// The term of each column of the triangle.
    pub(super) choice: Vec<usize>,
    /// How many of these, the first ones, are required; what was found is a choice of the others.
    pub(super) n_required: usize,
    /// The multiple of the derivative that was taken from the last column.
    pub(super) own: Option<f64>,
    pub(super) constraints: Constraints,
}

/// A term and the parameters inside it, as they are fitted.
pub(super) type Inside = (usize, Vec<f64>);

/// Terms proposed for one equation.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Proposal {
    pub(super) support: Vec<usize>,
    pub(super) coefficients: Vec<f64>,
    /// Where parameters inside terms begin; for others the terms say so.
    pub(super) inside: Vec<Inside>,
    /// Smaller is better.
    pub(super) score: f64,
    /// RMS of what is left, whitened.
    pub(super) residual: f64,
}

impl Regression {
    /// Of an equation that is not fitted.
    pub(super) fn none() -> Self {
        let (found, triangle, constraints) = (Candidates::default(), Triangle::new(1), Constraints::default());
        Self { found, triangle, least: 0.0, choice: Vec::new(), n_required: 0, own: None, constraints }
    }

    /// The terms with the best score when every term costs `times` what `penalty` says.
    ///
    /// Errors of the path are not independent from row to row, so the rows tell less than their number, nobody knows how much
    /// less.
    pub(super) fn best(&self, times: f64, penalty: impl Fn(&[usize]) -> f64) -> Proposal {
        let scored = self.scored(times, penalty);
        let best = scored.min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((score, subset)) => self.proposal(score, subset),
            None => Proposal {
                support: Vec::new(),
                coefficients: Vec::new(),
                inside: Vec::new(),
                score: 0.0,
                residual: f64::INFINITY,
            },
        }
    }

    /// At most `most` proposals whose scores are within `gap` of the best one, best first.
    pub(super) fn near_best(&self, gap: f64, most: usize, penalty: impl Fn(&[usize]) -> f64) -> Vec<Proposal> {
        let mut scored: Vec<(f64, &Subset)> = self.scored(1.0, penalty).collect();
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = scored.first().map_or(0.0, |s| s.0);
        scored.iter().take(most).filter(|s| s.0 <= least + gap).map(|s| self.proposal(s.0, s.1)).collect()
    }

    fn scored(&self, times: f64, penalty: impl Fn(&[usize]) -> f64) -> impl Iterator<Item = (f64, &Subset)> {
        let possible = |s: &&Subset| s.rss.is_finite() && self.has_signs(s);
        let subsets = self.found.sizes.iter().flat_map(|(subsets, _)| subsets).filter(possible);
        subsets.map(move |subset| (self.score(times, subset, &penalty), subset))
    }

    pub(super) fn score(&self, times: f64, subset: &Subset, penalty: impl Fn(&[usize]) -> f64) -> f64 {
        self.likelihood(subset.support.len(), subset.rss) + times * penalty(&self.terms(subset))
    }

    /// −2 ln L of `size` terms that leave the sum of squares `rss`.
    pub(super) fn likelihood(&self, size: usize, rss: f64) -> f64 {
        let rows = self.triangle.n_rows() as f64;
        let free = (rows - size as f64).max(1.0);
        rows * (rss / free).max(self.least).max(f64::MIN_POSITIVE).ln()
    }

    /// The columns of a subset, those of required terms among them.
    fn columns(&self, subset: &Subset) -> Vec<usize> {
        (0..self.n_required).chain(subset.support.iter().map(|c| self.n_required + c)).collect()
    }

    /// The terms of a subset, ascending.
    pub(super) fn terms(&self, subset: &Subset) -> Vec<usize> {
        let mut terms: Vec<usize> = self.columns(subset).into_iter().map(|c| self.choice[c]).collect();
        terms.sort_unstable();
        terms
    }

    /// Whether the coefficients have the signs they should.
    pub(super) fn has_signs(&self, subset: &Subset) -> bool {
        self.constraints.signs.is_empty() || {
            let columns = self.columns(subset);
            let coefficients = self.triangle.solve_unit(&columns, self.choice.len());
            let terms: Vec<usize> = columns.into_iter().map(|c| self.choice[c]).collect();
            self.constraints.agrees(&terms, &coefficients)
        }
    }

    /// Terms whose declared sign the data contradict: those of wrong sign, with their coefficients, among the terms with the best score of all, if
    /// this is better by `gap` than that of all terms with the declared signs.
    pub(super) fn contradicted(&self, gap: f64, penalty: impl Fn(&[usize]) -> f64) -> Vec<(usize, f64)> {
        if self.constraints.signs.is_empty() {
            return Vec::new();
        }
        let subsets = self.found.sizes.iter().flat_map(|(subsets, _)| subsets).filter(|s| s.rss.is_finite());
        let scored = subsets.map(|subset| (self.score(1.0, subset, &penalty), subset));
        let Some((score, best)) = scored.min_by(|a, b| a.0.total_cmp(&b.0)) else { return Vec::new() };
        let allowed = self.scored(1.0, &penalty).fold(f64::INFINITY, |least, (score, _)| least.min(score));
        if allowed <= score + gap {
            return Vec::new();
        }
        let columns = self.columns(best);
        let coefficients = self.triangle.solve_unit(&columns, self.choice.len());
        let terms = columns.into_iter().map(|c| self.choice[c]).zip(coefficients);
        terms.filter(|(j, c)| !self.constraints.agrees(&[*j], &[*c])).collect()
    }

    pub(super) fn proposal(&self, score: f64, subset: &Subset) -> Proposal {
        let columns = self.columns(subset);
        let mut coefficients = self.triangle.solve_unit(&columns, self.choice.len());
        if let Some(c) = self.own
            && let Some(at) = columns.iter().position(|&column| column + 1 == self.choice.len())
        {
            // ẋ = Σ a θ + b (f ẋ − c ẋ)
            let whole = 1.0 + c * coefficients[at];
            coefficients.iter_mut().for_each(|a| *a /= whole);
        }
        let residual = (subset.rss / self.triangle.n_rows().max(1) as f64).sqrt();
        let mut told: Vec<(usize, f64)> = columns.iter().map(|&c| self.choice[c]).zip(coefficients).collect();
        told.sort_by_key(|(j, _)| *j);
        let (support, coefficients) = told.into_iter().unzip();
        Proposal { support, coefficients, inside: Vec::new(), score, residual }
    }

    /// Terms of `support`, each with another that has the same values on all data, up to a factor.
    pub(super) fn twins(&self, support: &[usize]) -> Vec<(usize, usize)> {
        let term = |c: usize| self.choice[self.n_required + c];
        let pair = |&(out, kept): &(usize, usize)| {
            let pairs = [(term(kept), term(out)), (term(out), term(kept))];
            pairs.into_iter().find(|(own, _)| support.contains(own))
        };
        self.found.equal.iter().filter_map(pair).collect()
    }

    /// Whether `other` has terms of `own` and, in the place of the rest, terms that have the same values on all data, up to a factor.
    pub(super) fn are_twins(&self, own: &[usize], other: &[usize]) -> bool {
        let twins = self.twins(own);
        let stands_for = |j: usize, k: usize| j == k || twins.contains(&(j, k));
        own.len() == other.len()
            && own.iter().all(|&j| other.iter().any(|&k| stands_for(j, k)))
            && other.iter().all(|&k| own.iter().any(|&j| stands_for(j, k)))
    }

    /// The best subset of each size, for people to look at; residuals in standard deviations of the noise.
    pub(super) fn path(&self) -> Vec<SizeReport> {
        let rows = self.triangle.n_rows() as f64;
        let best = self.found.sizes.iter().filter_map(|(subsets, proved)| Some((subsets.first()?, *proved)));
        best.map(|(subset, proved)| {
            let free = (rows - subset.support.len() as f64).max(1.0);
            SizeReport { support: self.terms(subset), residual: (subset.rss / free).sqrt(), proved }
        })
        .collect()
    }
}
