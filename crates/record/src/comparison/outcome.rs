//! What one run of one method comes to: `runs/TASK/METHOD/seed-N.json`.

use serde::{Deserialize, Serialize};

use crate::format;

/// A run, as its file holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outcome {
    /// Version of the format; not written while it is 1.
    #[serde(default = "format::first", skip_serializing_if = "format::is_first")]
    pub format: u32,
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Real steps at the first check that reached the task's threshold; none if none did.
    pub solved_after: Option<usize>,
    /// Real steps and resets, all of them but for checks and the last evaluation.
    pub real_steps: usize,
    /// Episodes on the system.
    pub real_episodes: usize,
    /// Gradient updates.
    pub updates: u64,
    /// Simulated steps in the model.
    pub model_steps: u64,
    /// Numbers in the model: terms with a coefficient, or weights.
    pub model_parameters: Option<usize>,
    /// The equations found, where there are such.
    pub equations: Vec<String>,
    /// The model with every digit ([`sindyna_sindy::Model::to_json`]), where it has equations: what can be drawn of it and
    /// measured on it follows from this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<serde_json::Value>,
    /// Checks on the way.
    pub curve: Vec<Point>,
    /// Returns of the policy at the end, from a hundred start states that are the same for every method.
    pub returns: Vec<f64>,
    /// Why the run came to nothing.
    pub failure: Option<String>,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Real steps so far.
    pub real_steps: usize,
    /// Gradient updates.
    pub updates: u64,
    /// Return of each episode.
    pub returns: Vec<f64>,
}

impl Outcome {
    /// A run of nothing yet.
    #[must_use]
    pub fn new(task: &str, method: &str, seed: u64) -> Self {
        Self {
            format: format::CURRENT,
            task: task.into(),
            method: method.into(),
            seed,
            solved_after: None,
            real_steps: 0,
            real_episodes: 0,
            updates: 0,
            model_steps: 0,
            model_parameters: None,
            equations: Vec::new(),
            model: None,
            curve: Vec::new(),
            returns: Vec::new(),
            failure: None,
        }
    }

    /// Mean return at the end.
    #[must_use]
    pub fn mean_return(&self) -> Option<f64> {
        mean(&self.returns)
    }
}

/// The mean of `values`; `None` for no values.
#[must_use]
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
