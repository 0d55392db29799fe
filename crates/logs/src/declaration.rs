//! Why a declaration of the user does not fit a log.

use std::fmt;

/// Why a declaration about columns or states is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeclarationError {
    /// `t` or `trajectory` was named as a state or an input.
    #[error("`{column}` is {}, not a state or an input", if column == crate::TRAJECTORY { "the column of trajectories" } else { "the column of the time" })]
    Reserved {
        /// Name of the column.
        column: String,
    },
    /// One column was named twice.
    #[error("the column `{column}` is named twice among states and inputs")]
    NamedTwice {
        /// Name of the column.
        column: String,
    },
    /// An option names a state that is not there.
    #[error("no state for `{option}` named `{state}`; known: {}", quoted(known))]
    UnknownState {
        /// Which option.
        option: StateOption,
        /// The state.
        state: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// Two states were declared cosine and sine of one angle and are not.
    #[error("`{cosine}` and `{sine}` are not a cosine and a sine: their squares do not add up to 1")]
    NotACircle {
        /// The column declared as cosine.
        cosine: String,
        /// The column declared as sine.
        sine: String,
    },
    /// A state was declared part of two angles.
    #[error("`{cosine}` and `{sine}`: a state can be part of one pair of cosine and sine only")]
    CircleTaken {
        /// The column declared as cosine.
        cosine: String,
        /// The column declared as sine.
        sine: String,
    },
    /// A state was declared its own rate.
    #[error("`{state}` cannot be its own rate")]
    OwnRate {
        /// The state.
        state: String,
    },
    /// A state was declared the rate of two, or to have two rates.
    #[error(
        "`{rate}` as the rate of `{of}` contradicts `{other_rate}` as the rate of `{other_of}`: a state has one rate"
    )]
    RateTaken {
        /// The state declared as rate.
        rate: String,
        /// The state whose rate it should be.
        of: String,
        /// The rate declared before.
        other_rate: String,
        /// The state whose rate that is.
        other_of: String,
    },
    /// Rates were declared in a circle.
    #[error("`{rate}` as the rate of `{of}` closes a circle of rates")]
    RateCircle {
        /// The state declared as rate.
        rate: String,
        /// The state whose rate it should be.
        of: String,
    },
    /// A column was declared the derivative of a state whose rate is a state too.
    #[error("`{column}` cannot be the derivative of `{state}`, whose rate is the state `{rate}`")]
    RateIsState {
        /// The column.
        column: String,
        /// The state.
        state: String,
        /// The state that is its rate.
        rate: String,
    },
    /// The derivatives of some states were declared and that of another is not known.
    #[error("no column is the derivative of `{state}`: with derivatives, those of all states are needed")]
    NoDerivative {
        /// The state.
        state: String,
    },
    /// Derivatives were declared in a log with cosines and sines of angles.
    #[error("derivatives cannot be used together with cosine and sine of an angle as states")]
    DerivativesOfCircles,
    /// A state was declared an angle and is the rate of another.
    #[error("`{state}` cannot be both an angle and the rate of `{of}`")]
    AngleAndRate {
        /// The state.
        state: String,
        /// The state whose rate it should be.
        of: String,
    },
}

/// The field of [`LogOptions`](crate::LogOptions) that names states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StateOption {
    /// [`LogOptions::angles`](crate::LogOptions::angles).
    Angles,
    /// [`LogOptions::rates`](crate::LogOptions::rates).
    Rates,
    /// [`LogOptions::circles`](crate::LogOptions::circles).
    Circles,
    /// [`LogOptions::derivatives`](crate::LogOptions::derivatives).
    Derivatives,
    /// [`LogOptions::noise`](crate::LogOptions::noise).
    Noise,
    /// [`LogOptions::limits`](crate::LogOptions::limits).
    Limits,
}

impl fmt::Display for StateOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Angles => "angles",
            Self::Rates => "rates",
            Self::Circles => "circles",
            Self::Derivatives => "derivatives",
            Self::Noise => "noise",
            Self::Limits => "limits",
        })
    }
}

/// `` `a`, `b` ``.
pub(crate) fn quoted(names: &[String]) -> String {
    names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}
