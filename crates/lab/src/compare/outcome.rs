//! What one run of one method comes to.

use serde::{Deserialize, Serialize};

/// A run, as its file holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Outcome {
    pub(crate) task: String,
    pub(crate) method: String,
    pub(crate) seed: u64,
    /// Real steps at the first check that reached the task's threshold; none if none did.
    pub(crate) solved_after: Option<usize>,
    /// Real steps and resets, all of them but for checks and the last evaluation.
    pub(crate) real_steps: usize,
    pub(crate) real_episodes: usize,
    pub(crate) updates: u64,
    pub(crate) model_steps: u64,
    /// Numbers in the model: terms with a coefficient, or weights.
    pub(crate) model_parameters: Option<usize>,
    /// The equations found, where there are such.
    pub(crate) equations: Vec<String>,
    /// The model with every digit ([`sindyna_sindy::Model::to_json`]), where it has equations: what can be drawn of it and
    /// measured on it follows from this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) model: Option<serde_json::Value>,
    /// Checks on the way.
    pub(crate) curve: Vec<Point>,
    /// Returns of the policy at the end, from a hundred start states that are the same for every method.
    pub(crate) returns: Vec<f64>,
    /// Why the run came to nothing.
    pub(crate) failure: Option<String>,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    pub(crate) real_steps: usize,
    pub(crate) updates: u64,
    pub(crate) returns: Vec<f64>,
}

impl Outcome {
    /// A run of nothing yet.
    pub(crate) fn new(task: &str, method: &str, seed: u64) -> Self {
        Self {
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
    pub(crate) fn mean_return(&self) -> Option<f64> {
        (!self.returns.is_empty()).then(|| mean(&self.returns))
    }
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
