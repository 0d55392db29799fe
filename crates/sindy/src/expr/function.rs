//! The functions a term may use.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Function {
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Exponential.
    Exp,
    /// Natural logarithm.
    Log,
    /// Square root.
    Sqrt,
    /// Absolute value.
    Abs,
    /// −1, 0 or 1.
    Sign,
    /// Hyperbolic tangent.
    Tanh,
    /// The larger of a number and zero, written max(a, 0); `max`, `min` and `clip` of terms are made of it.
    PositivePart,
    /// Inverse tangent, between −π/2 and π/2.
    Atan,
}

impl Function {
    /// Every function, in the order the names are listed to people.
    pub const ALL: [Self; 11] = [
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Exp,
        Self::Log,
        Self::Sqrt,
        Self::Abs,
        Self::Sign,
        Self::Tanh,
        Self::PositivePart,
        Self::Atan,
    ];

    /// The name in terms written as text.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Exp => "exp",
            Self::Log => "log",
            Self::Sqrt => "sqrt",
            Self::Abs => "abs",
            Self::Sign => "sign",
            Self::Tanh => "tanh",
            Self::PositivePart => "max",
            Self::Atan => "atan",
        }
    }

    /// What follows the argument in terms written as text.
    pub(crate) fn rest(self) -> &'static str {
        if self == Self::PositivePart { ", 0" } else { "" }
    }

    /// The function called `name`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }

    /// The value at `v`.
    #[must_use]
    pub fn eval(self, v: f64) -> f64 {
        match self {
            Self::Sin => v.sin(),
            Self::Cos => v.cos(),
            Self::Tan => v.tan(),
            Self::Exp => v.exp(),
            Self::Log => v.ln(),
            Self::Sqrt => v.sqrt(),
            Self::Abs => v.abs(),
            Self::Sign if v > 0.0 => 1.0,
            Self::Sign if v < 0.0 => -1.0,
            // Zero stays zero, NaN stays NaN.
            Self::Sign => v * 0.0,
            Self::Tanh => v.tanh(),
            // Not `max`, which drops NaN.
            Self::PositivePart if v < 0.0 => 0.0,
            Self::PositivePart => v,
            Self::Atan => v.atan(),
        }
    }
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
