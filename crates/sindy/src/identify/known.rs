//! What a user may know of an equation.

use crate::expr::ParseError;

/// Something known of the equation of one state, ẋ = …; formulas are over the names of states and inputs.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum EquationConstraint {
    /// A part of the right-hand side, coefficients included, such as `-9.81*sin(th)`. The rest is looked for.
    Known(String),
    /// A term the equation has, with a coefficient that is fitted.
    Required(String),
    /// A term the equation does not have.
    Forbidden(String),
    /// The coefficient of this term, if the equation has it, is not negative.
    Positive(String),
    /// The coefficient of this term, if the equation has it, is not positive.
    Negative(String),
}

impl EquationConstraint {
    pub(super) fn formula(&self) -> &str {
        match self {
            Self::Known(f) | Self::Required(f) | Self::Forbidden(f) | Self::Positive(f) | Self::Negative(f) => f,
        }
    }
}

/// Why a constraint was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EquationConstraintError {
    /// It is for a state there is not.
    #[error("no state named `{name}`; states: {known}")]
    NoSuchState {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// It is for a state whose rate is another state.
    #[error("the rate of `{state}` is the state `{rate}`, so its equation has no other terms")]
    Kinematic {
        /// The state.
        state: String,
        /// The state that is its rate.
        rate: String,
    },
    /// The formula cannot be read.
    #[error(transparent)]
    Parse(#[from] ParseError),
    /// A term that is forbidden, and required or known.
    #[error("`{formula}` is both forbidden and contained in the equation of `{state}`")]
    Contradiction {
        /// The formula.
        formula: String,
        /// The state.
        state: String,
    },
    /// Several terms where one is wanted.
    #[error("`{formula}` is not a single term without a coefficient")]
    NotOneTerm {
        /// The formula.
        formula: String,
    },
}
