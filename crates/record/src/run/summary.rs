//! The files of a run record that programs read: `summary.json` and `timing.json`.

use serde::{Deserialize, Serialize};

use crate::identification::{Offset, Stepping, Summand};
use crate::{RecordError, format};

/// Part of the returns, in size, by which a policy that can be improved is far from the best.
const LARGE: f64 = 0.1;

/// `summary.json`: what a run did and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Version of the format; not written while it is 1.
    #[serde(default = "format::first", skip_serializing_if = "format::is_first")]
    pub format: u32,
    /// Name of the task.
    pub task: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Every step on the system before evaluation, over all resets.
    pub real_steps: usize,
    /// Resets of the system before evaluation.
    pub real_episodes: usize,
    /// Whether the evaluation reached the threshold; `null` where there was no evaluation or no threshold.
    pub solved: Option<bool>,
    /// Mean return from which the task counts as solved.
    pub threshold: Option<f64>,
    /// `null` for a run stopped before its evaluation.
    pub evaluation: Option<Evaluation>,
    /// `null` where no model was made.
    pub identification: Option<Identification>,
    /// How the policy came about.
    pub training: Training,
    /// Whether there was no system, only a recorded log.
    #[serde(default)]
    pub from_log: bool,
    /// Time after which the inputs begin to act \[s\], where they act late; the policy then acts on the state predicted for that time, and returns in the model are without the delay, but for [`Training::late`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_delay_seconds: Option<f64>,
    /// Time constant of the lag through which the inputs act \[s\], where they do; what actuators deliver is then part of the state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_lag: Option<f64>,
    /// Stopped by Ctrl-C before it was done.
    pub interrupted: bool,
}

impl Summary {
    /// Reads a `summary.json`.
    ///
    /// # Errors
    /// [`RecordError::Json`] for any other text, [`RecordError::Format`] for a version that is not known.
    pub fn from_json(text: &str) -> Result<Self, RecordError> {
        let summary: Self = serde_json::from_str(text)?;
        format::check("summary.json", summary.format)?;
        Ok(summary)
    }

    /// The files beside it in the record of a run that came to its end.
    #[must_use]
    pub fn files(&self) -> Vec<&'static str> {
        let model = self.identification.as_ref().map(|_| "model.json");
        // A planner is made of the model.
        let learned = self.training.model_return.filter(|_| self.training.planners.is_empty());
        let policy = learned.map(|_| "policy.safetensors");
        ["rollout.csv", "events.jsonl", "timing.json"].into_iter().chain(model).chain(policy).collect()
    }
}

/// Returns of the deterministic policy on the system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Number of episodes.
    pub episodes: usize,
    /// Mean of the returns.
    pub mean_return: f64,
    /// Population standard deviation of the returns.
    pub std_return: f64,
    /// Return of each episode.
    pub returns: Vec<f64>,
}

impl Evaluation {
    /// Mean and (population) standard deviation of `returns`.
    #[must_use]
    pub fn of(returns: Vec<f64>) -> Self {
        let n = returns.len().max(1) as f64;
        let mean_return = returns.iter().sum::<f64>() / n;
        let variance = returns.iter().map(|r| (r - mean_return).powi(2)).sum::<f64>() / n;
        Self { episodes: returns.len(), mean_return, std_return: variance.sqrt(), returns }
    }
}

/// What was identified, and from how much.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// Name of the method: for an identification, of the sparse regression.
    pub method: String,
    /// Candidate terms.
    pub library: String,
    /// Candidate features F.
    pub features: usize,
    /// States × features (the paper's P).
    pub parameters: usize,
    /// Fitted numbers, angle offsets among them; declared rates are not fitted.
    pub nonzero: usize,
    /// Non-zero coefficients, kinematic rows included (the paper's P′).
    pub nonzero_paper: usize,
    /// Transitions the model was fitted to.
    pub rows: usize,
    /// Transitions kept out because a channel sat at its declared bound.
    pub rows_at_limit: usize,
    /// Transitions kept out because they do not follow the equations of all the others.
    pub rows_astray: usize,
    /// The equations as text, one per state.
    pub equations: Vec<String>,
    /// How the equations are stepped.
    pub stepping: Stepping,
    /// What is added to an angle before the terms are computed, where that is not zero.
    pub offsets: Vec<Offset>,
    /// Whether the residual of every equation is no more than the sensors explain; `null` where that is not known.
    pub explained: Option<bool>,
    /// Per equation: coefficients with standard errors.
    pub coefficients: Vec<Vec<Summand>>,
}

