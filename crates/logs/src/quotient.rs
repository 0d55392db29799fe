//! Difference quotients.

use std::fmt;

/// A state that was not measured: its column is the difference quotient of that of another state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The state.
    pub rate: String,
    /// The state of which it is the rate.
    pub of: String,
    /// How it was computed.
    pub quotient: Quotient,
}

/// Difference quotients of samples x\[k\], Δt apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quotient {
    /// (x\[k\] − x\[k−1\])/Δt.
    Backward,
    /// (x\[k+1\] − x\[k\])/Δt.
    Forward,
    /// (x\[k+1\] − x\[k−1\])/(2Δt), as `numpy.gradient`.
    Central,
}

impl fmt::Display for Quotient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Backward => "backward",
            Self::Forward => "forward",
            Self::Central => "central",
        })
    }
}
