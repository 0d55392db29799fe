//! What was decided about a log without being asked for.

use std::fmt;

use sindyna_core::number::{plural, significant};

/// Something that was decided or seen while a log was read, for the user to check.
///
/// [`Display`](fmt::Display) says it in a line.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Columns that are neither states nor inputs.
    Unused {
        /// Their names.
        columns: Vec<String>,
    },
    /// The last line has no line break.
    EndsAbruptly,
    /// An angle that was folded into one turn was made continuous.
    Unwrapped {
        /// The angle.
        state: String,
        /// Jumps by a whole turn that were joined.
        jumps: usize,
    },
    /// One step of a state is far longer than the others.
    Jump {
        /// The state.
        state: String,
        /// Length of the step, in the state's unit.
        step: f64,
        /// Line of the row it leads to.
        line: usize,
        /// How many times as long as 95 of 100 steps it is.
        times: f64,
    },
    /// A state never changes, so no candidate term has it.
    Still {
        /// The state.
        state: String,
    },
    /// A sampling interval was given although there are time stamps.
    TimeIgnored {
        /// The interval given \[s\].
        dt: f64,
    },
    /// The log was interpolated.
    Resampled {
        /// Every so many seconds.
        dt: f64,
    },
    /// Two columns were recognised as cosine and sine of one angle.
    Circle {
        /// The column that is the cosine.
        cosine: String,
        /// The column that is the sine.
        sine: String,
        /// Name of the angle, which is the state.
        angle: String,
    },
    /// A state was recognised as the rate of another.
    Rate {
        /// The rate.
        rate: String,
        /// The state whose rate it is.
        of: String,
        /// Largest share by which the state changes otherwise \[%\].
        percent: f64,
    },
    /// A state was declared the rate of another, which changes otherwise.
    DoubtfulRate {
        /// The rate as declared.
        rate: String,
        /// The state whose rate it should be.
        of: String,
        /// RMS difference, as a share of the change \[%\].
        percent: f64,
    },
    /// A state was written with few digits; the step is taken as its measurement error.
    Rounded {
        /// The state.
        state: String,
        /// Distance of two neighbouring values.
        step: f64,
    },
    /// Trajectories of one row, which have no step, are left out.
    Skipped {
        /// How many.
        trajectories: usize,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unused { columns } => match &columns[..] {
                [one] => write!(f, "the column `{one}` is not used"),
                several => {
                    let list: Vec<String> = several.iter().map(|c| format!("`{c}`")).collect();
                    write!(f, "the columns {} are not used", list.join(", "))
                }
            },
            Self::EndsAbruptly => f.write_str(
                "the last line has no line break; if the log was cut off there, its last number may be short",
            ),
            Self::Unwrapped { state, jumps } => {
                write!(f, "{state} is joined where it jumps by a whole turn: {}", plural(*jumps, "jump"))
            }
            Self::Jump { state, step, line, times } => write!(
                f,
                "{state} moves by {step:.3} before line {line}, {times:.0} times as far as in 95 of 100 steps; if another rollout \
                 begins there, a column `trajectory` must say so"
            ),
            Self::Still { state } => {
                write!(f, "{state} never changes, so what it does cannot be seen; no candidate term has it")
            }
            Self::TimeIgnored { dt } => {
                write!(f, "the sampling interval {dt} s is taken, the column `t` is not looked at")
            }
            Self::Resampled { dt } => write!(f, "resampled every {dt} s: straight lines between rows, inputs held"),
            Self::Circle { cosine, sine, angle } => {
                write!(f, "{cosine} and {sine} are taken as cosine and sine of one angle, {angle}")
            }
            Self::Rate { rate, of, percent } => {
                write!(f, "{rate} is taken as the rate of {of}, which changes by it to within {percent:.1} %")
            }
            Self::DoubtfulRate { rate, of, percent } => {
                write!(f, "{rate} is taken as the rate of {of} as declared; {of} changes otherwise, by {percent:.0} %")
            }
            Self::Rounded { state, step } => {
                write!(f, "{state} is written in steps of {}, which is taken as its error", significant(*step, 3))
            }
            Self::Skipped { trajectories } => {
                write!(f, "{trajectories} trajectories of one row have no step and are left out")
            }
        }
    }
}
