//! Which terms each equation has.

use ndarray::{Array2, Axis, concatenate};

use super::stepping::shown;
use super::whiten::whiten;
use super::{Run, Stepping, System};
use crate::model::ModelError;
use crate::regression::{Space, model};
use crate::solve::{Selected, Selection, binomial};
use crate::{BestSubset, Model, Triangle};

/// Equations found, one per state, and how they are stepped.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) model: Model,
    pub(crate) fits: Vec<Selected>,
    pub(crate) stepping: Stepping,
    /// Condition number of the whitened terms of each equation.
    pub(crate) condition: f64,
    /// Σ of squared, whitened errors of one step, over the fitted equations.
    pub(crate) misfit: f64,
}

/// RMS of whitened residuals that errors of the samples explain: one from the differences, the rest through the terms.
const FLOOR: f64 = 2.0;

/// Rounds of averaging and fitting, at most; each brings the averages about a digit nearer.
const ROUNDS: usize = 25;

/// Searches for terms, at most.
const SEARCHES: usize = 6;

/// Runge–Kutta steps per interval that are tried.
const SUBSTEPS: [usize; 4] = [1, 2, 4, 8];

/// Times by which more substeps must lower χ² to be believed.
const FINER: f64 = 4.0;

/// What is being looked for, and in what.
pub(crate) struct Search<'a> {
    pub(crate) system: &'a System<'a>,
    pub(crate) runs: &'a [Run],
    pub(crate) space: &'a Space,
    pub(crate) solver: &'a BestSubset,
}

