//! Model predictive path integral control.

use ndarray::Array2;
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;
use sindyna_core::{Rng, Seed};

use super::course::{Course, charge};
use super::goal::Goal;
use super::plant::{Plant, unused};

/// Sequences of controls that are tried at every step.
const SAMPLES: usize = 96;

/// Standard deviation of their differences from the plan, in half ranges, and how much of it goes on from step to step.
const SPREAD: f64 = 0.5;
const GOES_ON: f64 = 0.9;

/// Standard deviations of the returns by which one that is worse counts e times less.
const TEMPERATURE: f64 = 0.2;

/// A plan that is moved on and improved by random changes of it, weighed by what they earn.
///
/// # Deviations
/// 1. Noise goes on from step to step (an autoregressive process), so that it moves what is heavy.
/// 2. The temperature is a part of the deviation of the returns, so that it needs no unit. There is no charge for controls but that of the task.
///
/// # References
/// Williams, Aldrich, Theodorou (2017), J. Guidance, Control, and Dynamics 40(2), "Model predictive path integral control", algorithm 2,
/// doi:10.2514/1.G001921.
pub(crate) struct Sampled {
    /// Controls (H, k).
    plan: Array2<f64>,
    rng: Rng,
}

impl Sampled {
    pub(crate) fn new(plant: &Plant, horizon: usize) -> Self {
        let middle = plant.middle();
        let plan = Array2::from_shape_fn((horizon.max(1), middle.len()), |(_, j)| middle[j]);
        Self { plan, rng: Seed::new(0).stream("path integral", 0) }
    }

    /// The control in x, with so many steps to go; the plan is moved on by a step.
    pub(crate) fn act(&mut self, plant: &Plant, goals: &[Goal], x: &[f64], left: usize) -> Vec<f64> {
        let (horizon, k) = self.plan.dim();
        let steps = horizon.min(left.max(1));
        let mut tried: Vec<Array2<f64>> = (0..SAMPLES).map(|sample| self.changed(plant, sample)).collect();
        // What the regulator of each goal would do.
        for goal in 0..goals.len().min(2) {
            let course = Course { plan: None, made: 0, goal: Some(goal) };
            let (_, controls) = course.earns(plant, goals, x, steps);
            let last = controls.last().cloned().unwrap_or_else(|| plant.middle());
            tried.push(Array2::from_shape_fn((horizon, k), |(t, j)| controls.get(t).unwrap_or(&last)[j]));
        }
        let returns: Vec<f64> =
            tried.par_iter().map(|controls| earned(plant, goals, x, controls, (steps, left))).collect();
        let finite: Vec<f64> = returns.iter().copied().filter(|r| r.is_finite()).collect();
        let most = finite.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean = finite.iter().sum::<f64>() / finite.len().max(1) as f64;
        let deviation = (finite.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / finite.len().max(1) as f64).sqrt();
        let temperature = (TEMPERATURE * deviation).max(1e-12);
        let weight = |r: &f64| if r.is_finite() { ((r - most) / temperature).exp() } else { 0.0 };
        let weights: Vec<f64> = returns.iter().map(weight).collect();
        let total: f64 = weights.iter().sum();
        if total > 0.0 {
            let mut plan = Array2::zeros((horizon, k));
            for (controls, weight) in tried.iter().zip(&weights) {
                plan.scaled_add(weight / total, controls);
            }
            // A mean of several good ways may be none itself.
            let best = (0..tried.len()).max_by(|&i, &j| returns[i].total_cmp(&returns[j])).unwrap_or(0);
            let together = earned(plant, goals, x, &plan, (steps, left));
            self.plan = if together >= returns[best] { plan } else { tried.swap_remove(best) };
        }
        let now = self.plan.row(0).to_vec();
        for t in 0..horizon {
            for j in 0..k {
                self.plan[[t, j]] = self.plan[[(t + 1).min(horizon - 1), j]];
            }
        }
        now
    }

    /// The plan with noise; as it is for number 0.
    fn changed(&mut self, plant: &Plant, sample: usize) -> Array2<f64> {
        let mut controls = self.plan.clone();
        if sample == 0 {
            return controls;
        }
        // Some look nearby, some far.
        let spread = SPREAD * [1.0, 0.3, 0.1][sample % 3];
        for (j, mut column) in controls.columns_mut().into_iter().enumerate() {
            let mut noise = 0.0;
            for (t, u) in column.iter_mut().enumerate() {
                let normal: f64 = StandardNormal.sample(&mut self.rng);
                let fresh = if t == 0 { 1.0 } else { (1.0 - GOES_ON * GOES_ON).sqrt() };
                noise = GOES_ON * noise + fresh * normal;
                *u = (*u + spread * plant.half(j) * noise).clamp(plant.low[j], plant.high[j]);
            }
        }
        controls
    }
}

/// Return of `controls` from x, and, where the horizon ends before the episode, what is lost on the way from there to the best goal: about a step's pay for each
/// unit of distance.
fn earned(plant: &Plant, goals: &[Goal], x: &[f64], controls: &Array2<f64>, (steps, left): (usize, usize)) -> f64 {
    let (mut rng, mut earned) = (unused(), 0.0);
    let (mut x, mut next) = (x.to_vec(), vec![0.0; x.len()]);
    let mut action = vec![0.0; plant.spec().action_space.action_dim()];
    let (mut last, charge) = (0.0, charge(plant, goals));
    for t in 0..steps {
        let mut u = controls.row(t).to_vec();
        plant.settle(&mut u, &mut action);
        let Some(stepped) = plant.step(&x, &u, &mut rng, &mut next) else { return f64::NEG_INFINITY };
        earned += stepped.reward - charge * plant.beyond(&next).map(|(_, off)| off * off).sum::<f64>();
        last = stepped.reward;
        std::mem::swap(&mut x, &mut next);
        if stepped.ended {
            return earned;
        }
    }
    let after = left.saturating_sub(steps) as f64;
    let lost = goals.first().map_or(0.0, |goal| (goal.pay - last).abs().max(1e-3) * goal.distance(&x).min(after));
    earned - lost
}
