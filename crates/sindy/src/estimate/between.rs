//! What inputs do between samples: they are held, or change linearly.

use ndarray::{Array2, s};

use super::hypothesis::{Hypothesis, Start, TOLD_APART};
use super::problem::Problem;
use super::search::LARGER_SAMPLE;
use crate::data::{Segment, stretches};
use crate::motion::Stepping;

impl Problem<'_> {
    /// Whether the terms of `best`, fitted with inputs that are held, explain the data better with inputs that are linear between samples.
    pub(super) fn speaks_for_linear_inputs(&self, best: &Hypothesis) -> bool {
        let held = self.segments.iter().all(|s| s.ramp.is_none());
        let continuous = matches!(best.flow.stepping(), Stepping::Continuous { .. });
        if !(held && continuous) || self.n_controls == 0 || self.leaves_nothing(best) {
            return false;
        }
        // Of very many samples a part tells.
        let linear: Vec<(Segment, Array2<f64>)> = stretches(self.segments, LARGER_SAMPLE)
            .into_iter()
            .filter(|(_, steps)| steps.len() > 1)
            .map(|(at, steps)| {
                let segment = self.segments[at].part(steps.start, steps.end).with_linear_inputs();
                (segment, best.fit.x[at].slice(s![steps.start..steps.end, ..]).to_owned())
            })
            .collect();
        let (linear, x): (Vec<Segment>, Vec<Array2<f64>>) = linear.into_iter().unzip();
        let held: Vec<Segment> = linear.iter().map(|s| Segment { ramp: None, ..s.clone() }).collect();
        let score = |segments: &[Segment]| {
            let start = Start { x: &x, ..best.start() };
            let refitted = Problem { segments, ..*self }
                .with_reserve(|problem| problem.hypothesis(best.supports.clone(), best.flow.stepping(), start, 2..4));
            refitted.map(|refitted| refitted.score)
        };
        score(&linear).zip(score(&held)).is_some_and(|(linear, held)| linear + TOLD_APART < held)
    }

    /// Whether inputs are in the terms of equation `i`.
    pub(super) fn acts_on(&self, best: &Hypothesis, i: usize) -> bool {
        let n = self.rates.len();
        let mut inputs = n..n + self.n_controls;
        inputs.any(|input| best.supports[i].iter().any(|&j| self.terms[j].expr.has(input)))
    }
}
