//! What a plan is to make small, and its second-order expansion.

use ndarray::{Array1, Array2, s};
use sindyna_core::Rng;

use super::goal::Goal;
use super::plant::Plant;
use super::small::without_negative;

/// −Σ `reward`·r + `effort`·Σ ‖u‖² (in half ranges) + `end`·(x_T − x*)ᵀP(x_T − x*).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Objective<'a> {
    pub(crate) reward: f64,
    /// Step of differences of the reward, in scales.
    pub(crate) width: f64,
    pub(crate) effort: f64,
    pub(crate) end: Option<(&'a Goal, f64)>,
}

/// x⁺ ≈ A x + B u and the cost of a step to second order in y = (x; u).
pub(crate) struct Expansion {
    /// Both row by row in memory.
    pub(crate) a: Array2<f64>,
    pub(crate) b: Array2<f64>,
    /// Gradient (n + k) and Hessian (n + k, n + k) of what the reward costs, if it counts.
    pub(crate) reward: Option<(Array1<f64>, Array2<f64>)>,
}

impl Objective<'_> {
    /// Writes the state after x under u; its reward, 0 where this objective has no use for it; `None` where the model diverges or the reward is no finite number.
    pub(crate) fn step(&self, plant: &Plant, x: &[f64], u: &[f64], (rng, next): (&mut Rng, &mut [f64])) -> Option<f64> {
        plant.dynamics().step(x, u, rng, next).ok()?;
        self.paid(plant, x, u, next)
    }

    /// The reward of a step from x to `next`; 0 where this objective has no use for it, `None` where it is no finite number.
    pub(crate) fn paid(&self, plant: &Plant, x: &[f64], u: &[f64], next: &[f64]) -> Option<f64> {
        let reward = if self.reward > 0.0 { plant.reward(x, u, next) } else { 0.0 };
        reward.is_finite().then_some(reward)
    }

    pub(crate) fn of_step(&self, plant: &Plant, reward: f64, u: &[f64]) -> f64 {
        let effort: f64 = u.iter().enumerate().map(|(j, u)| (u / plant.half(j)).powi(2)).sum();
        self.effort * effort - self.reward * reward
    }

    pub(crate) fn of_end(&self, x: &[f64]) -> f64 {
        self.end.map_or(0.0, |(goal, weight)| weight * goal.distance(x))
    }

    /// Gradient (n) and Hessian (n, n), row by row, at the end.
    pub(crate) fn expand_end(&self, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        match self.end {
            None => (vec![0.0; x.len()], vec![0.0; x.len() * x.len()]),
            Some((goal, weight)) => {
                let slope = goal.value.dot(&goal.error(x)) * (2.0 * weight);
                (slope.to_vec(), goal.value.iter().map(|v| v * 2.0 * weight).collect())
            }
        }
    }

    /// Slope and curvature of the effort of control `j` at `u`.
    pub(crate) fn of_effort(&self, plant: &Plant, j: usize, u: f64) -> (f64, f64) {
        let weight = 2.0 * self.effort / (plant.half(j) * plant.half(j));
        (weight * u, weight)
    }

    /// The step from x under u to `next`.
    pub(crate) fn expand(
        &self,
        plant: &Plant,
        (x, u, next): (&[f64], &[f64], &[f64]),
        rng: &mut Rng,
    ) -> Option<Expansion> {
        let (n, k) = plant.dims();
        let (a, b) = plant.linearize(x, u, rng).ok()?;
        let (a, b) = (a.as_standard_layout().into_owned(), b.as_standard_layout().into_owned());
        let reward = (self.reward > 0.0).then(|| {
            let (g, h) = of_reward(plant, (x, u, next), self.width);
            // z = (x; u; x⁺), of which the last is A x + B u.
            let mut through = Array2::zeros((2 * n + k, n + k));
            (0..n + k).for_each(|i| through[[i, i]] = 1.0);
            through.slice_mut(s![n + k.., ..n]).assign(&a);
            through.slice_mut(s![n + k.., n..]).assign(&b);
            let bend = without_negative(&(through.t().dot(&h).dot(&through) * -self.reward));
            (through.t().dot(&g) * -self.reward, bend)
        });
        Some(Expansion { a, b, reward })
    }
}

/// Gradient and Hessian of r over z = (x; u; x⁺), by central differences. Values of z on which r does not depend cost two evaluations each.
fn of_reward(plant: &Plant, (x, u, next): (&[f64], &[f64], &[f64]), width: f64) -> (Array1<f64>, Array2<f64>) {
    let (n, k) = plant.dims();
    let size = 2 * n + k;
    let mut z = [x, u, next].concat();
    let reward = |z: &[f64]| plant.reward(&z[..n], &z[n..n + k], &z[n + k..]);
    let step = |i: usize| {
        width
            * match i {
                i if i < n => plant.scales[i],
                i if i < n + k => plant.half(i - n),
                i => plant.scales[i - n - k],
            }
    };
    let middle = reward(&z);
    let (mut g, mut h) = (Array1::zeros(size), Array2::zeros((size, size)));
    let mut active = Vec::new();
    for i in 0..size {
        let (at, d) = (z[i], step(i));
        z[i] = at + d;
        let above = reward(&z);
        z[i] = at - d;
        let below = reward(&z);
        z[i] = at;
        if above - middle == 0.0 && below - middle == 0.0 {
            continue;
        }
        g[i] = (above - below) / (2.0 * d);
        h[[i, i]] = (above - 2.0 * middle + below) / (d * d);
        active.push((i, at, d));
    }
    for (p, &(i, zi, di)) in active.iter().enumerate() {
        for &(j, zj, dj) in &active[..p] {
            let mut at = |si: f64, sj: f64| {
                (z[i], z[j]) = (zi + si * di, zj + sj * dj);
                let value = reward(&z);
                (z[i], z[j]) = (zi, zj);
                value
            };
            let mixed = (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * di * dj);
            (h[[i, j]], h[[j, i]]) = (mixed, mixed);
        }
    }
    (g, h)
}
