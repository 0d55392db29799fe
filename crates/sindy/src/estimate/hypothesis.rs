//! One hypothesis and its score.

use std::cell::{Cell, OnceCell};
use std::ops::Range;

use ndarray::{Array2, s};

use super::problem::Problem;
use super::regression::{Inside, Proposal};
use super::size::Size;
use crate::Stage;
use crate::data::{Segment, measures};
use crate::library::Shape;
use crate::motion::Stepping;
use crate::shooting::{self, Bounds, Fit, Flow, PARTS, Samples, Work};
use crate::solve::binomial;

/// Terms of every equation, a way of stepping, and what fits them best.
#[derive(Debug, Clone)]
pub(super) struct Hypothesis {
    /// Terms of each state's equation, ascending; none for states with declared rates.
    pub(super) supports: Vec<Vec<usize>>,
    pub(super) flow: Flow,
    pub(super) fit: Fit,
    /// Its terms with parameters inside.
    pub(super) inside: Vec<Inside>,
    /// Smaller is better.
    pub(super) score: f64,
    /// The part of the score by which terms are believed to be no larger than the rates.
    pub(super) size: f64,
    /// The largest contribution of a term to the rates, of each equation, as a multiple of these.
    pub(super) contributions: Vec<f64>,
    /// Whether what is left is no more than the finest Runge–Kutta steps are wrong.
    pub(super) numerical: bool,
    /// Number of the [`PARTS`] with which it was fitted last.
    pub(super) part: usize,
    /// Its innovations, once somebody asked; none where a step of it is not finite.
    innovations: OnceCell<Option<Vec<Array2<f64>>>>,
}

/// Where the fit of a hypothesis begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start<'a> {
    /// Coefficients, equation by equation.
    pub(super) xi: &'a [f64],
    /// Parameters inside terms as they are fitted; for others the terms say where to begin.
    pub(super) inside: &'a [Inside],
    /// States (T + 1, n) of each segment.
    pub(super) x: &'a [Array2<f64>],
    /// Standard deviations of the noise (n).
    pub(super) sigma: &'a [f64],
}

impl Hypothesis {
    /// Its coefficients, equation by equation.
    pub(super) fn coefficients(&self) -> &[f64] {
        &self.fit.xi[..self.supports.iter().map(Vec::len).sum()]
    }

    /// Its equation `i`, as a proposal for others.
    pub(super) fn equation(&self, i: usize) -> Proposal {
        let first: usize = self.supports[..i].iter().map(Vec::len).sum();
        let support = self.supports[i].clone();
        let coefficients = self.fit.xi[first..first + support.len()].to_vec();
        let inside = self.inside.iter().filter(|(j, _)| support.contains(j)).cloned().collect();
        Proposal { support, coefficients, inside, score: self.score, residual: 0.0 }
    }

    /// This hypothesis along some `steps` of its path alone: numbers of segments, and of the steps in these.
    pub(super) fn part_of(&self, steps: &[(usize, Range<usize>)]) -> Self {
        let path =
            |(at, steps): &(usize, Range<usize>)| self.fit.x[*at].slice(s![steps.start..=steps.end, ..]).to_owned();
        let mut part = Self { innovations: OnceCell::new(), ..self.clone() };
        part.fit.x = steps.iter().map(path).collect();
        part
    }

    /// Its prediction errors, per segment of `problem`, in units of their standard deviations (·, n).
    pub(super) fn innovations(&self, problem: &Problem<'_>) -> Option<&[Array2<f64>]> {
        let Self { flow, fit, part, .. } = self;
        let (segments, go_on) = (problem.segments, problem.watch.asks());
        let of =
            |work: &Work| shooting::innovations(flow, segments, (&fit.xi, &fit.x), &fit.sigma, *part, (work, go_on));
        let found = || problem.working(of);
        self.innovations.get_or_init(found).as_deref()
    }

    /// The same with the coefficients and parameters of `fit`, which are those of this one moved as a linearisation tells. Where parameters inside terms are moved farther than
    /// that holds, so that the equations follow the data worse than it says, they stay, with the standard errors of `fit`.
    pub(super) fn moved(self, fit: Fit, problem: &Problem<'_>) -> Self {
        let mut rest = &fit.xi[self.coefficients().len()..];
        let mut inside = Vec::new();
        for (j, own) in &self.inside {
            let (values, later) = rest.split_at(own.len());
            inside.push((*j, values.to_vec()));
            rest = later;
        }
        let moved = Self { fit, inside, innovations: OnceCell::new(), ..self.clone() };
        if self.inside.is_empty() {
            return moved;
        }
        let shift = moved.fit.xi.iter().zip(&self.fit.xi).map(|(to, from)| to - from).enumerate();
        let costs = self.fit.triangle.combined(&[shift.collect()]).norm(0).powi(2);
        let left = |of: &Self| {
            let squares = of.innovations(problem)?.iter().flatten().map(|v| v * v).sum::<f64>();
            Some(squares).filter(|squares| squares.is_finite())
        };
        match (left(&self), left(&moved)) {
            (Some(before), Some(after)) if after <= before + 2.0 * costs + TOLD_APART => moved,
            _ => {
                let Fit { errors, triangle, .. } = moved.fit;
                Self { fit: Fit { errors, triangle, ..self.fit }, ..self }
            }
        }
    }

