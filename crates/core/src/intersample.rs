//! What inputs do between samples.

use serde::{Deserialize, Serialize};

/// Behaviour of the inputs between two samples, as `InterSample` of MATLAB's `iddata`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InterSample {
    /// Zero-order hold: constant from each sample to the next.
    #[default]
    Zoh,
    /// First-order hold: linear from each sample to the next.
    Foh,
    /// Constant, and from a part of each step on (0 to 1) that of the next sample: zero-order hold with a delay of a part of a step.
    Late(f64),
}

impl InterSample {
    /// Whether inputs stay the same over each step.
    #[must_use]
    pub fn is_held(self) -> bool {
        self == Self::Zoh
    }

    /// The part of each step after which inputs become those of the next sample at once; `None` if they do not.
    #[must_use]
    pub fn switch(self) -> Option<f64> {
        if let Self::Late(part) = self { Some(part) } else { None }
    }
}
