//! How equations are found, as options.

use clap::Args;
use sindyna_training::settings::{IdentificationConfig, LibraryName, SolverName, TargetName};

use super::common::set;
use crate::cli::failure::Failure;

/// Options that change how equations are found.
#[derive(Debug, Default, PartialEq, Args)]
pub(crate) struct IdentificationOptions {
    /// Candidate terms [default: auto]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Identification")]
    pub(super) library: Option<LibraryName>,
    /// Additional candidate term, such as `v*abs(v)`; may be repeated
    #[arg(long = "term", value_name = "FORMULA", help_heading = "Identification")]
    terms: Vec<String>,
    /// Known part of an equation, such as "dw/dt: -9.81*sin(th)"; the remaining terms are identified; may be repeated
    #[arg(long, value_name = "dX/dt: FORMULA", help_heading = "Identification")]
    known: Vec<String>,
    /// Term that an equation contains, such as "dw/dt: u"; may be repeated
    #[arg(long = "require", value_name = "dX/dt: TERM", help_heading = "Identification")]
    required: Vec<String>,
    /// Term that an equation does not contain, such as "dw/dt: w^2"; may be repeated
    #[arg(long = "forbid", value_name = "dX/dt: TERM", help_heading = "Identification")]
    forbidden: Vec<String>,
    /// Sign of a coefficient, such as "dw/dt: w < 0", where the equation contains the term; may be repeated
    #[arg(long = "sign", value_name = "dX/dt: TERM < 0", help_heading = "Identification")]
    signs: Vec<String>,
    /// Sparse regression [default: best-subset]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Identification")]
    solver: Option<SolverName>,
    /// Threshold of STLSQ: smaller coefficients are set to zero [default: 0.0009]
    #[arg(long, value_name = "X", help_heading = "Identification")]
    threshold: Option<f64>,
    /// Ridge weight of STLSQ and least squares [default: 0.05]
    #[arg(long, value_name = "X", help_heading = "Identification")]
    ridge: Option<f64>,
    /// Target of the regression [default: motion]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Identification")]
    target: Option<TargetName>,
}

impl IdentificationOptions {
    /// Writes what was given over `settings`.
    pub(crate) fn apply(&self, settings: &mut IdentificationConfig) {
        set(&mut settings.library, &self.library);
        if !self.terms.is_empty() {
            settings.terms.clone_from(&self.terms);
        }
        for (list, given) in [
            (&mut settings.known, &self.known),
            (&mut settings.required, &self.required),
            (&mut settings.forbidden, &self.forbidden),
            (&mut settings.signs, &self.signs),
        ] {
            if !given.is_empty() {
                list.clone_from(given);
            }
        }
        set(&mut settings.solver, &self.solver);
        set(&mut settings.threshold, &self.threshold);
        set(&mut settings.ridge, &self.ridge);
        set(&mut settings.target, &self.target);
    }

    /// Refuses options that the solver of `settings` does not know: they would change nothing.
    pub(crate) fn check(&self, settings: &IdentificationConfig) -> Result<(), Failure> {
        let solver = settings.solver.to_string();
        for (option, given, known) in [
            ("--threshold", self.threshold.is_some(), &["stlsq"][..]),
            ("--ridge", self.ridge.is_some(), &["stlsq", "least-squares"]),
        ] {
            if given && !known.contains(&solver.as_str()) {
                return Err(Failure::new(format!("{option} does not apply to the solver `{solver}`"))
                    .hint(format!("add `--solver {}`, or leave {option} out", known.join("` or `--solver "))));
            }
        }
        Ok(())
    }
}
