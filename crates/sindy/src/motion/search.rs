//! Which terms each equation has.

use ndarray::{Array2, Axis, concatenate};

use super::stepping::{FINEST, shown};
use super::tilt::{is_mixed, tilt};
use super::unseen::unseen;
use super::whiten::whiten;
use super::{Run, Stepping, System};
use crate::model::ModelError;
use crate::regression::{Space, model};
use crate::solve::{Selected, Selection, binomial};
use crate::{BestSubset, Expr, Model, Triangle};

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

impl Found {
    /// Whether every equation leaves no more than the errors of the samples explain.
    pub(crate) fn explains(&self) -> bool {
        self.fits.iter().all(|fit| fit.reached_floor)
    }
}

/// Half the RMS of whitened residuals that rounding explains. It is generous: rounding errors are no random numbers, and
/// a system rounds on its way too.
const ROUNDING: f64 = 2.0;

/// RMS of whitened residuals that noise explains: one, and what it does to the averages of curved terms.
const NOISE: f64 = 1.15;

/// Rounds of averaging and fitting, at most; each brings the averages about a digit nearer.
const ROUNDS: usize = 25;

/// Searches for terms, at most.
const SEARCHES: usize = 6;

/// Runge–Kutta steps per interval that are tried.
const SUBSTEPS: [usize; 4] = [1, 2, 4, FINEST];

/// Times by which more substeps must lower χ² to be believed.
const FINER: f64 = 4.0;

/// What is being looked for, and in what.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) system: &'a System<'a>,
    pub(crate) runs: &'a [Run],
    pub(crate) space: &'a Space,
    pub(crate) solver: &'a BestSubset,
    /// Whether the samples have noise of declared size, not only rounding.
    pub(crate) noisy: bool,
}

/// What an equation may be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Choice {
    /// The first tier.
    Core,
    /// The first tier, and waves times the derivative that the equation is for: a moment of inertia that depends on an angle.
    /// Where the angle hardly moves such a term explains a derivative by itself, so it is believed only if nothing is left
    /// to explain.
    Inertia,
    /// Both tiers.
    Wide,
}

