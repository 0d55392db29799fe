//! From proposals to the hypothesis with the best score.

use ndarray::Array2;

use super::hypothesis::Hypothesis;
use super::white::is_white;
use crate::BestSubset;
use crate::data::{Segment, Signals, smooth};
use crate::design::Path;
use crate::library::Term;
use crate::motion::Stepping;
use crate::solve::Selected;

/// What is to be explained, and by what.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    pub(crate) terms: &'a [Term],
    /// Per state: the state that is declared to be its rate.
    pub(crate) rates: &'a [Option<usize>],
    pub(crate) n_controls: usize,
    pub(crate) segments: &'a [Segment],
    /// Smallest error of each state that is believed: rounding (n).
    pub(crate) floor: &'a [f64],
    pub(crate) solver: &'a BestSubset,
}

/// Equations found.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// One per state: terms, coefficients, the best subsets of each size. None for states with declared rates.
    pub(crate) fits: Vec<Selected>,
    /// Standard errors of the coefficients of each equation.
    pub(crate) errors: Vec<Vec<f64>>,
    pub(crate) stepping: Stepping,
    /// Standard deviation of the noise of each state, by what the equations leave.
    pub(crate) sigma: Vec<f64>,
    /// The same by how smooth the signals are, before any equation is known.
    pub(crate) signal_noise: Vec<f64>,
    /// Per state: whether what its equation leaves is noise.
    pub(crate) adequate: Vec<bool>,
}

/// Rounds of proposals, at most.
const ROUNDS: usize = 6;

/// Noise larger than this many times what the smoothness of the signals tells is no noise.
const LARGER: f64 = 1.25;

/// Part of a channel's spread below which nothing is left to explain.
const NOTHING: f64 = 1e-9;

/// The equations with the best score.
pub(crate) fn estimate(problem: &Problem<'_>, stepping: Stepping) -> Option<Estimate> {
    let signals = smooth(problem.segments, problem.rates, problem.floor);
    let proposed = match stepping {
        Stepping::Continuous { .. } => problem.propose(&Path::Measured(&signals), &signals.sigma, None),
        _ => problem.propose(&Path::Held { x: &signals.x }, &signals.sigma, None),
    };
    let (mut best, mut selected) = problem.rounds(&signals, proposed, stepping)?;
    problem.prune(&mut best, &mut selected);
    Some(problem.account(best, selected, &signals))
}

