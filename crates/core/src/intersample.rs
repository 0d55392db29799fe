//! What inputs do between samples.

use serde::{Deserialize, Serialize};

/// Behaviour of the inputs between two samples, as `InterSample` of MATLAB's `iddata`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InterSample {
    /// Zero-order hold: constant from each sample to the next.
    #[default]
    Zoh,
    /// First-order hold: linear from each sample to the next.
    Foh,
}
