//! Mechanics as a hypothesis among others: regressions of one Lagrangian for the equations of all joints.

use ndarray::Array2;

use super::hypothesis::{Hypothesis, Start};
use super::problem::{Problem, Structure};
use super::propose::THOROUGHLY;
use super::search::Level;
use crate::Triangle;
use crate::data::{Segment, Signals};
use crate::library::{Lagrangian, Term};
use crate::mechanics::{Steps, balance, weighed};
use crate::motion::Stepping;

/// Steps over which momenta are balanced together where samples have noise, which averages out.
const WINDOW: usize = 16;

/// Sets of parameters that are tried.
const ELBOWS: usize = 4;

/// Part of the momentum that is left unexplained, beyond which a set of parameters is none.
const EXPLAINED: f64 = 0.2;

/// Part of the budget of a search, for mechanics.
const SHARE: f64 = 0.2;

/// Part of the momentum that is rounding.
const NOTHING: f64 = 1e-13;

/// Parameters with their values, and by how much more is left without the one of them that is missed least.
struct Elbow {
    jump: f64,
    parameters: Vec<(usize, f64)>,
}

impl Problem<'_> {
    /// The best hypothesis whose terms are those of a Lagrangian, if it leaves noise alone. Its terms do so at all `levels` before they are fitted to the
    /// last digit.
    pub(super) fn mechanical(&self, signals: &Signals, levels: &[Level], stepping: Stepping) -> Option<Hypothesis> {
        let lagrangian = self.lagrangian?;
        self.with_share(SHARE, |problem| problem.mechanical_of(lagrangian, signals, levels, stepping))
    }

    fn mechanical_of(
        &self,
        lagrangian: &Lagrangian,
        signals: &Signals,
        levels: &[Level],
        stepping: Stepping,
    ) -> Option<Hypothesis> {
        let measured: Vec<Array2<f64>> = self.segments.iter().map(|s| s.x.clone()).collect();
        let mut best: Option<Hypothesis> = None;
        for (window, x) in [(1, &measured), (WINDOW, &signals.x)] {
            let balance = self.balance(lagrangian, x, stepping);
            for (supports, xi) in self.lagrangians(lagrangian, &balance, window) {
                let Some(rough) = self.settled_at(levels, (supports, &xi), stepping) else { continue };
                let Some(found) = self.fitted(&rough, signals) else { continue };
                let found = self.as_simulated(found);
                if self.is_settled(&found) && best.as_ref().is_none_or(|b| found.score < b.score) {
                    best = Some(found);
                }
            }
            if best.is_some() {
                break;
            }
        }
        best
    }

    /// The terms `supports`, fitted at one of `levels` after the other, if they leave noise alone at each.
    fn settled_at(
        &self,
        levels: &[Level],
        (supports, xi): (Vec<Vec<usize>>, &[f64]),
        stepping: Stepping,
    ) -> Option<Hypothesis> {
        let mut settled: Option<Hypothesis> = None;
        for Level { floor, signals } in levels {
            let problem = Problem { floor, noise: &signals.sigma, ..*self };
            let begun = Start { xi, inside: &[], x: &signals.x, sigma: &signals.sigma };
            let found = match &settled {
                None => problem.hypothesis(supports.clone(), stepping, begun, 0..4)?,
                Some(rough) => problem.fitted(rough, signals)?,
            };
            let found = if problem.is_settled(&found) { found } else { problem.as_simulated(found) };
            if !problem.is_settled(&found) {
                return None;
            }
            settled = Some(found);
        }
        settled
    }

    /// Per segment and joint, a row for each step of the states `x` (T + 1, n): what every parameter would change of the momentum minus what it does (T, P).
    fn balance(&self, lagrangian: &Lagrangian, x: &[Array2<f64>], stepping: Stepping) -> Vec<Vec<Array2<f64>>> {
        let of = |(segment, x): (&Segment, &Array2<f64>)| {
            let u = segment.mean_inputs();
            let steps = Steps { x: x.view(), u: u.view(), dt: &segment.dt };
            balance(lagrangian, steps, !stepping.is_continuous())
        };
        self.segments.iter().zip(x).map(of).collect()
    }

    /// The terms and coefficients of the likeliest Lagrangians, momenta balanced over `window` steps.
    fn lagrangians(&self, lagrangian: &Lagrangian, balance: &[Vec<Array2<f64>>], window: usize) -> Vec<Structure> {
        let rows: Vec<Vec<Array2<f64>>> =
            balance.iter().map(|s| s.iter().map(|r| windowed(r, window)).collect()).collect();
        let mut found: Vec<Elbow> = Vec::new();
        for unit in lagrangian.units() {
            let choice: Vec<usize> = lagrangian.others(unit);
            let Some(triangle) = weighed(lagrangian, &rows, (unit, &choice)) else { continue };
            found.extend(self.elbows(&triangle, (unit, &choice)));
        }
        found.sort_by(|a, b| b.jump.total_cmp(&a.jump));
        found.truncate(ELBOWS);
        found.iter().filter_map(|elbow| self.structure(lagrangian, &elbow.parameters)).collect()
    }

    /// The best sets of parameters of each size, at which the residual falls most.
    fn elbows(&self, triangle: &Triangle, (unit, choice): (usize, &[usize])) -> Vec<Elbow> {
        let target = choice.len();
        let whole = triangle.norm(target);
        let solver = self.solver.within(THOROUGHLY.budget);
        let of = (target, THOROUGHLY.starts);
        let found = solver.candidates(triangle, of, &vec![0; target], self.watch.asks(), |_| false);
        self.charge(found.work);
        let mut elbows: Vec<Elbow> = Vec::new();
        let mut before = 1.0;
        for best in found.sizes.iter().filter_map(|(subsets, _)| subsets.first()) {
            let left = best.rss.max(0.0).sqrt() / whole + NOTHING;
            if left < EXPLAINED {
                let values = triangle.solve_unit(&best.support, target);
                let own = best.support.iter().map(|&c| choice[c]).zip(values);
                elbows.push(Elbow { jump: before / left, parameters: own.chain([(unit, 1.0)]).collect() });
            }
            before = left;
        }
        elbows.sort_by(|a, b| b.jump.total_cmp(&a.jump));
        elbows.truncate(ELBOWS);
        elbows
    }

    /// The terms of the problem that the equations of a Lagrangian have. `None` if one is missing there.
    fn structure(&self, lagrangian: &Lagrangian, parameters: &[(usize, f64)]) -> Option<Structure> {
        let equations = lagrangian.equations(parameters)?;
        let mut supports = vec![Vec::new(); self.rates.len()];
        let mut coefficients: Vec<Vec<f64>> = vec![Vec::new(); self.rates.len()];
        for (equation, (_, speed)) in equations.into_iter().zip(&lagrangian.joints) {
            let place = |((expr, rate), value): ((crate::Expr, Option<usize>), f64)| {
                let is_it = |t: &Term| t.rate == rate && t.expr == expr;
                Some((self.terms[..self.n_plain].iter().position(is_it)?, value))
            };
            let mut own: Vec<(usize, f64)> = equation.into_iter().map(place).collect::<Option<_>>()?;
            own.sort_by_key(|(j, _)| *j);
            (supports[*speed], coefficients[*speed]) = own.into_iter().unzip();
        }
        Some((supports, coefficients.concat()))
    }
}

/// Rows added up over windows of that many steps with a weight that vanishes smoothly at both ends; the rows themselves for one step.
fn windowed(rows: &Array2<f64>, window: usize) -> Array2<f64> {
    if window <= 1 {
        return rows.clone();
    }
    let weight = |t: usize| {
        let s = 2.0 * (t as f64 + 1.0) / (window as f64 + 1.0) - 1.0;
        (1.0 - s * s).powi(3)
    };
    let starts: Vec<usize> = (0..(rows.nrows() + 1).saturating_sub(window)).collect();
    let mut summed = Array2::zeros((starts.len(), rows.ncols()));
    for (mut row, &start) in summed.rows_mut().into_iter().zip(&starts) {
        (0..window).for_each(|t| row.scaled_add(weight(t), &rows.row(start + t)));
    }
    summed
}
