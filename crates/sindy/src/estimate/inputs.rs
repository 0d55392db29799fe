//! Inputs that were rounded when they were written: errors in variables, of a size that is known.
//!
//! # References
//! Carroll, Ruppert, Stefanski, Crainiceanu (2006), Measurement Error in Nonlinear Models, 2nd ed.

use nalgebra::DMatrix;

use super::hypothesis::{Hypothesis, Start, TOLD_APART};
use super::problem::Problem;
use super::strays::Kept;
use super::white::{by_chance, is_white};
use crate::data::Segment;
use crate::shooting::{self, Fit, PARTS, Told, is_held};

/// Steps of its last digit over which an input moves, at least, that may have been rounded: settings of a few digits are what they are.
const STEPS: f64 = 20.0;

/// Times that inputs and equations are found in turn.
const ROUNDS: usize = 3;

/// Part of the differences that a function of the input explains, at least, which is no rounding.
const EXPLAINED: f64 = 0.25;

/// A hypothesis, and the derivatives of its coefficients by the parameters that it has instead.
type Along<'a> = (&'a Hypothesis, Option<&'a DMatrix<f64>>);

impl Problem<'_> {
    /// The data with inputs as the states tell that they were before they were rounded, and `best`, which leaves more than noise, fitted to these; if that leaves
    /// noise alone. Of `best` and of the terms near it that explain what it leaves those are taken that are likelier then.
    pub(super) fn with_corrected_inputs(&self, best: &Hypothesis) -> Option<(Kept, Hypothesis)> {
        let corrected = |best: &Hypothesis| {
            self.corrected(best, &|found| (found, None), &|problem, begun: &Hypothesis| {
                problem.hypothesis(best.supports.clone(), best.flow.stepping(), begun.start(), 2..4)
            })
        };
        let (right, again) = corrected(best)?;
        let beside = self.beside(best);
        let both = Some(&beside).filter(|beside| beside.supports != best.supports).and_then(&corrected);
        if let Some(both) = both.filter(|both| both.1.score + both.0.price < again.score + right.price) {
            return Some(self.without_needless(both, &corrected));
        }
        // Of what the data do not tell apart the terms are meant that are fewer.
        let is_likelier = again.score + right.price < beside.score + TOLD_APART;
        let is_better = is_likelier || !self.is_settled(&beside);
        is_better.then(|| self.without_needless((right, again), &corrected))
    }

    /// `found` without terms that made up for rounding of the inputs: all that look needless, or the least significant one, as long as the score gains by it once inputs
    /// are `corrected` for what is left.
    fn without_needless(
        &self,
        mut found: (Kept, Hypothesis),
        corrected: &dyn Fn(&Hypothesis) -> Option<(Kept, Hypothesis)>,
    ) -> (Kept, Hypothesis) {
        loop {
            let score = found.1.score + found.0.price;
            let fewer = |most: usize| {
                let (supports, xi) = self.significant(&found.1, most)?;
                let start = Start { xi: &xi, ..found.1.start() };
                let begun = self.hypothesis(supports, found.1.flow.stepping(), start, 2..4)?;
                corrected(&begun).filter(|(right, again)| again.score + right.price < score)
            };
            let Some(simpler) = fewer(usize::MAX).or_else(|| fewer(1)) else { return found };
            found = simpler;
        }
    }

    /// The data with inputs as the states tell that they were before they were rounded, and what `fit` makes of these, if that leaves noise alone and explains more than `first`, whose innovations are correlated. `of` is
    /// the hypothesis of something that was found.
    pub(super) fn corrected<T: Clone>(
        &self,
        first: &T,
        of: &dyn Fn(&T) -> Along<'_>,
        fit: &dyn Fn(&Problem<'_>, &T) -> Option<T>,
    ) -> Option<(Kept, T)> {
        let mut segments = self.rounded_inputs()?;
        if self.is_white(of(first).0) {
            return None;
        }
        let left = &of(first).0.fit.sigma;
        let mut sigma: Vec<f64> = self.noise.iter().zip(left).map(|(noise, left)| noise.min(*left)).collect();
        let (mut found, mut price) = (first.clone(), 0.0);
        for _ in 0..ROUNDS {
            let (Hypothesis { flow, fit: Fit { xi, x, .. }, .. }, along) = of(&found);
            let (at, go_on) = ((&xi[..], &x[..]), self.watch.asks());
            let told = self.working(|work| {
                shooting::inputs((flow, along), &segments, at, &sigma, PARTS[PARTS.len() - 1], (work, go_on))
            })?;
            for ((segment, by), written) in segments.iter_mut().zip(told.by).zip(self.segments) {
                segment.u = &written.u + &by;
                segment.corrections = Some(by);
            }
            found = fit(&Problem { segments: &segments, ..*self }, &found)?;
            sigma.clone_from(&of(&found).0.fit.sigma);
            price = told.price;
        }
        let right = Problem { segments: &segments, ..*self };
        // What is left may be correlated and yet no more than is believed of every sample, so that no likelihood tells.
        let is_better = of(&found).0.score + price < of(first).0.score || right.is_white(of(&found).0);
        let is_rounding = !(0..self.n_controls).any(|j| depends(&segments, j));
        let explained = is_better && is_rounding && right.is_settled(of(&found).0);
        explained.then_some((Kept { segments, astray: 0, price }, found))
    }

    /// What the data tell of the coefficients of `found`, which leaves noise alone, whatever its inputs were before they were rounded: errors of inputs that are too small to be told
    /// move coefficients all the same. `None` if inputs were not rounded, or were corrected, or the system runs away: least squares would take back what its coefficients were moved by.
    pub(super) fn whatever_the_inputs(&self, (found, along): Along<'_>) -> Option<Told> {
        (found.fit.expansion <= 0.0).then_some(())?;
        let segments = self.rounded_inputs()?;
        segments.iter().flat_map(|s| &s.of_inputs).any(|error| *error > 0.0).then_some(())?;
        let Hypothesis { flow, fit: Fit { xi, x, sigma, .. }, .. } = found;
        let (at, go_on) = ((&xi[..], &x[..]), self.watch.asks());
        let told = self.working(|work| {
            shooting::inputs((flow, along), &segments, at, sigma, PARTS[PARTS.len() - 1], (work, go_on))
        })?;
        told.change.iter().all(|by| by.is_finite()).then_some(told)
    }

    /// The data with the errors of those inputs that may have been rounded; `None` if there are none, or they were corrected.
    fn rounded_inputs(&self) -> Option<Vec<Segment>> {
        let may_be = |s: &Segment| s.ramp.is_none() && s.corrections.is_none() && s.of_inputs.iter().any(|s| *s > 0.0);
        if !self.segments.iter().all(may_be) {
            return None;
        }
        let mut segments = self.segments.to_vec();
        for j in 0..self.n_controls {
            let values = || self.segments.iter().flat_map(|s| s.u.column(j).to_vec());
            let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            // The deviation of an error that is uniform over a step.
            let step = |s: &Segment| s.of_inputs[j] * 12_f64.sqrt();
            segments.iter_mut().filter(|s| high - low < STEPS * step(s)).for_each(|s| s.of_inputs[j] = 0.0);
        }
        Some(segments)
    }

    /// The inputs that were corrected, and the distance of two neighbouring values as they were written.
    pub(super) fn corrected_inputs(&self) -> Vec<(usize, f64)> {
        let error = |j: usize| {
            self.segments.iter().filter(|s| s.corrections.is_some()).map(|s| s.of_inputs[j]).fold(0.0, f64::max)
        };
        (0..self.n_controls).map(|j| (j, 12_f64.sqrt() * error(j))).filter(|(_, step)| *step > 0.0).collect()
    }

    /// Whether the innovations of every state that was measured look like noise.
    fn is_white(&self, hypothesis: &Hypothesis) -> bool {
        let Some(innovations) = hypothesis.innovations(self) else { return false };
        (0..self.rates.len()).filter(|&i| self.measures(i)).all(|i| is_white(innovations, i))
    }
}

