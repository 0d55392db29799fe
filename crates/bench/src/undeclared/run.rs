//! One log given to the method, and what came back.

use std::time::Duration;

use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};
use sindyna_core::Seed;

use super::generate::generate;
use super::judge::{Judge, Verdict};
use super::system::System;
use crate::child::{self, Ended, Outcome};
use crate::method;

/// Which log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Name of the system.
    pub system: String,
    /// Noise, as part of each channel's standard deviation over the log.
    pub noise: f64,
    /// Samples in the log.
    pub samples: usize,
    /// Seed of starts, inputs and noise.
    pub seed: u64,
    /// Whether rates were not measured.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub positions: bool,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Of which log.
    #[serde(flatten)]
    pub case: Case,
    /// How it ended.
    pub outcome: Outcome,
    /// Whether the method claims that nothing is left to explain.
    pub adequate: bool,
    /// Processor time of the identification, all threads together; none where nothing came back.
    pub seconds: Option<f64>,
    /// What the equations are worth.
    #[serde(flatten)]
    pub verdict: Verdict,
}

impl Run {
    /// Identifies the log in this process.
    ///
    /// # Errors
    /// If the system or the equations found cannot be read.
    pub fn of(system: &System, case: Case) -> anyhow::Result<Self> {
        let log = generate(system, case.samples, case.noise, Seed::new(case.seed))?;
        let log = if case.positions { log.without_rates() } else { log };
        let judge = Judge::new(system)?;
        let start = ProcessTime::now();
        let found = method::identify(&log);
        let seconds = start.elapsed().as_secs_f64();
        Ok(match found {
            Err(_) => Self::without(case, Outcome::Refused),
            Ok(found) => Self {
                case,
                outcome: Outcome::Identified,
                adequate: found.adequate,
                seconds: Some(seconds),
                verdict: judge.judge(&found.equations)?,
            },
        })
    }

    /// The same in a process of its own, this program with `--alone CASE`, for at most `limit`.
    ///
    /// # Errors
    /// If no process can be started, or if what it says is no run.
    pub fn watched(case: &Case, limit: Duration) -> anyhow::Result<Self> {
        Ok(match child::run(&["--alone".to_owned(), serde_json::to_string(case)?], limit)? {
            Ended::Done(text) => serde_json::from_str(&text)?,
            Ended::TimedOut => Self::without(case.clone(), Outcome::TimedOut),
            Ended::Crashed(_) => Self::without(case.clone(), Outcome::Crashed),
        })
    }

    /// A run without equations.
    fn without(case: Case, outcome: Outcome) -> Self {
        let verdict = Verdict { right: false, coefficient_error: None, deviation: None, equations: Vec::new() };
        Self { case, outcome, adequate: false, seconds: None, verdict }
    }
}
