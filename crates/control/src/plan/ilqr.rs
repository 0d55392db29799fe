//! Improving a plan by differential dynamic programming.

use std::f64::consts::TAU;

use super::objective::{Expansion, Objective};
use super::plant::{Plant, unused};
use super::small::{add_product, add_transposed, box_newton, is_positive};
use ndarray::{Array1, Array2};

/// Parts of a step that are tried, one after the other.
const PARTS: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.01];

/// Regularisation, as a part of the curvature: the first, and the largest.
const FIRST: f64 = 1e-6;
const LARGEST: f64 = 1e10;

/// Part of the cost by which an iteration must better it to be followed by another.
const CONVERGED: f64 = 1e-5;

/// What a gap costs, beside the largest slope of the cost to go: from 1 on closing it always pays.
const DEAR: f64 = 1.5;

/// What one pass backward comes to.
struct Law {
    /// Changes of the controls (T, k).
    change: Vec<Array1<f64>>,
    /// Gains of all steps, each (k, n).
    gains: Vec<Array2<f64>>,
    /// The largest slope of the cost to go, for a change by a scale.
    slope: f64,
}

/// Controls from a state, where they lead, and how to correct them on the way.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// States (T + 1, n).
    pub(crate) x: Vec<Vec<f64>>,
    /// Controls (T, k).
    pub(crate) u: Vec<Vec<f64>>,
    /// u − u_t = K_t (x − x_t), each (k, n).
    pub(crate) gains: Vec<Array2<f64>>,
    /// F(x_t, u_t) − x_{t+1}, (T, n), where states were guessed; none where they follow from the controls.
    gaps: Vec<Vec<f64>>,
    pub(crate) cost: f64,
}

impl Plan {
    /// What `controls` lead to from `start`; `None` where the model diverges.
    pub(crate) fn of(plant: &Plant, objective: &Objective<'_>, start: &[f64], controls: Vec<Vec<f64>>) -> Option<Self> {
        let (n, k) = plant.dims();
        let gains = vec![Array2::zeros((k, n)); controls.len()];
        let x = vec![start.to_vec(); controls.len() + 1];
        Self { x, u: controls, gains, gaps: Vec::new(), cost: f64::INFINITY }.followed(plant, objective, start, None)
    }

    /// Guessed states (T + 1, n) under `controls` (T, k), which need not lead from one to the next; `None` where the model diverges.
    pub(crate) fn through(
        plant: &Plant,
        objective: &Objective<'_>,
        x: Vec<Vec<f64>>,
        controls: Vec<Vec<f64>>,
    ) -> Option<Self> {
        let ((n, k), mut rng) = (plant.dims(), unused());
        let (mut cost, mut gaps) =
            (objective.of_end(plant, controls.len(), x.last()?), Vec::with_capacity(controls.len()));
        for (t, (pair, u)) in x.windows(2).zip(&controls).enumerate() {
            let mut next = vec![0.0; n];
            objective.step(plant, &pair[0], u, (&mut rng, &mut next))?;
            next.iter_mut().zip(&pair[1]).for_each(|(next, guessed)| *next -= guessed);
            gaps.push(next);
            cost += objective.of_step(plant, objective.paid(plant, &pair[0], u, &pair[1])?, (t, &pair[0], u));
        }
        let gains = vec![Array2::zeros((k, n)); controls.len()];
        cost.is_finite().then_some(Self { x, u: controls, gains, gaps, cost })
    }

    /// The same with whole turns added to its states, so that the one after `made` steps is less than half a turn from x.
    pub(crate) fn turned(&self, plant: &Plant, made: usize, x: &[f64]) -> Self {
        let mut turned = self.clone();
        for i in (0..x.len()).filter(|i| plant.turns[*i]) {
            let turns = ((x[i] - self.x[made.min(self.u.len())][i]) / TAU).round() * TAU;
            turned.x.iter_mut().for_each(|state| state[i] += turns);
        }
        turned
    }

    /// The sum of all gaps, in scales.
    fn apart(&self, plant: &Plant) -> f64 {
        let of = |gap: &Vec<f64>| gap.iter().zip(&plant.scales).map(|(gap, scale)| gap.abs() / scale).sum::<f64>();
        self.gaps.iter().map(of).sum()
    }

    /// Whether its states follow from its controls.
    pub(crate) fn is_closed(&self) -> bool {
        self.gaps.is_empty()
    }

