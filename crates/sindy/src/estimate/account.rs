//! What was found, and how far to believe it.

use std::fmt;

use std::cell::OnceCell;

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use super::hypothesis::{FLOOR, Hypothesis, TOLD_APART};
use super::posterior::Posterior;
use super::problem::Problem;
use super::searched::Searched;
use crate::Expr;
use crate::data::Signals;
use crate::library::Term;
use crate::motion::Stepping;
use crate::solve::Selected;

/// Why an equation whose noise was estimated is not called adequate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Doubt {
    /// There are fewer than three samples for every term.
    TooFewSamples,
    /// What it leaves is correlated from sample to sample: a term is missing or approximated.
    Correlated,
    /// Other terms explain the data as well.
    OtherTerms,
    /// Inputs that are linear between samples explain the data better than held ones.
    NotHeld,
    /// Its coefficients differ between the first and the second half of the data: it approximates the true equation where the data
    /// are.
    Inconstant,
    /// The search for terms ended before it had tried all that it would.
    Unfinished,
    /// Its terms cancel to less than a thousandth of themselves: they are a series of the true ones.
    Cancelling,
    /// What it leaves counts as rounding, but is correlated, and would not be a thousand times as much without one of its terms: they are a series
    /// of the true ones.
    Series,
    /// It is coupled to the acceleration of another joint by other terms than that joint to its own: no matrix of masses is like that.
    Asymmetric,
    /// It has terms of a state that does not move by more than its noise: what that is cannot be told from a constant.
    Still,
    /// Neither it nor any other has a term: what varies is noise, or nothing that the candidate terms describe.
    NoMotion,
    /// It leaves ten times what the smoothness of the signal tells of its noise.
    Large,
    /// It leaves more than rounding, and there is said to be no other error.
    AboveRounding,
    /// A coefficient is less than two standard errors: its term explains a single sample, or nothing, or the equation may be multiplied by anything.
    Undetermined,
    /// It follows short pieces of the data alone, each from a start of its own; what disturbs the system between and in them is not known.
    Disturbed,
    /// Another lag of the inputs, with other coefficients, explains the data as well.
    OtherLag,
}

impl Doubt {
    /// Whether it is one of terms that are missing altogether, which spoils the other equations too.
    pub(crate) fn is_spoilt(self) -> bool {
        matches!(self, Self::Correlated | Self::Large | Self::Unfinished | Self::Disturbed)
    }

    /// Whether it is that other terms may be as good, and nothing speaks against these.
    pub(crate) fn is_of_rivals(self) -> bool {
        matches!(self, Self::OtherTerms | Self::Unfinished | Self::Undetermined | Self::OtherLag)
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewSamples => "fewer than three samples per term",
            Self::Correlated => "its residuals are correlated",
            Self::OtherTerms => "other terms fit the data equally well",
            Self::NotHeld => "inputs that are linear between samples fit the data better than held ones",
            Self::Inconstant => "its coefficients differ between the halves of the data",
            Self::Unfinished => "the search for its terms ended early",
            Self::Cancelling => "its terms cancel to less than a thousandth of their size",
            Self::Series => "its last terms explain little: they approximate others, as a series does",
            Self::Asymmetric => "its coupling to another joint is not symmetric, as that of masses is",
            Self::Still => "a state among its terms does not move by more than its noise",
            Self::NoMotion => "no equation has a term: no candidate term explains more than noise",
            Self::Large => "its residuals are ten times the noise that the smoothness of the signal allows",
            Self::Undetermined => "the data do not determine one of its coefficients",
            Self::AboveRounding => "its residuals are above the level of rounding",
            Self::OtherLag => "another lag of the inputs fits the data equally well",
            Self::Disturbed => "it was fitted to short pieces of the data, because the system is disturbed",
        })
    }
}