    /// Where a fit begins that goes on from this one.
    pub(super) fn start(&self) -> Start<'_> {
        Start { xi: self.coefficients(), inside: &self.inside, x: &self.fit.x, sigma: &self.fit.sigma }
    }
}

/// Difference of scores above which two hypotheses are told apart: odds of twenty to one.
pub(super) const TOLD_APART: f64 = 6.0;

/// Multiple of the smallest error that is believed, up to which an error is that.
pub(super) const FLOOR: f64 = 1.5;

/// Part of the noise by which one step may be wrong numerically.
const TRUNCATION: f64 = 3e-3;

/// Runge–Kutta steps per sampling interval, at most; and while states follow the data.
const FINEST: usize = 32;
const LOOSE: usize = 4;

/// Classical substeps of a model per sampling interval, at most.
const FINEST_CLASSICAL: usize = 64;

/// Part of what the signals tell of noise, below which residuals are no noise.
const BELOW: f64 = 0.1;

/// Steps by which the error of Runge–Kutta steps is judged.
const LOOKED_AT: usize = 200;

/// Operations of all fits and regressions together, of about a nanosecond each.
const BUDGET: u64 = 6_000_000_000;

/// Samples for which all of them may be spent, and the part that may be for the fewest.
const SAMPLES: f64 = 300.0;
const FEWEST: f64 = 0.1;

/// Part of the budget of a search that is kept for finishing what it found.
const RESERVE: f64 = 0.25;

/// Operations of a search in `segments` that makes the part `effort` of the usual effort. Few samples do not tell many sets of terms apart, however many are
/// tried.
pub(crate) fn budget(effort: f64, segments: &[Segment]) -> u64 {
    let samples: usize = segments.iter().map(|s| s.x.nrows()).sum();
    (effort * (samples as f64 / SAMPLES).clamp(FEWEST, 1.0) * BUDGET as f64) as u64
}