/// Where the terms of an equation come from.
enum Terms<'a> {
    /// From the first tier, or from both where that is said.
    Best { wide: &'a [bool] },
    /// They are those of equations found before.
    Same(&'a [Selected]),
}

impl Search<'_> {
    /// The equations behind the runs.
    ///
    /// # Errors
    /// [`ModelError`] if the coefficients are no numbers.
    pub(crate) fn run(&self) -> Result<Found, ModelError> {
        match shown(self.runs, self.system.rates, self.system.dt) {
            Some(Stepping::Continuous { .. }) => self.continuous(),
            Some(stepping) => self.discrete(stepping),
            None => {
                let euler = self.discrete(Stepping::Euler)?;
                let continuous = self.continuous()?;
                Ok(if euler.misfit < continuous.misfit { euler } else { continuous })
            }
        }
    }

    /// Equations stepped by rates at one instant: averages are values there, and do not depend on the equations.
    fn discrete(&self, stepping: Stepping) -> Result<Found, ModelError> {
        let narrow = self.fit(stepping, None, &Terms::Best { wide: &self.none() })?;
        match self.unexplained(&narrow) {
            None => Ok(narrow),
            Some(wide) => self.better(narrow, |_| self.fit(stepping, None, &Terms::Best { wide: &wide })),
        }
    }

    /// Equations in continuous time, with as few Runge–Kutta steps as explain the data.
    fn continuous(&self) -> Result<Found, ModelError> {
        let start = self.fit(Stepping::Continuous { substeps: 1 }, None, &Terms::Best { wide: &self.none() })?;
        let narrow = self.settle(start, &self.none())?;
        match self.unexplained(&narrow) {
            None => Ok(narrow),
            Some(wide) => self.better(narrow, |narrow| {
                let start = self.fit(narrow.stepping, Some(&narrow.model), &Terms::Best { wide: &wide })?;
                self.settle(start, &wide)
            }),
        }
    }

    fn none(&self) -> Vec<bool> {
        vec![false; self.system.rates.len()]
    }

    /// Which equations the first tier does not explain down to the errors of the samples; `None` if there is none.
    fn unexplained(&self, found: &Found) -> Option<Vec<bool>> {
        let wide: Vec<bool> = found.fits.iter().map(|f| !f.reached_floor).collect();
        (self.system.core < self.system.terms.len() && wide.contains(&true)).then_some(wide)
    }

    /// What `widened` finds if it is worth its larger choice of terms, else `narrow`.
    fn better(
        &self,
        narrow: Found,
        widened: impl FnOnce(&Found) -> Result<Found, ModelError>,
    ) -> Result<Found, ModelError> {
        let wide = widened(&narrow)?;
        Ok(if self.score(&wide) < self.score(&narrow) { wide } else { narrow })
    }

    /// N ln χ² + k ln N + 2 ln C(F, k), over all equations: the extended BIC.
    fn score(&self, found: &Found) -> f64 {
        let rows: usize = self.runs.iter().map(Run::len).sum();
        let score = |f: &Selected| {
            let wide = f.support.iter().any(|&j| j >= self.system.core);
            let n_terms = if wide { self.system.terms.len() } else { self.system.core };
            let (n, k) = (rows as f64, f.support.len());
            let variance = f.residual.max(FLOOR).powi(2);
            n * variance.ln() + k as f64 * n.ln() + 2.0 * binomial(n_terms, k).ln()
        };
        found.fits.iter().zip(self.system.rates).filter(|(_, r)| r.is_none()).map(|(f, _)| score(f)).sum()
    }

    /// Averages and fits in turn until the equations stay as they are.
    fn settle(&self, start: Found, wide: &[bool]) -> Result<Found, ModelError> {
        let mut found = self.refine(start)?;
        for _ in 0..SEARCHES {
            let next = self.refine(self.fit(found.stepping, Some(&found.model), &Terms::Best { wide })?)?;
            let same = next.fits.iter().zip(&found.fits).all(|(a, b)| a.support == b.support);
            let worse = next.misfit > found.misfit;
            if same || !worse {
                found = next;
            }
            if same || worse || found.fits.iter().all(|f| f.reached_floor) {
                break;
            }
        }
        Ok(found)
    }

    /// The same terms with averages that agree with them, and the number of substeps that does so best.
    fn refine(&self, start: Found) -> Result<Found, ModelError> {
        let mut best: Option<Found> = None;
        for substeps in SUBSTEPS {
            let from = best.as_ref().unwrap_or(&start);
            let finer = self.agree(from, Stepping::Continuous { substeps })?;
            match &best {
                Some(coarser) if finer.misfit * FINER > coarser.misfit => break,
                _ => best = Some(finer),
            }
        }
        Ok(best.unwrap_or(start))
    }

    fn agree(&self, start: &Found, stepping: Stepping) -> Result<Found, ModelError> {
        let mut found = self.fit(stepping, Some(&start.model), &Terms::Same(&start.fits))?;
        for _ in 0..ROUNDS {
            let next = self.fit(stepping, Some(&found.model), &Terms::Same(&start.fits))?;
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

    /// One round: averages along the way of `along`, then the terms and coefficients of each equation.
    fn fit(&self, stepping: Stepping, along: Option<&Model>, terms: &Terms<'_>) -> Result<Found, ModelError> {
        let system = self.system;
        let theta: Vec<Array2<f64>> = self.runs.iter().map(|run| system.averages(run, stepping, along)).collect();
        let (mut misfit, mut condition) = (0.0, 1.0_f64);
        let mut fits = Vec::with_capacity(system.rates.len());
        for (i, rate) in system.rates.iter().enumerate() {
            if let Some(rate) = *rate {
                fits.push(kinematic(system, rate));
                continue;
            }
            let choice: Vec<usize> = match terms {
                Terms::Same(fits) => fits[i].support.clone(),
                Terms::Best { wide } => {
                    let tried = if wide[i] { system.terms.len() } else { system.core };
                    (0..tried).filter(|&j| system.terms[j].rate != Some(i)).collect()
                }
            };
            let triangle = whitened(system, self.runs, &theta, &choice, i)?;
            let target = choice.len();
            let selected = match terms {
                Terms::Same(_) => Selected::all(&triangle, target, FLOOR),
                Terms::Best { .. } => {
                    let complexity: Vec<u32> = choice.iter().map(|&j| system.terms[j].complexity).collect();
                    self.solver.solve(&triangle, target, Selection { floor: FLOOR, complexity: &complexity, region: None })
                }
            };
            misfit += triangle.residual_norm(&selected.support, &selected.coefficients, target).powi(2);
            condition = condition.max(triangle.condition(&selected.support));
            fits.push(selected.renumbered(&choice));
        }
        let model = model(self.space.clone(), system.terms, &fits, stepping.form(), system.dt)?;
        Ok(Found { model, fits, stepping, condition, misfit })
    }
}

/// The triangle of [Θ of `allowed` | Δxᵢ/Δt], its rows whitened.
fn whitened(
    system: &System<'_>,
    runs: &[Run],
    theta: &[Array2<f64>],
    allowed: &[usize],
    i: usize,
) -> Result<Triangle, ModelError> {
    let mut triangle = Triangle::new(allowed.len() + 1);
    for (run, theta) in runs.iter().zip(theta) {
        let target = Array2::from_shape_fn((run.len(), 1), |(t, _)| (run.x[[t + 1, i]] - run.x[[t, i]]) / system.dt);
        let mut rows = concatenate![Axis(1), theta.select(Axis(1), allowed), target];
        whiten(rows.view_mut(), &run.sigma.column(i).to_vec(), system.dt);
        triangle.push(rows.view()).map_err(|_| ModelError::BadNumber { what: "a term", value: f64::NAN })?;
    }
    Ok(triangle)
}

/// ẋ = v.
fn kinematic(system: &System<'_>, rate: usize) -> Selected {
    let term = system.terms.iter().position(|t| t.rate.is_none() && t.expr == crate::Expr::Variable(rate));
    Selected {
        support: term.into_iter().collect(),
        coefficients: vec![1.0; usize::from(term.is_some())],
        residual: 0.0,
        reached_floor: true,
        proved: true,
        path: Vec::new(),
    }
}
