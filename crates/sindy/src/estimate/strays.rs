//! Steps that do not follow the equations of all the others: an impact, a glitch of a sensor, a kink that a simulator stepped over.

use ndarray::{Array2, s};

use super::hypothesis::{Hypothesis, Start};
use super::problem::Problem;
use super::searched::{Rough, Searched};
use crate::data::{Segment, Signals, Smoother};
use crate::motion::Stepping;
use crate::shooting::Samples;
use crate::solve::binomial;

/// Error of one step, as a multiple of the median, beyond which it may be a stray.
const STRAY: f64 = 15.0;

/// Largest share of strays; with more of them the equations are wrong, not the steps.
const MOST: f64 = 0.2;

/// Times that steps are rejected: small strays show when large ones are gone.
const ROUNDS: usize = 12;

/// Data without strays, and with corrected inputs.
#[derive(Debug, Clone)]
pub(crate) struct Kept {
    pub(crate) segments: Vec<Segment>,
    /// Steps left out.
    pub(crate) astray: usize,
    /// What that cost, and what inputs that were corrected did, in units of the score.
    pub(crate) price: f64,
}

/// What was found in data without strays, and their signals.
pub(super) struct Rejecting {
    pub(super) searched: Searched,
    pub(super) signals: Signals,
    pub(super) kept: Kept,
}

impl Problem<'_> {
    /// The hypothesis with the best score, from `begun` or from equations that were looked for roughly, and the data without what they do not follow.
    /// `before` is what was found in a part of very many samples.
    pub(super) fn rejecting(
        &self,
        (mut begun, before): (Option<Hypothesis>, Option<&Searched>),
        stepping: Stepping,
    ) -> Option<Rejecting> {
        let mut kept = Kept { segments: self.segments.to_vec(), astray: 0, price: 0.0 };
        for round in 0..=ROUNDS {
            let signals = Smoother::new(&kept.segments, self.rates, self.floor, self.watch.asks()).signals(self.floor);
            if !self.watch.go_on() {
                return None;
            }
            let problem = Problem { segments: &kept.segments, noise: &signals.sigma, ..*self };
            let without =
                |best: &Hypothesis| (round < ROUNDS).then(|| problem.without_strays(best, kept.astray)).flatten();
            let mut searched = None;
            if begun.is_none() {
                match problem.roughly(stepping) {
                    Some(Rough::Noisy(found)) => searched = Some(found),
                    Some(Rough::Begun(best)) => {
                        begun = problem.fitted(&best, &signals).map(|begun| problem.as_simulated(begun));
                    }
                    None => {}
                }
            }
            let right = |begun: &Hypothesis| (round < ROUNDS).then(|| problem.with_corrected_inputs(begun)).flatten();
            let mut fewer = begun.as_ref().and_then(|begun| right(begun).or_else(|| without(begun)));
            if fewer.is_none() {
                let searched = searched.or_else(|| problem.search(&signals, (begun.take(), before), stepping))?;
                fewer = right(&searched.best).or_else(|| without(&searched.best));
                if fewer.is_none() {
                    return Some(Rejecting { searched, signals, kept });
                }
            }
            let (rest, again) = fewer?;
            kept = Kept { astray: kept.astray + rest.astray, price: kept.price + rest.price, ..rest };
            begun = Some(again);
        }
        None
    }

    /// The data without the steps that `best` misses by far more than the others, and `best` fitted to those; if the score gains more by that than the
    /// steps cost. So many steps were left out `before`.
    ///
    /// A step left out costs the state in which the next one begins, and which of all steps it is. A sample between two of them is told
    /// by nothing but the spread of its channel.
    fn without_strays(&self, best: &Hypothesis, before: usize) -> Option<(Kept, Hypothesis)> {
        let strays = self.strays(best)?;
        let steps: usize = strays.iter().map(Vec::len).sum();
        let astray = strays.iter().flatten().filter(|s| **s).count();
        if astray == 0 || (before + astray) as f64 > MOST * (before + steps) as f64 {
            return None;
        }
        let (mut segments, mut x) = (Vec::new(), Vec::<Array2<f64>>::new());
        for (segment, strays) in self.segments.iter().zip(&strays) {
            let mut first = 0;
            for (t, stray) in strays.iter().copied().chain([true]).enumerate() {
                if stray {
                    if t > first {
                        segments.push(segment.part(first, t));
                        // The path has wandered off to make up for the strays.
                        x.push(segment.x.slice(s![first..=t, ..]).to_owned());
                    }
                    first = t + 1;
                }
            }
        }
        let kept = Problem { segments: &segments, ..*self };
        let start = Start { x: &x, ..best.start() };
        let again = kept.hypothesis(best.supports.clone(), best.flow.stepping(), start, 0..4)?;
        let n = self.rates.len() as f64;
        let measured = (0..self.rates.len()).filter(|&i| self.measures(i));
        let lone: f64 = measured.map(|i| 2.0 * self.spread(i).max(f64::MIN_POSITIVE).ln()).sum();
        let price = (self.samples() - kept.samples()) * lone
            + astray as f64 * n * self.samples().ln()
            + 2.0 * binomial(steps, astray).ln();
        (again.score + price < best.score).then_some((Kept { segments, astray, price }, again))
    }

    /// Per segment and step: whether `best` misses it by far more than the others. `None` if it cannot take every step.
    fn strays(&self, best: &Hypothesis) -> Option<Vec<Vec<bool>>> {
        let n = self.rates.len();
        let (flow, xi) = (&best.flow, &best.fit.xi);
        let mut errors: Vec<Array2<f64>> = Vec::with_capacity(self.segments.len());
        for segment in self.segments {
            let mut own = Array2::zeros((segment.len(), n));
            let samples = Samples { segment, x: &segment.x, every: 1 };
            let whole = flow.each_step(samples, xi, false, &mut |made| {
                for (i, next) in made.next.iter().enumerate() {
                    own[[made.t, i]] = (segment.x[[made.t + 1, i]] - next).abs() / segment.relative(made.t + 1, i);
                }
                made.finite
            });
            if !whole {
                return None;
            }
            errors.push(own);
        }
        let typical: Vec<f64> = (0..n)
            .map(|i| {
                let mut all: Vec<f64> = errors.iter().flat_map(|e| e.column(i).to_vec()).collect();
                let middle = all.len() / 2;
                let median = if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(middle, f64::total_cmp).1 };
                median.max(self.floor[i])
            })
            .collect();
        let is_stray = |row: ndarray::ArrayView1<'_, f64>| (0..n).any(|i| row[i] > STRAY * typical[i]);
        Some(errors.iter().map(|e| e.rows().into_iter().map(is_stray).collect()).collect())
    }
}
