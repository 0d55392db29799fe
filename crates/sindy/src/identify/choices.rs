//! What a user chooses by name.

use std::str::FromStr;

use sindyna_core::Scheme;

use crate::error::UnknownName;
use crate::model::Form;
use crate::solve::{Selected, Selection};
use crate::{BestSubset, CoordinateMode, Differentiator, Library, SavitzkyGolay, Stlsq, Triangle};

/// Where the candidate terms come from.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum LibraryChoice {
    /// One rule for every system, at least the paper's terms.
    Auto,
    /// The paper's terms, by number of states.
    Paper,
    /// The other reading of the paper's terms for small systems: degree 2 with products, waves of the states.
    PaperDegree2,
    /// Terms written by hand, such as `v^2*sin(x)`.
    Terms(Vec<String>),
    /// A library of one's own.
    Custom(Library),
}

impl FromStr for LibraryChoice {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        match name {
            "auto" => Ok(Self::Auto),
            "paper" => Ok(Self::Paper),
            "paper-degree2" => Ok(Self::PaperDegree2),
            _ => Err(unknown("library", name, "`auto`, `paper`, `paper-degree2`")),
        }
    }
}

/// What is believed of the errors of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseChoice {
    /// As the spec declares them; estimated where it declares none.
    Declared,
    /// Estimated from the data, whatever the spec declares, where equations do not explain them to rounding.
    Estimated,
    /// There are none but rounding: equations that leave more are approximations.
    Rounding,
}

/// How coefficients are found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SolverChoice {
    /// The smallest subset of terms that explains the data.
    BestSubset(BestSubset),
    /// Thresholding.
    Stlsq(Stlsq),
    /// All terms, with a ridge weight.
    LeastSquares {
        /// Ridge weight, at least 0.
        ridge: f64,
    },
}

impl FromStr for SolverChoice {
    type Err = UnknownName;

    /// `stlsq` is the paper's setting, `least-squares` has no ridge.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        match name {
            "best-subset" => Ok(Self::BestSubset(BestSubset::default())),
            "stlsq" => Ok(Self::Stlsq(Stlsq::paper())),
            "least-squares" => Ok(Self::LeastSquares { ridge: 0.0 }),
            _ => Err(unknown("solver", name, "`best-subset`, `stlsq`, `least-squares`")),
        }
    }
}

/// What is regressed on the terms.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Target {
    /// The rates of the states, with the way they are stepped; where states are declared to be rates of others, these are
    /// not fitted. For best subsets in recognised
    /// coordinates; elsewhere the same as [`Target::Increment`].
    Motion,
    /// (x⁺ − x)/Δt.
    Increment,
    /// x⁺.
    Discrete,
    /// ẋ, estimated along each rollout.
    Continuous {
        /// How.
        differentiator: Differentiator,
        /// How the model is stepped afterwards.
        scheme: Scheme,
    },
}

impl Target {
    /// The left-hand side of a model fitted to this target.
    #[must_use]
    pub fn form(&self) -> Form {
        match *self {
            Self::Motion | Self::Increment => Form::Increment,
            Self::Discrete => Form::Discrete,
            Self::Continuous { scheme, .. } => Form::Continuous(scheme),
        }
    }
}

impl SolverChoice {
    /// One equation: column `target` of `triangle`, whose first columns are the terms `selection` speaks of.
    #[must_use]
    pub fn solve(&self, triangle: &Triangle, target: usize, selection: Selection<'_>) -> Selected {
        self.solve_while(triangle, target, selection, &|| true)
    }

    /// The same as long as `go_on` says so, which a search asks often.
    pub(crate) fn solve_while(
        &self,
        triangle: &Triangle,
        target: usize,
        selection: Selection<'_>,
        go_on: &dyn Fn() -> bool,
    ) -> Selected {
        let n_features = selection.complexity.len();
        match self {
            Self::BestSubset(solver) => solver.solve_while(triangle, target, selection, go_on),
            Self::Stlsq(solver) => {
                let fit = solver.solve(triangle, n_features, target);
                let found = Selected::dense(triangle, target, &fit.coefficients, selection.floor);
                Selected { converged: fit.converged, ..found }
            }
            Self::LeastSquares { ridge } => {
                let all: Vec<usize> = (0..n_features).collect();
                let xi = triangle.solve(&all, target, *ridge);
                Selected::dense(triangle, target, &xi, selection.floor)
            }
        }
    }
}

impl FromStr for Target {
    type Err = UnknownName;

    /// `motion` is the equations of motion with the way they are stepped;
    /// `continuous` is central differences, `smoothed` the same after Savitzky–Golay smoothing; both are stepped by one
    /// Runge–Kutta step of fourth order.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let continuous = |differentiator| Self::Continuous { differentiator, scheme: Scheme::Rk4 { substeps: 1 } };
        match name {
            "motion" => Ok(Self::Motion),
            "increment" => Ok(Self::Increment),
            "discrete" => Ok(Self::Discrete),
            "continuous" => Ok(continuous(Differentiator::default())),
            "smoothed" => Ok(continuous(Differentiator::Smoothed(SavitzkyGolay::default()))),
            _ => Err(unknown("target", name, "`motion`, `increment`, `discrete`, `continuous`, `smoothed`")),
        }
    }
}

impl FromStr for CoordinateMode {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        match name {
            "recognised" => Ok(Self::Recognised),
            "raw" => Ok(Self::Raw),
            _ => Err(unknown("coordinates", name, "`recognised`, `raw`")),
        }
    }
}

fn unknown(what: &'static str, name: &str, known: &'static str) -> UnknownName {
    UnknownName { what, name: name.to_owned(), known }
}

/// Whether the system is disturbed: pushed by hand, say, or rubs in ways that no candidate term says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Disturbances {
    /// It is not.
    None,
    /// It may be: equations are fitted to short pieces of the data where they leave more than noise of all.
    #[default]
    Possible,
    /// It is: equations that leave noise alone of all data are looked for near those of the pieces, and nowhere else.
    Known,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_choose_and_typos_are_answered_with_the_names_there_are() {
        assert_eq!("paper".parse(), Ok(LibraryChoice::Paper));
        assert_eq!("stlsq".parse(), Ok(SolverChoice::Stlsq(Stlsq::paper())));
        assert_eq!("increment".parse(), Ok(Target::Increment));
        assert_eq!("raw".parse(), Ok(CoordinateMode::Raw));
        let error = "papper".parse::<LibraryChoice>().expect_err("a typo");
        assert_eq!(error.to_string(), "no library named `papper`; known: `auto`, `paper`, `paper-degree2`");
    }
}
