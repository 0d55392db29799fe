//! Whether what a policy does can be improved.

use std::sync::Arc;

use rayon::prelude::*;
use sindyna_core::{Dynamics, Task};

use super::course::{Course, POLISH, WIDTHS};
use super::ilqr::Plan;
use super::objective::Objective;
use super::plant::Plant;

/// What a policy did from a start state: the state x0 (n), the controls (T, k), and the return.
#[derive(Debug, Clone)]
pub struct Rollout {
    /// State at the start (n).
    pub start: Vec<f64>,
    /// Controls (T, k).
    pub controls: Vec<Vec<f64>>,
    /// Sum of the rewards.
    pub earned: f64,
}

/// Mean return of `rollouts` in `dynamics` once their controls are improved by differential dynamic programming: a lower bound of what is possible. Where
/// an improved plan earns less, the rollout counts as it is.
///
/// # References
/// Tassa, Mansard, Todorov (2014), ICRA, "Control-limited differential dynamic programming".
pub fn improved(dynamics: Arc<dyn Dynamics>, task: Arc<dyn Task>, rollouts: &[Rollout]) -> f64 {
    let plant = Plant::new(dynamics, task);
    let steps = plant.task.max_steps();
    let of = |rollout: &Rollout| {
        let Rollout { start, controls, earned } = rollout;
        let plan = Plan::of(&plant, &Objective::default(), start, controls.clone());
        let course = Course { made: 0, goal: None, plan };
        let widths = (POLISH, steps, &WIDTHS[..1]);
        earned.max(course.polished(&plant, &[], start, steps, *earned, widths).1)
    };
    rollouts.par_iter().map(of).sum::<f64>() / rollouts.len().max(1) as f64
}
