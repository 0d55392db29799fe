//! The files of a run record that programs read.

use serde::{Deserialize, Serialize};

use crate::identification::{Offset, Stepping, Summand};

/// `summary.json`: what a run did and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Summary {
    pub(crate) task: String,
    pub(crate) seed: u64,
    /// Every step on the real system before evaluation, over all resets.
    pub(crate) real_steps: usize,
    /// Resets of the real system before evaluation.
    pub(crate) real_episodes: usize,
    /// Whether the evaluation reached the threshold; `null` where there was no evaluation or no threshold.
    pub(crate) solved: Option<bool>,
    pub(crate) threshold: Option<f64>,
    /// `null` for a run stopped before its evaluation.
    pub(crate) evaluation: Option<Evaluation>,
    /// `null` where no model was made.
    pub(crate) identification: Option<Identification>,
    pub(crate) training: Training,
    /// Stopped by Ctrl-C before it was done.
    pub(crate) interrupted: bool,
}

impl Summary {
    /// The files beside it in the record of a run that came to its end.
    pub(crate) fn files(&self) -> Vec<&'static str> {
        let model = self.identification.as_ref().map(|_| "model.json");
        let policy = self.evaluation.as_ref().map(|_| "policy.safetensors");
        ["rollout.csv", "events.jsonl", "timing.json"].into_iter().chain(model).chain(policy).collect()
    }
}

/// Returns of the deterministic policy on the real system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Evaluation {
    pub(crate) episodes: usize,
    pub(crate) mean_return: f64,
    pub(crate) std_return: f64,
    pub(crate) returns: Vec<f64>,
}

impl Evaluation {
    /// Mean and (population) standard deviation of `returns`.
    pub(crate) fn of(returns: Vec<f64>) -> Self {
        let n = returns.len().max(1) as f64;
        let mean_return = returns.iter().sum::<f64>() / n;
        let variance = returns.iter().map(|r| (r - mean_return).powi(2)).sum::<f64>() / n;
        Self { episodes: returns.len(), mean_return, std_return: variance.sqrt(), returns }
    }
}

/// What was identified, and from how much.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Identification {
    pub(crate) method: String,
    pub(crate) library: String,
    /// Candidate features F.
    pub(crate) features: usize,
    /// States × features (the paper's P).
    pub(crate) parameters: usize,
    /// Fitted numbers, angle offsets among them; declared rates are not fitted.
    pub(crate) nonzero: usize,
    /// Non-zero coefficients, kinematic rows included (the paper's P′).
    pub(crate) nonzero_paper: usize,
    /// Transitions the model was fitted to.
    pub(crate) rows: usize,
    /// Transitions kept out because a channel sat at its declared bound.
    pub(crate) rows_at_limit: usize,
    /// Transitions kept out because they do not follow the equations of all the others.
    pub(crate) rows_astray: usize,
    pub(crate) equations: Vec<String>,
    pub(crate) stepping: Stepping,
    /// What is added to an angle before the terms are computed, where that is not zero.
    pub(crate) offsets: Vec<Offset>,
    /// Whether the residual of every equation is no more than the sensors explain; `null` where that is not known.
    pub(crate) explained: Option<bool>,
    /// Per equation: coefficients with standard errors.
    pub(crate) coefficients: Vec<Vec<Summand>>,
}

/// How the policy came about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Training {
    pub(crate) algorithm: String,
    /// Instructions the updates ran with: the same seed gives the same bytes with the same ones.
    pub(crate) isa: String,
    pub(crate) updates: u64,
    pub(crate) model_steps: u64,
    pub(crate) model_rollouts: u64,
    /// Imagined rollouts cut because the model diverged.
    pub(crate) diverged: u64,
    /// Imagined rollouts ended because they left the trusted region.
    pub(crate) left_region: u64,
    /// Mean return of the kept policy in the model.
    pub(crate) model_return: Option<f64>,
    /// Whether the stop rule called it optimal in the model.
    pub(crate) optimal_in_model: bool,
    /// What the policy was expected to earn on the real system, before it was evaluated there.
    #[serde(default)]
    pub(crate) prediction: Option<Prediction>,
    /// Its real episode before that, where the model was not believed without one.
    #[serde(default)]
    pub(crate) confirmation: Option<Confirmation>,
    /// Why training stopped short, if it did.
    pub(crate) failure: Option<String>,
}

/// The mean return of the evaluation's episodes, as predicted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Prediction {
    pub(crate) mean: f64,
    /// Probability that the interval holds it.
    pub(crate) level: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// A real episode beside what was promised for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Confirmation {
    pub(crate) real: f64,
    pub(crate) promised: f64,
    /// Standard deviation of what the models drawn promise.
    pub(crate) spread: f64,
    /// The same with the same noise in all of them.
    pub(crate) disagreement: f64,
    pub(crate) kept: bool,
}

/// `timing.json`: the only file of a record that differs between two runs with one seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Timing {
    pub(crate) identify_seconds: f64,
    pub(crate) train_seconds: f64,
    pub(crate) evaluate_seconds: f64,
    pub(crate) wall_seconds: f64,
    pub(crate) machine: String,
    pub(crate) threads: usize,
}
