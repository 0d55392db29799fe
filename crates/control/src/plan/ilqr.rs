//! Improving a plan by differential dynamic programming.

use super::objective::{Expansion, Objective};
use super::plant::{Plant, unused};
use super::small::{box_newton, is_positive};
use ndarray::{Array1, Array2};

/// Parts of a step that are tried, one after the other.
const PARTS: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.01];

/// Regularisation, as a part of the curvature: the first, and the largest.
const FIRST: f64 = 1e-6;
const LARGEST: f64 = 1e10;

/// Part of the cost by which an iteration must better it to be followed by another.
const CONVERGED: f64 = 1e-5;

/// Changes of the controls (T, k), and gains of all steps, each (k, n).
type Law = (Vec<Array1<f64>>, Vec<Array2<f64>>);

/// Controls from a state, where they lead, and how to correct them on the way.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// States (T + 1, n).
    pub(crate) x: Vec<Vec<f64>>,
    /// Controls (T, k).
    pub(crate) u: Vec<Vec<f64>>,
    /// u − u_t = K_t (x − x_t), each (k, n).
    pub(crate) gains: Vec<Array2<f64>>,
    pub(crate) cost: f64,
}

impl Plan {
    /// What `controls` lead to from `start`; `None` where the model diverges.
    pub(crate) fn of(plant: &Plant, objective: &Objective<'_>, start: &[f64], controls: Vec<Vec<f64>>) -> Option<Self> {
        let (n, k) = plant.dims();
        let gains = vec![Array2::zeros((k, n)); controls.len()];
        let x = vec![start.to_vec(); controls.len() + 1];
        Self { x, u: controls, gains, cost: f64::INFINITY }.followed(plant, objective, start, None)
    }

    /// The plan from `start`, by its gains, plus a part of the `change` of its controls.
    pub(crate) fn followed(
        &self,
        plant: &Plant,
        objective: &Objective<'_>,
        start: &[f64],
        change: Option<(&[Array1<f64>], f64)>,
    ) -> Option<Self> {
        let mut rng = unused();
        let (steps, mut cost) = (self.u.len(), 0.0);
        let mut plan = Self { x: Vec::with_capacity(steps + 1), u: Vec::with_capacity(steps), gains: Vec::new(), cost };
        plan.x.push(start.to_vec());
        for t in 0..steps {
            let x = &plan.x[t];
            let off: Array1<f64> = x.iter().zip(&self.x[t]).map(|(x, planned)| x - planned).collect();
            let mut u: Vec<f64> = self.gains[t].dot(&off).iter().zip(&self.u[t]).map(|(du, u)| u + du).collect();
            if let Some((change, part)) = change {
                u.iter_mut().zip(&change[t]).for_each(|(u, change)| *u += part * change);
            }
            plant.clamp(&mut u);
            let mut next = vec![0.0; x.len()];
            let stepped = plant.step(x, &u, &mut rng, &mut next)?;
            cost += objective.of_step(plant, stepped, &u);
            plan.x.push(next);
            plan.u.push(u);
        }
        plan.cost = cost + objective.of_end(&plan.x[steps]);
        plan.gains.clone_from(&self.gains);
        plan.cost.is_finite().then_some(plan)
    }

    /// The plan after so many iterations of differential dynamic programming at most, with limits of the controls. Second derivatives of the
    /// dynamics are left out (iLQR), those of the rewards made positive.
    ///
    /// # References
    /// Li, Todorov (2004), ICINCO, "Iterative linear quadratic regulator design". Tassa, Mansard, Todorov (2014), ICRA, "Control-limited
    /// differential dynamic programming", doi:10.1109/ICRA.2014.6907001.
    pub(crate) fn improved(mut self, plant: &Plant, objective: &Objective<'_>, iterations: usize) -> Self {
        let mut damping = FIRST;
        let mut expansions: Option<Vec<Expansion>> = None;
        for _ in 0..iterations {
            if plant.stopped() {
                break;
            }
            let Some(local) = expansions.take().or_else(|| self.expanded(plant, objective)) else { break };
            let Some((change, gains)) = self.backward(plant, objective, &local, damping) else {
                damping *= 10.0;
                if damping > LARGEST {
                    break;
                }
                expansions = Some(local);
                continue;
            };
            self.gains = gains;
            let start = self.x[0].clone();
            let better = PARTS.iter().find_map(|part| {
                let tried = self.followed(plant, objective, &start, Some((&change, *part)))?;
                (tried.cost < self.cost).then_some(tried)
            });
            match better {
                Some(better) => {
                    let gained = self.cost - better.cost;
                    let enough = gained > CONVERGED * self.cost.abs();
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
        let (mut vx, mut vxx) = objective.expand_end(&self.x[steps]);
        let (mut change, mut gains) = (vec![Array1::zeros(k); steps], vec![Array2::zeros((k, n)); steps]);
        for t in (0..steps).rev() {
            let Expansion { a, b, lx, lu, lxx, lux, luu } = &local[t];
            let (va, vb) = (vxx.dot(a), vxx.dot(b));
            let qx = lx + &a.t().dot(&vx);
            let qu = lu + &b.t().dot(&vx);
            let qxx = lxx + &a.t().dot(&va);
            let qux = lux + &b.t().dot(&va);
            let quu = luu + &b.t().dot(&vb);
            let mut damped = quu.clone();
            for j in 0..k {
                damped[[j, j]] += damping * (1.0 + quu[[j, j]].abs());
            }
            if !is_positive(&damped) {
                return None;
            }
            let range = |end: &[f64]| -> Vec<f64> { end.iter().zip(&self.u[t]).map(|(end, u)| end - u).collect() };
            let (du, gain) = box_newton(&damped, &qu, &qux, &range(&plant.low), &range(&plant.high))?;
            vx = &qx + &gain.t().dot(&quu.dot(&du)) + &gain.t().dot(&qu) + &qux.t().dot(&du);
            let cross = gain.t().dot(&qux);
            vxx = &qxx + &gain.t().dot(&quu).dot(&gain) + &cross + cross.t();
            vxx = 0.5 * (&vxx + &vxx.t());
            (change[t], gains[t]) = (du, gain);
        }
        Some((change, gains))
    }
}
