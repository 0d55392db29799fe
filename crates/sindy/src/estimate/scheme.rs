//! Steps of simulators: data that were computed by a fixed number of classical steps follow these to rounding, and the equations only nearly.

use ndarray::Array2;

use super::hypothesis::{Hypothesis, Start, TOLD_APART};
use super::problem::Problem;
use crate::motion::{MOST_SEMI_IMPLICIT, Stepping};

/// Classical Runge–Kutta steps from sample to sample, at most.
const MOST: usize = 8;

/// RMS difference, in standard deviations of what is left, by which steps are told from exact solutions.
const TOLD: f64 = 0.3;

impl Problem<'_> {
    /// `best`, or the same equations stepped as a simulator does it, if the score is better for that and they leave noise alone.
    pub(super) fn as_simulated(&self, best: Hypothesis) -> Hypothesis {
        if !matches!(best.flow.stepping(), Stepping::Continuous { .. }) || self.leaves_nothing(&best) {
            return best;
        }
        let difference = |substeps: usize| {
            let (flow, fit) = (&best.flow, &best.fit);
            let coarse = flow.with_stepping(Stepping::Classical { substeps });
            (self.difference(&coarse, flow, &fit.xi, &fit.x, &fit.sigma), substeps)
        };
        // If the steps explain what is left, it is what they differ by.
        let mut told: Vec<(f64, usize)> = (1..=MOST).map(difference).filter(|(d, _)| *d > TOLD).collect();
        told.sort_by(|a, b| a.0.ln().abs().total_cmp(&b.0.ln().abs()));
        let classical = told.into_iter().map(|(_, substeps)| Stepping::Classical { substeps });
        let x: Vec<Array2<f64>> = self.segments.iter().map(|s| s.x.clone()).collect();
        let start = Start { x: &x, ..best.start() };
        let mut simulated: Option<Hypothesis> = None;
        // Nobody says that there is a simulator, nor which of these steps it takes.
        let price = TOLD_APART + 2.0 * ((MOST_SEMI_IMPLICIT + MOST) as f64).ln();
        for stepping in self.simulators.iter().copied().chain(classical) {
            let Some(other) = self.hypothesis(best.supports.clone(), stepping, start, 2..4) else { continue };
            // Steps make up for terms that are missing, but not for all that these explain.
            let bar = simulated.as_ref().map_or(best.score - price, |s| s.score - TOLD_APART);
            if other.score < bar && self.is_settled(&other) {
                let done = self.leaves_nothing(&other);
                simulated = Some(other);
                if done {
                    break;
                }
            }
        }
        simulated.unwrap_or(best)
    }
}
