//! How equations are found, as settings.

use serde::{Deserialize, Serialize};
use sindyna_core::Spec;
use sindyna_sindy::{Identifier, SolverChoice, Stlsq};

use crate::failure::Failure;

/// How equations are found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct IdentificationConfig {
    pub(crate) library: String,
    /// The user's own terms, added to the library.
    pub(crate) terms: Vec<String>,
    pub(crate) solver: String,
    pub(crate) threshold: f64,
    pub(crate) ridge: f64,
    pub(crate) target: String,
    pub(crate) coordinates: String,
}

impl Default for IdentificationConfig {
    fn default() -> Self {
        Self {
            library: "auto".into(),
            terms: Vec::new(),
            solver: "best-subset".into(),
            threshold: 0.0009,
            ridge: 0.05,
            target: "motion".into(),
            coordinates: "recognised".into(),
        }
    }
}

impl IdentificationConfig {
    /// The identification these settings describe, for the system `spec`.
    pub(crate) fn identifier(&self, spec: &Spec) -> Result<Identifier, Failure> {
        // Refuses a threshold or ridge no solver can have, whether this one uses it or not.
        let stlsq = Stlsq::new(self.threshold, self.ridge)?;
        let solver = match self.solver.parse()? {
            SolverChoice::Stlsq(_) => SolverChoice::Stlsq(stlsq),
            SolverChoice::LeastSquares { .. } => SolverChoice::LeastSquares { ridge: self.ridge },
            other => other,
        };
        Ok(Identifier::new(spec)
            .with_coordinates(self.coordinates.parse()?)
            .with_library(self.library.parse()?)?
            .with_own_terms(self.terms.clone())?
            .with_solver(solver)
            .with_target(self.target.parse()?))
    }
}
