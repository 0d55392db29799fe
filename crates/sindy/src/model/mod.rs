//! The learned equations of motion: immutable, compiled, without any data.

mod document;
mod equations;
mod frame;
mod step;

pub use document::{ModelError, ModelParts};
pub use frame::Reading;

use crate::expr::{Expr, Tape};
use sindyna_core::Scheme;

/// What the left-hand side of the equations is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    /// (x⁺ − x)/Δt = Θ(x; u) Ξᵀ.
    Increment,
    /// x⁺ = Θ(x; u) Ξᵀ.
    Discrete,
    /// ẋ = Θ(x; u) Ξᵀ, stepped by a scheme.
    Continuous(Scheme),
}

/// Identified equations of motion.
///
/// Implements [`Dynamics`](sindyna_core::Dynamics) over the task's state, whatever space the equations live in.
/// Its JSON form ([`Model::to_json`]) holds every digit.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    parts: ModelParts,
    terms: Vec<Expr>,
    tape: Tape,
    /// Per equation: the coefficients and the registers they multiply.
    weights: Vec<Vec<(f64, u32)>>,
}

impl Model {
    /// What the left-hand side of the equations is.
    #[must_use]
    pub fn form(&self) -> Form {
        self.parts.form
    }

    /// Control interval \[s\].
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.parts.dt
    }

    /// Names of the model's states.
    #[must_use]
    pub fn states(&self) -> &[String] {
        &self.parts.states
    }

    /// Names of the controls.
    #[must_use]
    pub fn controls(&self) -> &[String] {
        &self.parts.controls
    }

    /// Active terms, as functions of z = (state; control).
    #[must_use]
    pub fn terms(&self) -> &[Expr] {
        &self.terms
    }

    /// Coefficients of equation `i` as (number of the active term, value).
    ///
    /// # Panics
    /// If there is no equation `i`.
    #[must_use]
    pub fn coefficients(&self, i: usize) -> &[(usize, f64)] {
        &self.parts.equations[i]
    }

    /// States times candidate terms: the paper's P.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.parts.states.len() * self.parts.n_features
    }

    /// Fitted coefficients that are not zero; rows of states whose rate is a state too are not counted.
    #[must_use]
    pub fn nonzero(&self) -> usize {
        let rows = self.parts.equations.iter().zip(&self.parts.kinematic);
        rows.filter(|(_, kinematic)| !**kinematic).map(|(row, _)| row.len()).sum()
    }

    /// Coefficients that are not zero in the paper's counting, its P′: those of x⁺ = Θ Ξᵀ (of ẋ for continuous models),
    /// kinematic rows included.
    #[must_use]
    pub fn nonzero_paper(&self) -> usize {
        let written: usize = self.parts.equations.iter().map(Vec::len).sum();
        if self.parts.form != Form::Increment {
            return written;
        }
        // x⁺ = x + Δt Θ Ξᵀ: the state itself is one more term, unless its row has it already.
        let has_own = |i: &usize| self.parts.equations[*i].iter().any(|(j, _)| self.terms[*j] == Expr::Variable(*i));
        written + (0..self.parts.states.len()).filter(|i| !has_own(i)).count()
    }
}
