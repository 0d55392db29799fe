//! What was found, as values and as lines of text.

use std::fmt;
use std::path::PathBuf;

use sindyna_core::number::{plural, significant};

/// When something happened.
#[derive(Debug, Clone, PartialEq)]
pub struct At {
    /// The file, where there are several.
    pub file: Option<PathBuf>,
    /// Since its first sample \[s\].
    pub seconds: f64,
}

/// Something about the samples that a user should know before believing what is found in them.
///
/// [`Display`](fmt::Display) says it in a line.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Finding {
    /// Steps so long that trajectories end there.
    Gaps {
        /// The longest \[s\].
        longest: f64,
        /// Where they begin.
        at: Vec<At>,
    },
    /// An input that is the same in every row.
    Constant {
        /// The input.
        signal: String,
    },
    /// A state that runs into a limit and stays there.
    Clips {
        /// The signal.
        signal: String,
        /// The limit.
        limit: f64,
        /// Share of the samples that are there.
        share: f64,
        /// When it arrived.
        at: Vec<At>,
    },
    /// An input that the states tell, as one that a controller computes of them.
    Feedback {
        /// The input.
        signal: String,
        /// Share of its variance that states, and sines and cosines of angles, tell linearly.
        share: f64,
    },
    /// A narrow oscillation that is faster than the motion.
    Oscillates {
        /// The signal.
        signal: String,
        /// How often \[Hz\].
        frequency: f64,
        /// How far, as an RMS.
        rms: f64,
        /// Share of how it changes from sample to sample.
        share: f64,
    },
    /// Single samples that both neighbours contradict.
    Spikes {
        /// The signal.
        signal: String,
        /// How far the farthest is off.
        largest: f64,
        /// When.
        at: Vec<At>,
    },
    /// A state that takes few values, which are not evenly spaced.
    FewValues {
        /// The state.
        signal: String,
        /// How many.
        values: usize,
    },
    /// A state that moves by less than its resolution from sample to sample.
    Coarse {
        /// The state.
        signal: String,
        /// Its resolution.
        step: f64,
    },
}

impl Finding {
    /// Whether it is about the samples of `state` alone.
    #[must_use]
    pub fn is_of(&self, state: &str) -> bool {
        match self {
            Self::Clips { signal, .. }
            | Self::Oscillates { signal, .. }
            | Self::Spikes { signal, .. }
            | Self::FewValues { signal, .. }
            | Self::Coarse { signal, .. } => signal == state,
            Self::Gaps { .. } | Self::Constant { .. } | Self::Feedback { .. } => false,
        }
    }
}

/// Times that are told.
const TOLD: usize = 5;

/// `at 1.2 s, 3.4 s (b.csv), …`
fn times(at: &[At]) -> String {
    let time = |at: &At| {
        let file = at.file.as_ref().map_or_else(String::new, |file| format!(" ({})", file.display()));
        format!("{} s{file}", significant(at.seconds, 4))
    };
    let told: Vec<String> = at.iter().take(TOLD).map(time).collect();
    let more = if at.len() > TOLD { ", …" } else { "" };
    format!("at {}{more}", told.join(", "))
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: &f64| match share {
            share if *share > 0.99 => "more than 99".to_owned(),
            share => significant(100.0 * share, 2),
        };
        match self {
            Self::Gaps { longest, at } => {
                write!(
                    f,
                    "{} in time, the longest {} s: {}",
                    plural(at.len(), "gap"),
                    significant(*longest, 3),
                    times(at)
                )
            }
            Self::Constant { signal } => {
                write!(f, "{signal} is constant: its effect cannot be distinguished from a constant term")
            }
            Self::Clips { signal, limit, share, at } => write!(
                f,
                "{signal} saturates at {} in {} % of the samples, {}: its equation does not hold there",
                significant(*limit, 4),
                percent(share),
                times(at)
            ),
            Self::Feedback { signal, share } => write!(
                f,
                "{signal} is a function of the states for {} % of its variance, as under feedback, so that its effect is hard to separate from \
                 theirs; a log in which it varies independently allows that",
                percent(share)
            ),
            Self::Oscillates { signal, frequency, rms, share } => write!(
                f,
                "{signal} oscillates at {} Hz ({} RMS), faster than its other motion; this is {} % of its change from sample to sample",
                significant(*frequency, 3),
                significant(*rms, 2),
                percent(share)
            ),
            Self::Spikes { signal, largest, at } => write!(
                f,
                "{signal} has {} that {} from both neighbours, by up to {}: {}",
                plural(at.len(), "sample"),
                if at.len() == 1 { "deviates" } else { "deviate" },
                significant(*largest, 3),
                times(at)
            ),
            Self::FewValues { signal, values } => {
                write!(f, "{signal} takes only {values} values, unevenly spaced: it was rounded by an unknown amount")
            }
            Self::Coarse { signal, step } => write!(
                f,
                "{signal} changes by less than its resolution, {}, between most samples: its rate can only be estimated over longer intervals",
                significant(*step, 3)
            ),
        }
    }
}