    /// The plan from `start`, by its gains, plus a part of the `change` of its controls, by which gaps are smaller as well.
    pub(crate) fn followed(
        &self,
        plant: &Plant,
        objective: &Objective<'_>,
        start: &[f64],
        change: Option<(&[Array1<f64>], f64)>,
    ) -> Option<Self> {
        let mut rng = unused();
        let (steps, mut cost) = (self.u.len(), 0.0);
        let (x, u) = (Vec::with_capacity(steps + 1), Vec::with_capacity(steps));
        let mut plan = Self { x, u, gains: Vec::new(), gaps: Vec::new(), cost };
        let open = 1.0 - change.map_or(1.0, |(_, part)| part);
        plan.x.push(start.to_vec());
        for t in 0..steps {
            let x = &plan.x[t];
            let mut u = self.u[t].clone();
            for (u, gains) in u.iter_mut().zip(self.gains[t].rows()) {
                *u +=
                    gains.iter().zip(x.iter().zip(&self.x[t])).map(|(g, (x, planned))| g * (x - planned)).sum::<f64>();
            }
            if let Some((change, part)) = change {
                u.iter_mut().zip(&change[t]).for_each(|(u, change)| *u += part * change);
            }
            plant.clamp(&mut u);
            let mut next = vec![0.0; x.len()];
            let mut stepped = objective.step(plant, x, &u, (&mut rng, &mut next))?;
            if let Some(gap) = self.gaps.get(t).filter(|_| open > 0.0) {
                plan.gaps.push(gap.iter().map(|gap| open * gap).collect());
                next.iter_mut().zip(gap).for_each(|(next, gap)| *next -= open * gap);
                stepped = objective.paid(plant, x, &u, &next)?;
            }
            cost += objective.of_step(plant, stepped, (t, x, &u));
            plan.x.push(next);
            plan.u.push(u);
        }
        plan.cost = cost + objective.of_end(plant, steps, &plan.x[steps]);
        plan.gains.clone_from(&self.gains);
        plan.cost.is_finite().then_some(plan)
    }

    /// The plan after so many iterations of differential dynamic programming at most, with limits of the controls. Second derivatives of the
    /// dynamics are left out (iLQR), those of the rewards made positive. Gaps between guessed states are closed on the way (multiple shooting): a part of a step
    /// leaves as much of them open.
    ///
    /// # References
    /// Li, Todorov (2004), ICINCO, "Iterative linear quadratic regulator design". Tassa, Mansard, Todorov (2014), ICRA, "Control-limited
    /// differential dynamic programming", doi:10.1109/ICRA.2014.6907001. Mastalli et
    /// al. (2020), ICRA, "Crocoddyl: an efficient and versatile framework for multi-contact optimal control", §III (gaps), doi:10.1109/ICRA40945.2020.9196673.
    pub(crate) fn improved(mut self, plant: &Plant, objective: &Objective<'_>, iterations: usize) -> Self {
        let (mut damping, mut dear) = (FIRST, 0.0_f64);
        let mut expansions: Option<Vec<Expansion>> = None;
        for _ in 0..iterations {
            if plant.stopped() {
                break;
            }
            let Some(local) = expansions.take().or_else(|| self.expanded(plant, objective)) else { break };
            let Some(Law { change, gains, slope }) = self.backward(plant, objective, &local, damping) else {
                damping *= 10.0;
                if damping > LARGEST {
                    break;
                }
                expansions = Some(local);
                continue;
            };
            self.gains = gains;
            let start = self.x[0].clone();
            dear = dear.max(DEAR * slope);
            let worth = |plan: &Self| if plan.is_closed() { plan.cost } else { plan.cost + dear * plan.apart(plant) };
            let now = worth(&self);
            let better = PARTS.iter().find_map(|part| {
                let tried = self.followed(plant, objective, &start, Some((&change, *part)))?;
                (worth(&tried) < now).then_some(tried)
            });
            match better {
                Some(better) => {
                    let enough = !better.is_closed() || now - better.cost > CONVERGED * now.abs();
                    self = better;
                    damping = (damping / 10.0).max(FIRST);
                    if !enough {
                        break;
                    }
                }
                None => {
                    damping *= 100.0;
                    if damping > LARGEST {
                        break;
                    }
                    expansions = Some(local);
                }
            }
        }
        self
    }

    fn expanded(&self, plant: &Plant, objective: &Objective<'_>) -> Option<Vec<Expansion>> {
        let mut rng = unused();
        (0..self.u.len()).map(|t| objective.expand(plant, (&self.x[t], &self.u[t], &self.x[t + 1]), &mut rng)).collect()
    }

