//! Averages and equations that agree with each other.

use ndarray::{Array2, Axis, concatenate};

use super::choice::Choice;
use super::fitting::{Terms, whitened};
use super::found::{Found, Search};
use super::stepping::FINEST;
use super::{Run, Stepping};
use crate::model::ModelError;

/// Rounds of averaging and fitting, at most; each brings the averages about a digit nearer.
const ROUNDS: usize = 25;

/// Searches for terms, at most.
const SEARCHES: usize = 6;

/// Runge–Kutta steps per interval that are tried.
const SUBSTEPS: [usize; 4] = [1, 2, 4, FINEST];

/// Times by which more substeps must lower χ² to be believed.
const FINER: f64 = 4.0;

impl Search<'_> {
    /// Searches for terms, and averages that agree with them, in turn until the equations stay as they are.
    pub(super) fn settle(&self, start: Found, choices: &[Choice]) -> Result<Found, ModelError> {
        let mut found = start;
        for _ in 0..SEARCHES {
            // A model that leaves the finite numbers on its way leads nowhere.
            let Ok(next) = self.searched(&found, choices) else { break };
            if same_terms(&next, &found) {
                // The last search is the account of what was found.
                found.fits = found.fits.into_iter().zip(&next.fits).map(|(fit, search)| fit.found_by(search)).collect();
                break;
            }
            let simpler = next.model.fitted().len() < found.model.fitted().len();
            let Ok(next) = self.refine(next) else { break };
            if next.misfit > found.misfit && !(simpler && next.explains()) {
                break;
            }
            found = next;
        }
        Ok(found)
    }

    /// The best terms along the way of `found`; with more substeps too, where what is left is not explained.
    fn searched(&self, found: &Found, choices: &[Choice]) -> Result<Found, ModelError> {
        let offsets = found.model.offsets();
        let search = |stepping| self.fit(stepping, offsets, Some(&found.model), &Terms::Best(choices));
        if found.explains() { search(found.stepping) } else { self.finest(found.stepping, search) }
    }

    /// The same terms with averages that agree with them, the number of substeps that does so best, and a verdict.
    pub(super) fn refine(&self, start: Found) -> Result<Found, ModelError> {
        self.judged(self.finest(start.stepping, |stepping| self.agree(&start, stepping))?)
    }

    /// `found` with as many substeps as there are, unless fewer are clearly better: then the system itself is stepped so. Where
    /// data cannot tell, as those of a linear system, they come from nature, and few substeps only falsify coefficients.
    pub(super) fn followed_closely(&self, found: Found) -> Found {
        let finest = Stepping::Continuous { substeps: FINEST };
        if !found.explains() || found.stepping == finest || !found.stepping.is_continuous() {
            return found;
        }
        let closely = self.agree(&found, finest).and_then(|closely| self.judged(closely));
        let rows = self.runs.iter().map(Run::len).sum::<usize>() as f64;
        // What rounding leaves differs by chance.
        let as_good = |closely: &Found| closely.misfit <= FINER * found.misfit.max(rows);
        closely.ok().filter(|closely| closely.explains() && as_good(closely)).unwrap_or(found)
    }

    /// What `find` finds with as many Runge–Kutta steps as are clearly better than fewer; another stepping stays what it is.
    fn finest(
        &self,
        stepping: Stepping,
        find: impl Fn(Stepping) -> Result<Found, ModelError>,
    ) -> Result<Found, ModelError> {
        if !stepping.is_continuous() {
            return find(stepping);
        }
        let [first, rest @ ..] = SUBSTEPS.map(|substeps| Stepping::Continuous { substeps });
        let mut best = find(first)?;
        for stepping in rest {
            let finer = find(stepping)?;
            if finer.misfit * FINER > best.misfit {
                break;
            }
            best = finer;
        }
        Ok(best)
    }

    fn agree(&self, start: &Found, stepping: Stepping) -> Result<Found, ModelError> {
        let mut offsets = start.model.offsets().to_vec();
        // Errors of the terms weigh the rows; they hardly change on the way. What is wrong with the Runge–Kutta steps must show.
        let errors = self.errors_of_terms(&start.model, stepping, false);
        let fit = |offsets: &[f64], along: &Found| {
            self.fit_weighted(stepping, offsets, Some(&along.model), &Terms::Same(&start.fits), Some(&errors))
        };
        let mut found = fit(&offsets, start)?;
        for _ in 0..ROUNDS {
            self.turn(&found, &mut offsets)?;
            let Ok(next) = fit(&offsets, &found) else { break };
            let gain = found.misfit / next.misfit;
            if gain.is_nan() || gain < 1.0 {
                break;
            }
            found = next;
            if gain < 1.01 {
                break;
            }
        }
        Ok(found)
    }

    /// Moves the offsets that are not zero by what is left of the residuals along the terms' derivatives.
    fn turn(&self, found: &Found, offsets: &mut [f64]) -> Result<(), ModelError> {
        /// Step of the numerical derivative \[rad\].
        const NUDGE: f64 = 1e-5;
        for angle in (0..offsets.len()).filter(|&i| offsets[i] != 0.0).collect::<Vec<_>>() {
            let at = |by: f64| {
                let mut moved = offsets.to_vec();
                moved[angle] += by;
                let used: Vec<usize> = found.fits.iter().flat_map(|f| f.support.iter().copied()).collect();
                let averages = |run: &Run| self.system.averages(run, found.stepping, Some(&found.model), &moved, &used);
                self.runs.iter().map(averages).collect::<Vec<Array2<f64>>>()
            };
            let (up, down) = (at(NUDGE), at(-NUDGE));
            let (mut weight, mut sum) = (0.0, 0.0);
            for (i, fit) in found.fits.iter().enumerate().filter(|(i, _)| self.system.rates[*i].is_none()) {
                let slope = |up: &Array2<f64>, down: &Array2<f64>, t: usize| -> f64 {
                    let terms = fit.support.iter().zip(&fit.coefficients);
                    terms.map(|(&j, c)| c * (up[[t, j]] - down[[t, j]]) / (2.0 * NUDGE)).sum()
                };
                let with_slope: Vec<Array2<f64>> = up
                    .iter()
                    .zip(&down)
                    .map(|(up, down)| {
                        let own = 0.5 * (up.select(Axis(1), &fit.support) + down.select(Axis(1), &fit.support));
                        let slope = Array2::from_shape_fn((up.nrows(), 1), |(t, _)| slope(up, down, t));
                        concatenate![Axis(1), own, slope]
                    })
                    .collect();
                let all: Vec<usize> = (0..=fit.support.len()).collect();
                let triangle = whitened(self.system, self.runs, &with_slope, &all, i, None)?;
                let last = fit.support.len();
                if let (Some(own), Some(left)) = (triangle.column(last).get(last), triangle.column(last + 1).get(last))
                {
                    weight += own * own;
                    sum += own * left;
                }
            }
            if weight > 0.0 {
                offsets[angle] += sum / weight;
            }
        }
        Ok(())
    }
}

fn same_terms(a: &Found, b: &Found) -> bool {
    a.fits.iter().zip(&b.fits).all(|(a, b)| a.support == b.support)
}