/// Equations found.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// The candidate terms, those in use with the parameters inside them that were found.
    pub(crate) terms: Vec<Term>,
    /// Numbers of the terms with parameters inside, and of each parameter its value and its standard error.
    pub(crate) inside: Vec<(usize, Vec<(f64, f64)>)>,
    /// One per state: terms, coefficients, the best subsets of each size. None for states with declared rates.
    pub(crate) fits: Vec<Selected>,
    /// Terms in use, each with a candidate that is the same on all data.
    pub(crate) twins: Vec<(usize, usize)>,
    /// Per state: the terms whose declared sign the data contradict, and the coefficients that they would have.
    pub(crate) contradicted: Vec<Vec<(usize, f64)>>,
    /// How many terms of each equation, the last ones, have coefficients that were given.
    pub(crate) n_known: Vec<usize>,
    /// Standard errors of the coefficients of each equation.
    pub(crate) errors: Vec<Vec<f64>>,
    pub(crate) stepping: Stepping,
    /// Condition number of the sensitivities of the trajectories to the coefficients.
    pub(crate) condition: f64,
    /// Standard deviation of the noise of each state, by what the equations leave.
    pub(crate) sigma: Vec<f64>,
    /// The same by how smooth the signals are, before any equation is known.
    pub(crate) signal_noise: Vec<f64>,
    /// Whether each state was measured (n).
    pub(crate) measured: Vec<bool>,
    /// Per state: the state that is its rate (n).
    pub(crate) rates: Vec<Option<usize>>,
    /// The states that follow the equations, at the samples of each segment (T + 1, n).
    pub(crate) path: Vec<Array2<f64>>,
    /// Smaller is better.
    pub(crate) score: f64,
    /// Steps left out as unlike all others.
    pub(crate) astray: usize,
    /// Share of the variance of each state's noise that grows with the square of its value (n).
    pub(crate) growing: Vec<f64>,
    /// Per state: why its equation is not adequate.
    pub(crate) doubts: Vec<Option<Doubt>>,
    /// Per state: 1 − ‖x measured − x‖ / ‖x measured − mean‖.
    pub(crate) fit: Vec<f64>,
    /// Whether no proposal was passed over because the budget was spent.
    pub(crate) complete: bool,
    /// The inputs that were corrected, and the distance of two neighbouring values as they were written.
    pub(crate) corrections: Vec<(usize, f64)>,
    /// Whether what is left of every state is below all that numbers can tell.
    pub(crate) leaves_nothing: bool,
    /// The largest error of each state that counts as rounding, if what is left of every state is no more.
    pub(crate) rounding: Option<Vec<f64>>,
    /// Equations that the data allow.
    pub(crate) posterior: Posterior,
}

/// Samples for every term, below which an equation is not called adequate.
pub(super) const ROWS_A_TERM: f64 = 3.0;

/// Multiple of the rates that one term contributes, beyond which the terms make up for others.
const CANCELLING: f64 = 1e3;

/// Multiple of what the smoothness of a state tells of its noise, beyond which what an equation leaves is not noise alone: a quarter more than the tenfold by which
/// differences from sample to sample, which contain the noise, may exceed it (`FACTORS` of the smoother).
pub(super) const BEYOND: f64 = 12.5;

