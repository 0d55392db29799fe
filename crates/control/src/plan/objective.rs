//! What a plan is to make small, and its second-order expansion.

use ndarray::{Array1, Array2};
use sindyna_core::Rng;

use super::goal::Goal;
use super::plant::Plant;
use super::slopes::costs;

/// What controls cost on the way to a goal, beside its distance at the end, and what it costs to be beyond the bounds of a position, beside what steps are worth.
pub(super) const EFFORT: f64 = 1e-3;
pub(super) const BEYOND: f64 = 1e3;

/// −Σ `reward`·r + `effort`·Σ ‖u‖² (in half ranges) + Σ ‖x_t − `along`_t‖² + `beyond`·Σ ‖what x_t is beyond bounds‖² (in scales) + `end`·(x_T − x*)ᵀP(x_T − x*).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Objective<'a> {
    pub(crate) reward: f64,
    /// Step of differences of the reward, in scales.
    pub(crate) width: f64,
    pub(crate) effort: f64,
    pub(crate) beyond: f64,
    /// States (T + 1, n) that are to be followed; none: all alike.
    pub(crate) along: &'a [Vec<f64>],
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

impl<'a> Objective<'a> {
    /// The way to `end`, if there is one.
    pub(crate) fn way(end: Option<&'a Goal>) -> Self {
        Self { effort: EFFORT, beyond: BEYOND, end: end.map(|goal| (goal, 1.0)), ..Self::default() }
    }

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

    /// What step `t` costs, from x under u.
    pub(crate) fn of_step(&self, plant: &Plant, reward: f64, (t, x, u): (usize, &[f64], &[f64])) -> f64 {
        let effort: f64 = u.iter().enumerate().map(|(j, u)| (u / plant.half(j)).powi(2)).sum();
        self.effort * effort + self.of_place(plant, t, x) - self.reward * reward
    }

    /// What it costs to be in x at step `t`.
    fn of_place(&self, plant: &Plant, t: usize, x: &[f64]) -> f64 {
        let away: f64 = self.away(plant, t, x).map(|(off, scale)| (off / scale).powi(2)).sum();
        away + self.beyond * plant.beyond(x).map(|(_, off)| off * off).sum::<f64>()
    }

    /// How far x is from where step `t` is to begin, and the scales; nothing where that is all alike.
    fn away(&self, plant: &Plant, t: usize, x: &[f64]) -> impl Iterator<Item = (f64, f64)> {
        let along = self.along.get(t).into_iter().flatten();
        along.zip(x).zip(&plant.scales).map(|((along, x), scale)| (x - along, *scale))
    }

    /// Adds the slopes (n) and curvatures (n, n), row by row, of what it costs to be in x at step `t`.
    pub(crate) fn add_place(&self, plant: &Plant, (t, x): (usize, &[f64]), (qx, qxx): (&mut [f64], &mut [f64])) {
        let n = x.len();
        for (i, (off, scale)) in self.away(plant, t, x).enumerate() {
            qx[i] += 2.0 * off / (scale * scale);
            qxx[i * n + i] += 2.0 / (scale * scale);
        }
        for (i, off) in plant.beyond(x).filter(|_| self.beyond > 0.0) {
            let scale = plant.scales[i];
            qx[i] += 2.0 * self.beyond * off / scale;
            qxx[i * n + i] += 2.0 * self.beyond / (scale * scale);
        }
    }

    /// What it costs to end in x, after so many steps.
    pub(crate) fn of_end(&self, plant: &Plant, steps: usize, x: &[f64]) -> f64 {
        self.of_place(plant, steps, x) + self.end.map_or(0.0, |(goal, weight)| weight * goal.distance(x))
    }

    /// Gradient (n) and Hessian (n, n), row by row, at the end.
    pub(crate) fn expand_end(&self, plant: &Plant, steps: usize, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut slope, mut bend) = match self.end {
            None => (vec![0.0; x.len()], vec![0.0; x.len() * x.len()]),
            Some((goal, weight)) => {
                let slope = goal.value.dot(&goal.error(x)) * (2.0 * weight);
                (slope.to_vec(), goal.value.iter().map(|v| v * 2.0 * weight).collect())
            }
        };
        self.add_place(plant, (steps, x), (&mut slope, &mut bend));
        (slope, bend)
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
        let (a, b) = plant.linearize(x, u, rng).ok()?;
        let (a, b) = (a.as_standard_layout().into_owned(), b.as_standard_layout().into_owned());
        let reward = (self.reward > 0.0).then(|| {
            let (g, h) = costs(plant, (x, u, next), (&a, &b), self.width);
            (g * self.reward, h * self.reward)
        });
        Some(Expansion { a, b, reward })
    }
}