/// Where the terms of an equation come from.
enum Terms<'a> {
    /// The best ones of those that are allowed each equation.
    Best(&'a [Choice]),
    /// They are those of equations found before; their residuals are being judged.
    Same(&'a [Selected]),
    /// They are those of equations found before; their averages are being made to agree with them. What is wrong with the
    /// Runge–Kutta steps must show here.
    Agreeing(&'a [Selected]),
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
        self.widening(|choices, _| {
            let found = self.fit(stepping, &self.upright(), None, &Terms::Best(choices))?;
            // Once more, with the errors that enter through the terms.
            let found = self.fit(stepping, &self.upright(), Some(&found.model), &Terms::Best(choices))?;
            self.judged(found)
        })
    }

    /// Equations in continuous time, with as few Runge–Kutta steps as explain the data.
    fn continuous(&self) -> Result<Found, ModelError> {
        self.widening(|choices, before| {
            let Some(before) = before else {
                let stepping = Stepping::Continuous { substeps: 1 };
                let start = self.fit(stepping, &self.upright(), None, &Terms::Best(choices))?;
                let upright = self.settle(start, choices)?;
                return match self.tilted(&upright) {
                    Ok(Some(tilted)) if self.is_simpler(&tilted, &upright) => Ok(tilted),
                    _ => Ok(upright),
                };
            };
            let offsets = before.model.offsets().to_vec();
            let start = self.fit(before.stepping, &offsets, Some(&before.model), &Terms::Best(choices))?;
            self.settle(start, choices)
        })
    }

    /// Half the RMS of `rows` whitened residuals that the errors of the samples explain: for noise, a little more
    /// than one, and three standard deviations of that.
    fn floor(&self, rows: usize) -> f64 {
        if self.noisy { 0.5 * (NOISE + 3.0 / (2.0 * rows.max(1) as f64).sqrt()) } else { ROUNDING }
    }

    /// Whether `found` explains more equations than `other`, or as many with fewer coefficients.
    fn is_simpler(&self, found: &Found, other: &Found) -> bool {
        let unexplained = |found: &Found| found.fits.iter().filter(|f| !f.reached_floor).count();
        let cost = |found: &Found| (unexplained(found), found.model.fitted().len());
        cost(found) < cost(other)
    }

    /// What `search` finds in the first tier, and where that does not explain the data, in more.
    fn widening(
        &self,
        search: impl Fn(&[Choice], Option<&Found>) -> Result<Found, ModelError>,
    ) -> Result<Found, ModelError> {
        let mut found = search(&self.core(), None)?;
        for choice in [Choice::Inertia, Choice::Wide] {
            let Some(unexplained) = self.unexplained(&found) else { break };
            if choice == Choice::Inertia && !self.system.terms.iter().any(|t| t.rate.is_some()) {
                continue;
            }
            let more = |unexplained: &bool| if *unexplained { choice } else { Choice::Core };
            let choices: Vec<Choice> = unexplained.iter().map(more).collect();
            let Ok(wider) = search(&choices, Some(&found)) else { continue };
            if choice == Choice::Inertia {
                let count = |found: &Found| found.fits.iter().filter(|f| f.reached_floor).count();
                if count(&wider) > count(&found) && self.is_regular(&wider) {
                    found = wider;
                }
            } else if self.score(&wider) < self.score(&found) {
                found = wider;
            }
        }
        Ok(found)
    }

    /// The same search with the zeros of angles where the data want them; `None` if they are right where they are.
    fn tilted(&self, upright: &Found) -> Result<Option<Found>, ModelError> {
        let (system, stepping) = (self.system, Stepping::Continuous { substeps: 1 });
        let mixed: Vec<usize> =
            system.angles.iter().copied().filter(|&angle| is_mixed(system, &upright.fits, angle)).collect();
        if mixed.is_empty() {
            return Ok(None);
        }
        let mut offsets = self.upright();
        let core: Vec<usize> = (0..system.core).collect();
        let averages = |run: &Run| system.averages(run, stepping, None, &self.upright(), &core);
        let theta: Vec<Array2<f64>> = self.runs.iter().map(averages).collect();
        let mut triangles = Vec::new();
        for (i, rate) in system.rates.iter().enumerate() {
            let choice = self.choice(Choice::Core, i);
            triangles.push(match rate {
                Some(_) => None,
                None => Some((whitened(system, self.runs, &theta, &choice, i, None)?, choice)),
            });
        }
        for angle in mixed {
            if let Some((delta, _)) = tilt(system, &triangles, &upright.fits, angle) {
                offsets[angle] = delta;
            }
        }
        if offsets.iter().all(|v| *v == 0.0) {
            return Ok(None);
        }
        let start = self.fit(stepping, &offsets, None, &Terms::Best(&self.core()))?;
        self.settle(start, &self.core()).map(Some)
    }

    fn upright(&self) -> Vec<f64> {
        vec![0.0; self.system.rates.len()]
    }

    /// Whether what each equation says of its own derivative, (1 − Σ c w) ẋ, is well away from nothing on all data.
    fn is_regular(&self, found: &Found) -> bool {
        /// Smallest part of 1 + Σ |c| that must be left.
        const LEFT: f64 = 0.1;
        let offsets = found.model.offsets();
        found.fits.iter().enumerate().all(|(i, fit)| {
            let own: Vec<(&Expr, f64)> = fit
                .support
                .iter()
                .zip(&fit.coefficients)
                .filter(|(j, _)| self.system.terms[**j].rate == Some(i))
                .map(|(j, c)| (&self.system.terms[*j].expr, *c))
                .collect();
            let least = LEFT * (1.0 + own.iter().map(|(_, c)| c.abs()).sum::<f64>());
            self.runs.iter().flat_map(|run| run.x.rows().into_iter().take(run.len()).zip(run.u.rows())).all(|(x, u)| {
                let shifted = x.iter().zip(offsets).map(|(x, d)| x + d);
                let z: Vec<f64> = shifted.chain(u.iter().copied()).collect();
                (1.0 - own.iter().map(|(w, c)| c * w.eval(&z)).sum::<f64>()).abs() >= least
            })
        })
    }

    /// Numbers of the terms equation `i` may have.
    fn choice(&self, choice: Choice, i: usize) -> Vec<usize> {
        let system = self.system;
        let tried = if choice == Choice::Wide { system.terms.len() } else { system.core };
        let own = |j: usize| system.terms[j].rate == Some(i);
        let trivial = |j: usize| own(j) && (choice != Choice::Inertia || system.terms[j].expr.is_one());
        (0..tried).filter(|&j| !trivial(j)).collect()
    }

    fn core(&self) -> Vec<Choice> {
        vec![Choice::Core; self.system.rates.len()]
    }

    /// Which equations the first tier does not explain down to the errors of the samples; `None` if there is none.
    fn unexplained(&self, found: &Found) -> Option<Vec<bool>> {
        let wide: Vec<bool> = found.fits.iter().map(|f| !f.reached_floor).collect();
        (self.system.core < self.system.terms.len() && wide.contains(&true)).then_some(wide)
    }

    /// N ln σ² + k ln N + 2 ln C(F, k), over all equations: the extended BIC.
    fn score(&self, found: &Found) -> f64 {
        let rows: usize = self.runs.iter().map(Run::len).sum();
        let score = |f: &Selected| {
            let wide = f.support.iter().any(|&j| j >= self.system.core);
            let n_terms = if wide { self.system.terms.len() } else { self.system.core };
            let (n, k) = (rows as f64, f.support.len());
            let variance = f.residual.max(2.0 * self.floor(rows)).powi(2);
            n * variance.ln() + k as f64 * n.ln() + 2.0 * binomial(n_terms, k).ln()
        };
        let tilts = found.model.offsets().iter().filter(|v| **v != 0.0).count();
        let fitted = found.fits.iter().zip(self.system.rates).filter(|(_, r)| r.is_none());
        fitted.map(|(f, _)| score(f)).sum::<f64>() + tilts as f64 * (rows as f64).ln()
    }

    /// Averages and fits in turn until the equations stay as they are.
    fn settle(&self, start: Found, choices: &[Choice]) -> Result<Found, ModelError> {
        let mut found = self.refine(start.clone()).unwrap_or(start);
        for _ in 0..SEARCHES {
            let offsets = found.model.offsets().to_vec();
            let search = |stepping| self.fit(stepping, &offsets, Some(&found.model), &Terms::Best(choices));
            // A model that leaves the finite numbers on its way leads nowhere.
            let Ok(next) = self.finest(search) else { break };
            let same = next.fits.iter().zip(&found.fits).all(|(a, b)| a.support == b.support);
            if same {
                // What was looked at on the way belongs to the account.
                found.fits = next.fits;
                break;
            }
            let simpler = next.model.fitted().len() < found.model.fitted().len();
            let Ok(next) = self.refine(next) else { break };
            let explained = self.judged(next.clone())?.fits.iter().all(|f| f.reached_floor);
            let worse = next.misfit > found.misfit && !(simpler && explained);
            if !worse {
                found = next;
            }
            if worse {
                break;
            }
        }
        self.judged(found)
    }

    /// The same with a verdict on each equation: whether its residual is no more than the errors of the samples, those that
    /// enter through the terms, and those of the Runge–Kutta steps.
    fn judged(&self, mut found: Found) -> Result<Found, ModelError> {
        let offsets = found.model.offsets().to_vec();
        let judged = self.fit(found.stepping, &offsets, Some(&found.model), &Terms::Same(&found.fits))?;
        for (fit, verdict) in found.fits.iter_mut().zip(judged.fits) {
            fit.reached_floor = verdict.reached_floor;
            fit.residual = verdict.residual;
        }
        Ok(found)
    }

    /// Per state: RMS of Δx/Δt − Σ c θ̄, and what of it the errors of the samples explain, in the unit of the rate.
    pub(crate) fn residuals(&self, found: &Found) -> Vec<(f64, f64)> {
        let offsets = found.model.offsets();
        let all: Vec<usize> = found.fits.iter().flat_map(|f| f.support.iter().copied()).collect();
        let rows = self.runs.iter().map(Run::len).sum::<usize>().max(1) as f64;
        let mut sums = vec![(0.0, 0.0); found.fits.len()];
        for run in self.runs {
            let theta = self.system.averages(run, found.stepping, Some(&found.model), offsets, &all);
            let extra = unseen(&found.model, found.stepping, run, self.system.dt, true);
            for (i, fit) in found.fits.iter().enumerate() {
                for t in 0..run.len() {
                    let explained: f64 =
                        fit.support.iter().zip(&fit.coefficients).map(|(&j, c)| c * theta[[t, j]]).sum();
                    let left = (run.x[[t + 1, i]] - run.x[[t, i]]) / self.system.dt - explained;
                    let seen = run.sigma[[t, i]].hypot(run.sigma[[t + 1, i]]) / self.system.dt;
                    sums[i].0 += left * left;
                    sums[i].1 += seen * seen + extra[[t, i]] * extra[[t, i]];
                }
            }
        }
        sums.into_iter().map(|(left, seen): (f64, f64)| ((left / rows).sqrt(), (seen / rows).sqrt())).collect()
    }

    /// The same terms with averages that agree with them, and the number of substeps that does so best.
    fn refine(&self, start: Found) -> Result<Found, ModelError> {
        self.finest(|stepping| self.agree(&start, stepping))
    }

    /// What `find` finds with as many substeps as are clearly better than fewer.
    fn finest(&self, find: impl Fn(Stepping) -> Result<Found, ModelError>) -> Result<Found, ModelError> {
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
        let mut found = self.fit(stepping, &offsets, Some(&start.model), &Terms::Agreeing(&start.fits))?;
        for _ in 0..ROUNDS {
            self.turn(&found, &mut offsets)?;
            let Ok(next) = self.fit(stepping, &offsets, Some(&found.model), &Terms::Agreeing(&start.fits)) else {
                break;
            };
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
            let (here, up, down) = (at(0.0), at(NUDGE), at(-NUDGE));
            let (mut weight, mut sum) = (0.0, 0.0);
            for (i, fit) in found.fits.iter().enumerate().filter(|(i, _)| self.system.rates[*i].is_none()) {
                let slope = |up: &Array2<f64>, down: &Array2<f64>, t: usize| -> f64 {
                    let terms = fit.support.iter().zip(&fit.coefficients);
                    terms.map(|(&j, c)| c * (up[[t, j]] - down[[t, j]]) / (2.0 * NUDGE)).sum()
                };
                let with_slope: Vec<Array2<f64>> = here
                    .iter()
                    .zip(up.iter().zip(&down))
                    .map(|(here, (up, down))| {
                        let own = here.select(Axis(1), &fit.support);
                        let slope = Array2::from_shape_fn((here.nrows(), 1), |(t, _)| slope(up, down, t));
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

    /// One round: averages along the way of `along`, then the terms and coefficients of each equation.
    fn fit(
        &self,
        stepping: Stepping,
        offsets: &[f64],
        along: Option<&Model>,
        terms: &Terms<'_>,
    ) -> Result<Found, ModelError> {
        let system = self.system;
        let wanted: Vec<usize> = match terms {
            Terms::Same(fits) | Terms::Agreeing(fits) => {
                let mut used: Vec<usize> = fits.iter().flat_map(|f| f.support.iter().copied()).collect();
                used.sort_unstable();
                used.dedup();
                used
            }
            Terms::Best(choices) if choices.contains(&Choice::Wide) => (0..system.terms.len()).collect(),
            Terms::Best(_) => (0..system.core).collect(),
        };
        let averages = |run: &Run| system.averages(run, stepping, along, offsets, &wanted);
        let theta: Vec<Array2<f64>> = self.runs.iter().map(averages).collect();
        let numerical = !matches!(terms, Terms::Agreeing(_));
        let extra: Option<Vec<Array2<f64>>> =
            along.map(|model| self.runs.iter().map(|run| unseen(model, stepping, run, system.dt, numerical)).collect());
        let (mut misfit, mut condition) = (0.0, 1.0_f64);
        let mut fits = Vec::with_capacity(system.rates.len());
        for (i, rate) in system.rates.iter().enumerate() {
            if let Some(rate) = *rate {
                fits.push(kinematic(system, rate));
                continue;
            }
            let choice: Vec<usize> = match terms {
                Terms::Same(fits) | Terms::Agreeing(fits) => fits[i].support.clone(),
                Terms::Best(choices) => self.choice(choices[i], i),
            };
            let triangle = whitened(system, self.runs, &theta, &choice, i, extra.as_deref())?;
            let target = choice.len();
            let selected = match terms {
                Terms::Same(_) | Terms::Agreeing(_) => Selected::all(&triangle, target, self.floor(triangle.n_rows())),
                Terms::Best(_) => {
                    let complexity: Vec<u32> = choice.iter().map(|&j| system.terms[j].complexity).collect();
                    let floor = if self.noisy { 0.0 } else { ROUNDING };
                    self.solver.solve(&triangle, target, Selection { floor, complexity: &complexity, region: None })
                }
            };
            misfit += triangle.residual_norm(&selected.support, &selected.coefficients, target).powi(2);
            condition = condition.max(triangle.condition(&selected.support));
            fits.push(selected.renumbered(&choice));
        }
        let model = model(self.space.clone(), system.terms, &fits, stepping.form(), system.dt)?.with_offsets(offsets);
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
    extra: Option<&[Array2<f64>]>,
) -> Result<Triangle, ModelError> {
    let mut triangle = Triangle::new(allowed.len() + 1);
    for (at, (run, theta)) in runs.iter().zip(theta).enumerate() {
        let target = Array2::from_shape_fn((run.len(), 1), |(t, _)| (run.x[[t + 1, i]] - run.x[[t, i]]) / system.dt);
        let mut rows = concatenate![Axis(1), theta.select(Axis(1), allowed), target];
        let extra = extra.map_or_else(|| vec![0.0; run.len()], |e| e[at].column(i).to_vec());
        whiten(rows.view_mut(), &run.sigma.column(i).to_vec(), &extra, system.dt);
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