/// Whether the differences by which input `j` was corrected depend on its value, as those of rounding do not: a square or a cube of it explains them.
fn depends(segments: &[Segment], j: usize) -> bool {
    let mut pairs = Vec::new();
    for segment in segments {
        let Some(by) = &segment.corrections else { continue };
        pairs.extend((0..segment.len()).filter(|&t| !is_held(segment, t, j)).map(|t| (segment.u[[t, j]], by[[t, j]])));
    }
    let count = pairs.len() as f64;
    let largest = pairs.iter().fold(0.0_f64, |m, (u, _)| m.max(u.abs())).max(f64::MIN_POSITIVE);
    // What a constant and the gain take up is no matter of these.
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (mut taken, mut explained) = (0.0, 0.0);
    let total: f64 = pairs.iter().map(|(_, by)| by * by).sum();
    for power in 0..4 {
        let mut f: Vec<f64> = pairs.iter().map(|(u, _)| (u / largest).powi(power)).collect();
        for b in &basis {
            let along: f64 = f.iter().zip(b).map(|(f, b)| f * b).sum();
            f.iter_mut().zip(b).for_each(|(f, b)| *f -= along * b);
        }
        let norm = f.iter().map(|v| v * v).sum::<f64>().sqrt();
        if norm < 1e-9 * count.sqrt() {
            continue;
        }
        f.iter_mut().for_each(|v| *v /= norm);
        let along = f.iter().zip(&pairs).map(|(f, (_, by))| f * by).sum::<f64>().powi(2);
        *if power > 1 { &mut explained } else { &mut taken } += along;
        basis.push(f);
    }
    explained > (total - taken) * EXPLAINED.max(by_chance(2) / count.max(1.0))
}