    /// Changes of the controls and gains; `None` where the curvature is not positive.
    fn backward(&self, plant: &Plant, objective: &Objective<'_>, local: &[Expansion], damping: f64) -> Option<Law> {
        let (steps, (n, k)) = (self.u.len(), plant.dims());
        let (mut vx, mut vxx) = objective.expand_end(plant, steps, &self.x[steps]);
        let (mut change, mut gains) = (vec![Array1::zeros(k); steps], vec![Array2::zeros((k, n)); steps]);
        let mut slope = 0.0_f64;
        let zeros = |count: usize| vec![0.0; count];
        let (mut va, mut vb, mut next) = (zeros(n * n), zeros(n * k), zeros(n));
        let (mut qx, mut qu) = (zeros(n), zeros(k));
        let (mut qxx, mut qux) = (zeros(n * n), zeros(k * n));
        let (mut quu, mut damped) = (Array2::zeros((k, k)), Array2::zeros((k, k)));
        for t in (0..steps).rev() {
            let Expansion { a, b, reward } = &local[t];
            let (a, b) = (a.as_slice()?, b.as_slice()?);
            if let Some(gap) = self.gaps.get(t) {
                next.fill(0.0);
                add_product(&vxx, gap, n, &mut next);
                vx.iter_mut().zip(&next).for_each(|(v, by)| *v += by);
            }
            match reward {
                Some((g, h)) => {
                    (0..n).for_each(|i| qx[i] = g[i]);
                    (0..k).for_each(|j| qu[j] = g[n + j]);
                    (0..n * n).for_each(|at| qxx[at] = h[[at / n, at % n]]);
                    (0..k * n).for_each(|at| qux[at] = h[[n + at / n, at % n]]);
                    quu.indexed_iter_mut().for_each(|((i, j), q)| *q = h[[n + i, n + j]]);
                }
                None => {
                    [&mut qx, &mut qu, &mut qxx, &mut qux].into_iter().for_each(|q| q.fill(0.0));
                    quu.fill(0.0);
                }
            }
            objective.add_place(plant, (t, &self.x[t]), (&mut qx, &mut qxx));
            for (j, u) in self.u[t].iter().enumerate() {
                let (slope, bend) = objective.of_effort(plant, j, *u);
                qu[j] += slope;
                quu[[j, j]] += bend;
            }
            va.fill(0.0);
            vb.fill(0.0);
            add_product(&vxx, a, n, &mut va);
            add_product(&vxx, b, n, &mut vb);
            add_transposed(a, &vx, n, &mut qx);
            add_transposed(b, &vx, n, &mut qu);
            add_transposed(a, &va, n, &mut qxx);
            add_transposed(b, &va, n, &mut qux);
            add_transposed(b, &vb, n, quu.as_slice_mut()?);
            damped.assign(&quu);
            for j in 0..k {
                damped[[j, j]] += damping * (1.0 + quu[[j, j]].abs());
            }
            if !is_positive(&damped) {
                return None;
            }
            let range = |end: &[f64]| -> Vec<f64> { end.iter().zip(&self.u[t]).map(|(end, u)| end - u).collect() };
            let (du, gain) = box_newton(&damped, &qu, &qux, &range(&plant.low), &range(&plant.high))?;
            // V_x = Q_x + Kᵀ(Q_uu du + Q_u) + Q_uxᵀ du, V_xx = Q_xx + Kᵀ Q_uu K + Kᵀ Q_ux + Q_uxᵀ K.
            for i in 0..n {
                vx[i] = qx[i];
                for j in 0..k {
                    let turned: f64 = (0..k).map(|l| quu[[j, l]] * du[l]).sum();
                    vx[i] += gain[[j, i]] * (turned + qu[j]) + qux[j * n + i] * du[j];
                }
            }
            for i in 0..n {
                for other in 0..=i {
                    let mut v = 0.5 * (qxx[i * n + other] + qxx[other * n + i]);
                    for j in 0..k {
                        let turned = |at: usize| (0..k).map(|l| quu[[j, l]] * gain[[l, at]]).sum::<f64>();
                        v += 0.5 * (gain[[j, i]] * turned(other) + gain[[j, other]] * turned(i));
                        v += gain[[j, i]] * qux[j * n + other] + gain[[j, other]] * qux[j * n + i];
                    }
                    (vxx[i * n + other], vxx[other * n + i]) = (v, v);
                }
            }
            slope = vx.iter().zip(&plant.scales).map(|(v, scale)| (v * scale).abs()).fold(slope, f64::max);
            (change[t], gains[t]) = (du, gain);
        }
        Some(Law { change, gains, slope })
    }
}