impl Problem<'_> {
    /// Proposals along the path of the last hypothesis until one comes back; the best hypothesis with the proposals it came from.
    fn rounds(
        &self,
        signals: &Signals,
        mut proposed: Vec<Selected>,
        stepping: Stepping,
    ) -> Option<(Hypothesis, Vec<Selected>)> {
        let mut best: Option<(Hypothesis, Vec<Selected>)> = None;
        let mut tried: Vec<Vec<Vec<usize>>> = Vec::new();
        for _ in 0..ROUNDS {
            let supports: Vec<Vec<usize>> = proposed.iter().map(|s| s.support.clone()).collect();
            if tried.contains(&supports) {
                break;
            }
            tried.push(supports.clone());
            let xi: Vec<f64> = proposed.iter().flat_map(|s| s.coefficients.clone()).collect();
            let from = (&xi[..], &signals.x[..], &signals.sigma[..]);
            // States that follow the data more than the equations, which may be wrong.
            let Some(loose) = self.hypothesis(supports.clone(), stepping, from, 0..2) else { break };
            let from = (&loose.fit.xi[..], &loose.fit.x[..], &loose.fit.sigma[..]);
            let strict = self.hypothesis(supports, stepping, from, 2..4);
            if std::env::var("SINDY_TRACE").is_ok() {
                eprintln!(
                    "round: score {:?} sigma {:?} of {:?}",
                    strict.as_ref().map(|s| s.score),
                    strict.as_ref().map(|s| &s.fit.sigma),
                    signals.sigma
                );
                for (i, s) in proposed.iter().enumerate() {
                    eprintln!(
                        "  {i}: {:?}",
                        s.support
                            .iter()
                            .zip(&s.coefficients)
                            .map(|(j, c)| format!("{:.4} {}", c, self.terms[*j].name))
                            .collect::<Vec<_>>()
                    );
                }
            }
            let near = |h: &Hypothesis| h.fit.sigma.iter().zip(&signals.sigma).all(|(s, n)| *s <= LARGER * n);
            let along = strict.as_ref().filter(|h| near(h)).unwrap_or(&loose).clone();
            if let Some(strict) = strict
                && best.as_ref().is_none_or(|(b, _)| strict.score < b.score)
            {
                best = Some((strict, proposed.clone()));
            }
            let path = match stepping {
                Stepping::Continuous { .. } => Path::Model { flow: &along.flow, xi: &along.fit.xi, x: &along.fit.x },
                _ => Path::Held { x: &along.fit.x },
            };
            proposed = self.propose(&path, &signals.sigma, Some((&along.flow, &along.fit.xi, &along.fit.x)));
        }
        best
    }

    /// Drops terms that the score does not pay for, the least significant first.
    fn prune(&self, best: &mut Hypothesis, selected: &mut [Selected]) {
        loop {
            let z = |p: usize| (best.fit.xi[p] / best.fit.errors[p]).abs();
            let Some(least) = (0..best.fit.xi.len()).min_by(|&a, &b| z(a).total_cmp(&z(b))) else { break };
            let row = best.flow.row_of(least);
            let at = least - (0..least).filter(|&p| best.flow.row_of(p) < row).count();
            let mut supports = best.supports.clone();
            let before = self.penalty(&supports[row]);
            supports[row].remove(at);
            // To first order the sum of squares grows by z².
            if z(least).powi(2) > 4.0 * (before - self.penalty(&supports[row])) {
                break;
            }
            let mut xi = best.fit.xi.clone();
            xi.remove(least);
            let from = (&xi[..], &best.fit.x[..], &best.fit.sigma[..]);
            match self.hypothesis(supports, best.flow.stepping(), from, 2..4) {
                Some(fewer) if fewer.score < best.score => {
                    selected[row].support = fewer.supports[row].clone();
                    *best = fewer;
                }
                _ => break,
            }
        }
    }

    fn account(&self, best: Hypothesis, selected: Vec<Selected>, signals: &Signals) -> Estimate {
        let n = self.rates.len();
        let residuals: Vec<Array2<f64>> = self.segments.iter().zip(&best.fit.x).map(|(s, x)| &s.x - x).collect();
        let explained = |i: usize| {
            let sigma = best.fit.sigma[i];
            let near = sigma <= LARGER * signals.sigma[i] && is_white(&residuals, i);
            near || sigma <= NOTHING * self.spread(i)
        };
        let explained: Vec<bool> = (0..n).map(explained).collect();
        // What a rate leaves shows in the states it is the rate of.
        let adequate = (0..n).map(|i| {
            let mut at = i;
            let mut all = explained[i];
            while let Some(head) = self.rates.iter().position(|r| *r == Some(at)).filter(|&h| h != i) {
                all &= explained[head];
                at = head;
                if at == i {
                    break;
                }
            }
            all
        });
        let adequate: Vec<bool> = adequate.collect();
        let mut parameter = 0;
        let mut errors = Vec::with_capacity(n);
        let mut fits = Vec::with_capacity(n);
        for (i, mut fit) in selected.into_iter().enumerate() {
            let range = parameter..parameter + best.supports[i].len();
            parameter = range.end;
            fit.support = best.supports[i].clone();
            fit.coefficients = best.fit.xi[range.clone()].to_vec();
            fit.reached_floor = adequate[i];
            fit.proved = false;
            errors.push(best.fit.errors[range].to_vec());
            fits.push(fit);
        }
        Estimate {
            fits,
            errors,
            stepping: best.flow.stepping(),
            sigma: best.fit.sigma,
            signal_noise: signals.sigma.clone(),
            adequate,
        }
    }

    /// Standard deviation of state `i` over all samples.
    fn spread(&self, i: usize) -> f64 {
        let values: Vec<f64> = self.segments.iter().flat_map(|s| s.x.column(i).to_vec()).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt()
    }
}
