//! Why there is no environment on MuJoCo.

use std::fmt;

/// A place where MuJoCo was looked for, and why it was not taken from there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attempt {
    /// File, folder or program.
    pub place: String,
    /// What was wrong with it.
    pub reason: String,
}

/// Why there is no environment on MuJoCo.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MujocoError {
    /// No library was found, or none that can be used.
    #[error(
        "no usable MuJoCo was found; install it with `pip install mujoco`, \
         or name its shared library in MUJOCO_LIB{}",
        Tried(tried)
    )]
    NotFound {
        /// Every place that was looked at, in order.
        tried: Vec<Attempt>,
    },
    /// MuJoCo refused the model.
    #[error("MuJoCo cannot use {origin}: {message}")]
    Model {
        /// The file, or a word for what was no file.
        origin: String,
        /// MuJoCo's own message.
        message: String,
    },
    /// The model and the task do not belong together.
    #[error("the model has {got} {what}, but task `{task}` declares {expected}")]
    Mismatch {
        /// Name of the task.
        task: String,
        /// What is counted.
        what: &'static str,
        /// Number the task declares.
        expected: usize,
        /// Number the model has.
        got: usize,
    },
    /// Model and task disagree about time.
    #[error("{frame_skip} steps of {timestep} s are not the control interval of {dt} s that task `{task}` declares")]
    Interval {
        /// Name of the task.
        task: String,
        /// MuJoCo's steps in one control interval.
        frame_skip: usize,
        /// MuJoCo's step \[s\].
        timestep: f64,
        /// The control interval the task declares \[s\].
        dt: f64,
    },
    /// MuJoCo raised an error of its own.
    #[error("MuJoCo failed: {message}")]
    Raised {
        /// MuJoCo's message.
        message: String,
    },
}

/// The list of places, a line each.
struct Tried<'a>(&'a [Attempt]);

impl fmt::Display for Tried<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str(" (nowhere to look)");
        }
        f.write_str("; looked at:")?;
        self.0.iter().try_for_each(|Attempt { place, reason }| write!(f, "\n  {place}: {reason}"))
    }
}
