//! How equations are found, as settings.

use serde::{Deserialize, Serialize};
use sindyna_core::Spec;
use sindyna_sindy::{EquationConstraint, Identifier, Stlsq};

use super::{CoordinatesName, LibraryName, SolverName, TargetName};
use crate::Error;

/// How equations are found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentificationConfig {
    /// Candidate terms.
    pub library: LibraryName,
    /// The user's own terms, added to the library.
    pub terms: Vec<String>,
    /// How terms are selected.
    pub solver: SolverName,
    /// Of STLSQ: coefficients below it are taken out.
    pub threshold: f64,
    /// Of STLSQ and least squares: weight of the coefficients' squares.
    pub ridge: f64,
    /// What the equations are fitted to.
    pub target: TargetName,
    /// In which coordinates the equations are.
    pub coordinates: CoordinatesName,
    /// Parts of equations that are known, such as `dw/dt: -9.81*sin(th)`.
    #[serde(default)]
    pub known: Vec<String>,
    /// Terms that equations have, such as `dw/dt: u`.
    #[serde(default)]
    pub required: Vec<String>,
    /// Terms that equations do not have.
    #[serde(default)]
    pub forbidden: Vec<String>,
    /// Signs of coefficients, such as `dw/dt: w < 0`.
    #[serde(default)]
    pub signs: Vec<String>,
}

impl Default for IdentificationConfig {
    fn default() -> Self {
        Self {
            library: LibraryName::Auto,
            terms: Vec::new(),
            solver: SolverName::BestSubset,
            threshold: 0.0009,
            ridge: 0.05,
            target: TargetName::Motion,
            coordinates: CoordinatesName::Recognised,
            known: Vec::new(),
            required: Vec::new(),
            forbidden: Vec::new(),
            signs: Vec::new(),
        }
    }
}

impl IdentificationConfig {
    /// The identification these settings describe, for the system `spec`.
    pub fn identifier(&self, spec: &Spec) -> Result<Identifier, Error> {
        // Refuses a threshold or ridge no solver can have, whether this one uses it or not.
        let stlsq = Stlsq::new(self.threshold, self.ridge)?;
        let identifier = Identifier::new(spec)
            .with_coordinates(self.coordinates.coordinates())
            .with_library(self.library.library())?
            .with_own_terms(self.terms.clone())?
            .with_solver(self.solver.solver(stlsq, self.ridge))
            .with_target(self.target.target());
        self.constraints()?.into_iter().try_fold(identifier, |identifier, (option, text, state, constraint)| {
            let refused = |source| Error::Constraint { option, text: text.to_owned(), source: Box::new(source) };
            identifier.with_constraint(&state, constraint).map_err(refused)
        })
    }

    /// What is known of equations: the option that said so, its text, the state, and the constraint.
    fn constraints(&self) -> Result<Vec<(&'static str, &str, String, EquationConstraint)>, Error> {
        let mut all = Vec::new();
        for (option, texts) in [
            ("--known", &self.known),
            ("--require", &self.required),
            ("--forbid", &self.forbidden),
            ("--sign", &self.signs),
        ] {
            for text in texts {
                let (state, constraint) = constraint(option, text)?;
                all.push((option, text.as_str(), state, constraint));
            }
        }
        Ok(all)
    }
}

/// Reads `dw/dt: FORMULA`.
fn constraint(option: &'static str, text: &str) -> Result<(String, EquationConstraint), Error> {
    let form = if option == "--sign" { "dSTATE/dt: TERM < 0" } else { "dSTATE/dt: ..." };
    let wrong = || Error::ConstraintForm { option, form, text: text.to_owned() };
    let (left, formula) = text.split_once(':').ok_or_else(wrong)?;
    let state = left.trim().strip_prefix('d').and_then(|s| s.strip_suffix("/dt")).ok_or_else(wrong)?;
    let formula = formula.trim().to_owned();
    let constraint = match option {
        "--known" => EquationConstraint::Known(formula),
        "--require" => EquationConstraint::Required(formula),
        "--forbid" => EquationConstraint::Forbidden(formula),
        _ => match (formula.split_once('>'), formula.split_once('<')) {
            (Some((term, zero)), None) if zero.trim() == "0" => EquationConstraint::Positive(term.trim().into()),
            (None, Some((term, zero))) if zero.trim() == "0" => EquationConstraint::Negative(term.trim().into()),
            _ => return Err(wrong()),
        },
    };
    Ok((state.to_owned(), constraint))
}
