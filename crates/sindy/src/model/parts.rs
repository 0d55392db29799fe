//! What a model is made of.

use serde::{Deserialize, Serialize};
use sindyna_core::Scheme;

use super::frame::Reading;

/// What the left-hand side of the equations is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    /// (x⁺ − x)/Δt = Θ(x; u) Ξᵀ.
    Increment,
    /// x⁺ = Θ(x; u) Ξᵀ.
    Discrete,
    /// ẋ = Θ(x; u) Ξᵀ, stepped by a scheme.
    Continuous(Scheme),
    /// ẋ = Θ(x; u) Ξᵀ, stepped by semi-implicit Euler: states whose rate is a state too move by their new rate.
    SemiImplicit {
        /// Equal parts of the control interval; 0 counts as 1.
        substeps: usize,
    },
}

/// One summand of an equation: coefficient × term, or coefficient × term × ẋ of a state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Number of the term.
    pub term: usize,
    /// Its coefficient.
    pub coefficient: f64,
    /// The state whose derivative the term is multiplied by, if any: the equation is then implicit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<usize>,
}

impl Entry {
    /// coefficient × term.
    #[must_use]
    pub fn new(term: usize, coefficient: f64) -> Self {
        Self { term, coefficient, rate: None }
    }
}

/// Everything a model is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParts {
    /// Names of the model's states (n).
    pub states: Vec<String>,
    /// Names of the controls (k).
    pub controls: Vec<String>,
    /// What the left-hand side is.
    pub form: Form,
    /// Control interval \[s\].
    pub dt: f64,
    /// How the model's states follow from the task's; `None` if they are the same.
    pub readings: Option<Vec<Reading>>,
    /// Active terms as text over the names, where a character that cannot stand in a name is `_`.
    pub terms: Vec<String>,
    /// Per state: the summands of its equation.
    pub equations: Vec<Vec<Entry>>,
    /// Per state: whether its rate is a state too.
    pub kinematic: Vec<bool>,
    /// Per state: what is added to it before the terms are computed, such as the tilt of an angle's zero.
    pub offsets: Vec<f64>,
    /// Number of candidate terms F.
    pub n_features: usize,
}