impl Problem<'_> {
    /// Whether of two terms one is a state and the other the rate of the state whose rate it is.
    fn is_rate_of_itself(&self, (a, b): (usize, usize)) -> bool {
        let is = |rate: usize, state: usize| {
            let of = self.terms[rate].rate.filter(|_| self.terms[rate].expr.is_one()).and_then(|of| self.rates[of]);
            of.is_some_and(|v| self.terms[state].rate.is_none() && self.terms[state].expr == Expr::Variable(v))
        };
        is(a, b) || is(b, a)
    }

    /// What was found, and what speaks against it.
    pub(super) fn account(&self, found: Searched, signals: &Signals) -> Estimate {
        let Searched { mut best, regressions, rivals, others, finished } = found;
        let n = self.rates.len();
        // Where more than noise is left, standard errors tell nothing, and a shift by some of them is none.
        if best.fit.expansion > 0.0 && self.is_settled(&best) {
            let Hypothesis { flow, part, .. } = &best;
            let mut fit = best.fit.clone();
            self.working(|work| fit.integrate_over_states(flow, self.segments, *part, (work, self.watch.asks())));
            best = best.moved(fit, self);
        }
        let (constant, not_held) = (OnceCell::new(), OnceCell::new());
        let is_constant = |i: usize| constant.get_or_init(|| self.halves_agree(&best))[i];
        let not_held = || *not_held.get_or_init(|| self.speaks_for_linear_inputs(&best));
        let doubt = |i: usize| {
            if self.samples() < ROWS_A_TERM * best.supports[i].len() as f64 {
                Some(Doubt::TooFewSamples)
            } else if !self.is_noise(&best, i) {
                Some(Doubt::Correlated)
            } else if best.fit.left[i] > BEYOND * signals.sigma[i].max(self.floor[i]) {
                Some(Doubt::Large)
            } else if self.finds_no_motion(&best) {
                Some(Doubt::NoMotion)
            } else if self.has_still_state(&best, i) {
                Some(Doubt::Still)
            } else if not_held() && self.acts_on(&best, i) {
                Some(Doubt::NotHeld)
            } else if best.contributions[i] > CANCELLING {
                Some(Doubt::Cancelling)
            } else if !self.is_coupled_symmetrically(&best.supports, i) {
                Some(Doubt::Asymmetric)
            } else if !rivals[i].is_empty() {
                Some(Doubt::OtherTerms)
            } else if self.is_series(&best, i) {
                Some(Doubt::Series)
            } else if !is_constant(i) && !self.leaves_nothing(&best) {
                Some(Doubt::Inconstant)
            } else {
                (!finished[i]).then_some(Doubt::Unfinished)
            }
        };
        let doubts: Vec<Option<Doubt>> = (0..n).map(doubt).collect();
        if let Some(told) = self.is_settled(&best).then(|| self.whatever_the_inputs((&best, None))).flatten() {
            let mut fit = best.fit.clone();
            fit.take(told);
            best = best.moved(fit, self);
        }
        let contradicted = regressions.iter().map(|r| r.contradicted(TOLD_APART, |support| self.penalty(support)));
        let contradicted = contradicted.collect();
        let mut parameter = 0;
        let mut errors = Vec::with_capacity(n);
        let mut fits = Vec::with_capacity(n);
        let mut twins = Vec::new();
        for (i, (regression, ties)) in regressions.iter().zip(rivals).enumerate() {
            // Signs of what never changes its sign are the same as the constant, and nobody means them.
            let own =
                regression.twins(&best.supports[i]).into_iter().filter(|(own, _)| !self.terms[*own].expr.is_one());
            let own = own.filter(|pair| !self.is_rate_of_itself(*pair));
            twins.extend(own.filter(|pair| !twins.contains(pair)).collect::<Vec<_>>());
            let range = parameter..parameter + best.supports[i].len();
            parameter = range.end;
            // A declared rate is an equation of one term.
            let rate = self.rates[i]
                .and_then(|v| self.terms.iter().position(|t| t.rate.is_none() && t.expr == Expr::Variable(v)));
            let (support, coefficients) = match rate {
                Some(term) => (vec![term], vec![1.0]),
                None => (best.supports[i].clone(), best.fit.xi[range.clone()].to_vec()),
            };
            let given = self.constraints.get(i).map_or(&[][..], |c| &c.fixed);
            let support = support.into_iter().chain(given.iter().map(|g| g.0)).collect();
            let coefficients = coefficients.into_iter().chain(given.iter().map(|g| g.1)).collect();
            fits.push(Selected {
                support,
                coefficients,
                residual: best.fit.left[i],
                reached_floor: doubts[i].is_none(),
                proved: false,
                converged: true,
                path: regression.path(),
                ties,
            });
            errors.push([&best.fit.errors[range], &vec![0.0; given.len()]].concat());
        }
        let mut terms = self.terms.to_vec();
        let mut inside = Vec::new();
        let mut errors_inside = best.fit.errors[best.coefficients().len()..].iter();
        for (j, fitted) in &best.inside {
            let Some(shape) = terms[*j].shape.take() else { continue };
            terms[*j].expr = shape.at(fitted);
            let values = shape.values(fitted).into_iter().zip(errors_inside.by_ref()).enumerate();
            inside.push((*j, values.map(|(k, (value, error))| (value, shape.error(k, fitted, *error))).collect()));
        }
        let left = best.fit.left.clone();
        // Of a state that does not move there is nothing to fit.
        let of_spread = |i: usize| {
            if self.measures(i) && left[i] < self.spread(i) { 1.0 - left[i] / self.spread(i) } else { f64::NAN }
        };
        let fit = (0..n).map(of_spread).collect();
        Estimate {
            terms,
            inside,
            fits,
            errors,
            twins,
            contradicted,
            n_known: (0..n).map(|i| self.constraints.get(i).map_or(0, |c| c.fixed.len())).collect(),
            stepping: self.classical(&best),
            condition: best.fit.triangle.condition(&(0..best.fit.xi.len()).collect::<Vec<_>>()),
            corrections: self.corrected_inputs(),
            leaves_nothing: self.leaves_nothing(&best),
            rounding: self.is_rounding(&best).then(|| self.floor.iter().map(|floor| FLOOR * floor).collect()),
            posterior: self.posterior(&best, &others),
            sigma: left,
            measured: (0..n).map(|i| self.measures(i)).collect(),
            rates: self.rates.to_vec(),
            signal_noise: signals.sigma.clone(),
            score: best.score,
            path: best.fit.x.clone(),
            astray: 0,
            growing: vec![0.0; n],
            doubts,
            fit,
            complete: self.spent.get() <= self.budget,
        }
    }
}