impl Problem<'_> {
    /// The hypothesis that equations have the terms `supports`, fitted from `start`. `None` if such equations cannot follow the data.
    pub(super) fn hypothesis(
        &self,
        supports: Vec<Vec<usize>>,
        stepping: Stepping,
        start: Start<'_>,
        parts: std::ops::Range<usize>,
    ) -> Option<Hypothesis> {
        let free = self.free(&supports);
        let structure = (&supports[..], &self.given()[..], &free[..]);
        let flow = Flow::new(self.terms, structure, self.rates, self.n_controls, stepping);
        let mut xi = start.xi.to_vec();
        for (j, shape) in free.iter().filter_map(|&j| Some((j, self.terms[j].shape.as_ref()?))) {
            xi.extend(start.inside.iter().find(|(k, _)| *k == j).map_or_else(|| shape.start(), |(_, v)| v.clone()));
        }
        let (x, sigma) = (start.x, start.sigma);
        // States that are free to follow the data need no digit of the equations.
        let finest = if parts.end < PARTS.len() { LOOSE } else { FINEST };
        let mut flow = self.accurate(flow, (stepping, finest), &xi, x, sigma);
        let mut fit = self.may_spend().then(|| self.fit(&flow, (&xi, x), sigma, parts.clone()))??;
        loop {
            // What is left may be less than was thought, and the steps then too coarse for it.
            let finer = self.accurate(flow.clone(), (flow.stepping(), finest), &fit.xi, &fit.x, &fit.sigma);
            if finer.stepping() == flow.stepping() || !self.may_spend() {
                break;
            }
            let from = (&fit.xi[..], &fit.x[..]);
            let Some(better) = self.fit(&finer, from, &fit.sigma, parts.clone()) else { break };
            (flow, fit) = (finer, better);
        }
        if !flow.is_regular(self.segments, &fit.x, &fit.xi) {
            return None;
        }
        let mut rest = &fit.xi[..];
        for (support, constraints) in supports.iter().zip(self.constraints) {
            let (own, later) = rest.split_at(support.len());
            if !constraints.agrees(support, own) {
                return None;
            }
            rest = later;
        }
        let mut inside = Vec::new();
        let mut rest = &fit.xi[start.xi.len()..];
        for (j, shape) in free.iter().filter_map(|&j| Some((j, self.terms[j].shape.as_ref()?))) {
            let (own, later) = rest.split_at(shape.len());
            if !shape.is_within(own) {
                return None;
            }
            inside.push((j, own.to_vec()));
            rest = later;
        }
        // Bounds on the noise keep a residual from counting for less than it is told, not for less than it is.
        let left = fit.left.iter().zip(&fit.drift).map(|(left, drift)| left.hypot(*drift));
        let seen: Vec<f64> = left.zip(&fit.sigma).map(|(left, sigma)| left.max(*sigma)).collect();
        let Size { size, contributions } = self.size(&supports, &flow, &fit);
        let score = self.score(&supports, &seen) + size + fit.expansion;
        let numerical = finest == FINEST && self.is_numerical(&flow, &fit);
        let part = parts.end.min(PARTS.len()).saturating_sub(1);
        let innovations = OnceCell::new();
        let found =
            Hypothesis { supports, flow, fit, inside, score, size, contributions, numerical, part, innovations };
        found.score.is_finite().then_some(found)
    }

    fn fit(
        &self,
        flow: &Flow,
        from: (&[f64], &[Array2<f64>]),
        sigma: &[f64],
        parts: std::ops::Range<usize>,
    ) -> Option<Fit> {
        let noise = Bounds { floor: self.floor, shape: self.noise };
        self.working(|work| shooting::fit(flow, self.segments, from, sigma, noise, parts, (work, self.watch.asks())))
    }

    /// Whether there is budget left; if not, something is passed over now.
    pub(super) fn may_spend(&self) -> bool {
        let left = self.spent.get() < self.budget;
        if !left {
            self.spent.set(self.budget + 1);
        }
        left && self.watch.go_on()
    }

    /// Takes `operations` from the budget, or what is left of it.
    pub(super) fn charge(&self, operations: u64) {
        let spent = self.spent.get();
        self.spent.set(spent.max(self.budget.min(spent.saturating_add(operations))));
        self.watch.tell(Stage::Search { spent: (self.spent.get() as f64 / BUDGET as f64).min(1.0) });
    }

    /// What `of` comes to, which may spend no more than `share` of the budget of a whole search. What there was no budget for was not spent.
    pub(super) fn with_share<T>(&self, share: f64, of: impl FnOnce(&Problem<'_>) -> T) -> T {
        let budget = self.budget.min(self.spent.get() + (share * self.whole as f64) as u64);
        let done = of(&Problem { budget, ..*self });
        self.spent.set(self.spent.get().min(budget));
        done
    }

    /// What `of` comes to, for which there is a budget beyond that of the search: what was found is finished even if nothing more is looked for.
    pub(super) fn with_reserve<T>(&self, of: impl FnOnce(&Problem<'_>) -> T) -> T {
        let spent = Cell::new(self.spent.get());
        let budget = self.budget + (RESERVE * self.whole as f64) as u64;
        let done = of(&Problem { budget, spent: &spent, ..*self });
        self.spent.set(spent.get().min(self.spent.get().max(self.budget)));
        done
    }

    /// What `of` comes to, with the work that it does taken from the budget.
    pub(super) fn working<T>(&self, of: impl FnOnce(&Work) -> T) -> T {
        let work = Work::default();
        let done = of(&work);
        self.charge(work.operations());
        done
    }

    /// `flow` with as many Runge–Kutta steps as the noise makes worth while.
    fn accurate(
        &self,
        flow: Flow,
        (stepping, finest): (Stepping, usize),
        xi: &[f64],
        x: &[Array2<f64>],
        sigma: &[f64],
    ) -> Flow {
        let Stepping::Continuous { substeps: first } = stepping else { return flow };
        let of = |substeps: usize| flow.with_stepping(Stepping::Continuous { substeps });
        let mut substeps = first;
        while substeps < finest {
            let (coarse, fine) = (of(substeps), of(2 * substeps));
            if self.difference(&coarse, &fine, xi, x, sigma) < TRUNCATION * 16.0 / 15.0 {
                break;
            }
            substeps *= 2;
        }
        of(substeps)
    }

    /// The way `hypothesis` is stepped by classical substeps, as many as the noise makes worth while.
    pub(super) fn classical(&self, hypothesis: &Hypothesis) -> Stepping {
        let (flow, fit) = (&hypothesis.flow, &hypothesis.fit);
        let Stepping::Continuous { substeps: first } = flow.stepping() else { return flow.stepping() };
        let of = |substeps: usize| flow.with_stepping(Stepping::Classical { substeps });
        let mut substeps = first;
        while substeps < FINEST_CLASSICAL
            && self.difference(&of(substeps), flow, &fit.xi, &fit.x, &fit.sigma) > TRUNCATION
        {
            substeps *= 2;
        }
        Stepping::Classical { substeps }
    }

    /// Whether the errors of the finest Runge–Kutta steps add up to the residuals along a segment.
    fn is_numerical(&self, flow: &Flow, fit: &Fit) -> bool {
        let finer = flow.with_stepping(Stepping::Continuous { substeps: 2 * FINEST });
        let length = self.samples() / self.segments.len().max(1) as f64;
        // Of samples with noise the steps are no limit, whatever equations make of them.
        let below = |(left, noise): (&f64, &f64)| *left < BELOW * noise;
        flow.stepping() == Stepping::Continuous { substeps: FINEST }
            && fit.left.iter().zip(self.noise).all(below)
            && self.difference(flow, &finer, &fit.xi, &fit.x, &fit.sigma) * length > 1.0
    }

    /// RMS difference of the steps of two flows, in standard deviations of the noise.
    pub(super) fn difference(&self, a: &Flow, b: &Flow, xi: &[f64], x: &[Array2<f64>], sigma: &[f64]) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        let every = (self.samples() as usize).div_ceil(LOOKED_AT);
        for (segment, x) in self.segments.iter().zip(x) {
            let samples = Samples { segment, x, every };
            let steps = |flow: &Flow| {
                let mut all: Vec<Option<Vec<f64>>> = Vec::new();
                flow.each_step(samples, xi, false, &mut |made| {
                    all.push(made.finite.then(|| made.next.to_vec()));
                    true
                });
                all
            };
            for (left, right) in steps(a).into_iter().zip(steps(b)).filter_map(|(left, right)| left.zip(right)) {
                let squares = left.iter().zip(&right).zip(sigma).map(|((left, right), s)| ((left - right) / s).powi(2));
                sum += squares.sum::<f64>();
                count += left.len() as f64;
            }
        }
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// −2 ln L + Σ ln N + 2 ln C(F, k) + complexity: the extended BIC of the prediction error, with the noise of each channel at its
    /// likeliest.
    ///
    /// # References
    /// Chen, Chen (2008), Biometrika 95(3), with γ = 1.
    pub(super) fn score(&self, supports: &[Vec<usize>], sigma: &[f64]) -> f64 {
        let samples = self.samples();
        let measured = sigma.iter().enumerate().filter(|(i, _)| self.measures(*i));
        let likelihood: f64 = measured.map(|(_, s)| 2.0 * samples * s.ln()).sum();
        likelihood + supports.iter().map(|support| self.penalty(support)).sum::<f64>()
    }

    /// What the terms of one equation cost.
    pub(super) fn penalty(&self, support: &[usize]) -> f64 {
        self.n_parameters(support) as f64 * self.samples().ln() + self.prior(support)
    }

    /// Coefficients of the terms of one equation, and parameters inside them.
    pub(super) fn n_parameters(&self, support: &[usize]) -> usize {
        let inside = |j: usize| self.terms[j].shape.as_ref().map_or(0, Shape::len);
        support.iter().map(|&j| 1 + inside(j)).sum()
    }

    /// −2 ln of what is believed of the terms of one equation before there are data: how many others there are, and how simple they are.
    pub(super) fn prior(&self, support: &[usize]) -> f64 {
        let complexity: f64 = support.iter().map(|&j| f64::from(self.terms[j].complexity)).sum();
        let quotients = self.quotients();
        let kinds = [0..self.n_plain, self.n_plain..quotients.start, quotients];
        let chosen = |kind: &Range<usize>| support.iter().filter(|&j| kind.contains(j)).count();
        let ways: f64 = kinds.iter().map(|kind| binomial(kind.len(), chosen(kind))).product();
        2.0 * ways.ln() + complexity
    }

    /// The quotients by one variable: the last terms.
    pub(super) fn quotients(&self) -> Range<usize> {
        let shaped = self.terms[self.n_plain..].iter().take_while(|term| term.shape.is_some()).count();
        self.n_plain + shaped..self.terms.len()
    }

    /// The terms with parameters inside, ascending.
    pub(super) fn free(&self, supports: &[Vec<usize>]) -> Vec<usize> {
        let mut free: Vec<usize> =
            supports.iter().flatten().copied().filter(|&j| self.terms[j].shape.is_some()).collect();
        free.sort_unstable();
        free.dedup();
        free
    }

    /// Whether state `i` was measured.
    pub(super) fn measures(&self, i: usize) -> bool {
        measures(self.segments, i)
    }

    pub(super) fn samples(&self) -> f64 {
        self.segments.iter().map(|s| s.x.nrows() as f64).sum()
    }
}