/// How the policy came about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Training {
    /// Learning algorithm.
    pub algorithm: String,
    /// Instructions the updates ran with: the same seed gives the same bytes with the same ones.
    pub isa: String,
    /// Gradient updates.
    pub updates: u64,
    /// Simulated steps in the model.
    pub model_steps: u64,
    /// Simulated rollouts in the model.
    pub model_rollouts: u64,
    /// Imagined rollouts cut because the model diverged.
    pub diverged: u64,
    /// Imagined rollouts ended because they left the trusted region.
    pub left_region: u64,
    /// Mean return of the kept policy in the model.
    pub model_return: Option<f64>,
    /// Whether training ended because trials in the model gained no more; how far the policy is from the best there is, it does not tell.
    pub converged: bool,
    /// What the policy was expected to earn on the system, before it was evaluated there.
    #[serde(default)]
    pub prediction: Option<Prediction>,
    /// Its real episode before that, where the model was not believed without one.
    #[serde(default)]
    pub confirmation: Option<Confirmation>,
    /// Where the policy goes in the model, and where the data were; told where there was no evaluation because there is no system.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<Coverage>,
    /// Returns in the model with inputs that act as late as they do, on the states that are predicted for that; where they act late.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub late: Option<Evaluation>,
    /// What to collect next; told where the interval of the prediction is wide, and the models that the data allow disagree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub collect: Option<Collect>,
    /// What each planner that was tried earned in the model; none where a policy was trained.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub planners: Vec<PlannerReturn>,
    /// What the policy earns in the model beside a plan that improves what it does; none where it is such a plan already.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub improvable: Option<Improvable>,
    /// Why no model could be fitted to all real steps, if so: the equations are those of fewer, in doubt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refit_failure: Option<String>,
    /// Why training stopped short, if it did.
    pub failure: Option<String>,
}

/// What a planner earned in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannerReturn {
    /// Its name: `lqr`, `ilqr` or `mppi`.
    pub name: String,
    /// Mean return in the model.
    pub model_return: f64,
}

/// Mean returns of the policy and of better plans, in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Improvable {
    /// Episodes in the model.
    pub episodes: usize,
    /// With the actions of the policy.
    pub policy: f64,
    /// With these actions improved by differential dynamic programming: a lower bound of the best.
    pub improved: f64,
}

impl Improvable {
    /// Whether the policy is far from the best.
    #[must_use]
    pub fn is_large(&self) -> bool {
        self.improved - self.policy > LARGE * self.improved.abs().max(self.policy.abs())
    }
}

/// The mean return of the evaluation's episodes, as predicted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// The value expected.
    pub mean: f64,
    /// Probability that the interval holds it.
    pub level: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// Where a policy goes in its model beside where the data were.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Episodes in the model.
    pub episodes: usize,
    /// How many of them a condition of the task ended before their last step.
    #[serde(default)]
    pub terminated: usize,
    /// Share of their steps with a state or a control beyond the range of the data; angles aside.
    pub share_outside: f64,
    /// Each state.
    pub states: Vec<ChannelRange>,
    /// Each control.
    #[serde(default)]
    pub controls: Vec<ChannelRange>,
}

/// Lowest and highest value of a state or control.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelRange {
    /// The state or control.
    #[serde(alias = "state")]
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// In the data.
    pub data: (f64, f64),
    /// In episodes of the policy in the model.
    pub policy: (f64, f64),
    /// How far beyond the data a value is yet like them: for controls the mean distance of neighbouring values.
    #[serde(default)]
    pub margin: f64,
}

impl ChannelRange {
    /// Whether the policy goes beyond the data.
    #[must_use]
    pub fn is_beyond(&self) -> bool {
        self.policy.0 < self.data.0 - self.margin || self.policy.1 > self.data.1 + self.margin
    }
}

/// Data that would tell more: where the policy goes and the models that the data allow disagree most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Collect {
    /// Share of the models' disagreement along the policy's episodes that is there.
    pub share: f64,
    /// Each state.
    pub states: Vec<Span>,
    /// Each control.
    pub controls: Vec<Span>,
}

/// From where to where a channel goes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// The state or control.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A confirmation episode: a real episode, with the return that was predicted for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    /// Return of the episode.
    pub real: f64,
    /// Return that the models predicted for it.
    #[serde(alias = "promised")]
    pub predicted: f64,
    /// Standard deviation of the returns that the models drawn predict.
    pub spread: f64,
    /// The same with the same noise in all models.
    pub disagreement: f64,
    /// Whether the real return agrees with the predicted one.
    #[serde(alias = "kept")]
    pub agrees: bool,
}

/// `timing.json`: the only file of a record that differs between two runs with one seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Version of the format; not written while it is 1.
    #[serde(default = "format::first", skip_serializing_if = "format::is_first")]
    pub format: u32,
    /// Seconds spent on identification, over all fits.
    pub identify_seconds: f64,
    /// Seconds of everything else before the evaluation.
    pub train_seconds: f64,
    /// Seconds of the evaluation.
    pub evaluate_seconds: f64,
    /// Seconds of one action of the policy, the median over the evaluation; over episodes in the model where there is no system.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub act_seconds: Option<f64>,
    /// Seconds of the slowest of these actions, where the policy plans: that of the first step of an episode, mostly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slowest_act_seconds: Option<f64>,
    /// Seconds in all.
    pub wall_seconds: f64,
    /// Processor and cores.
    pub machine: String,
    /// Threads that worked on it.
    pub threads: usize,
}
