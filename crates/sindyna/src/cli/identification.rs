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
    /// A term of your own, such as `v*abs(v)`; may be given several times
    #[arg(long = "term", value_name = "FORMULA", help_heading = "Identification")]
    terms: Vec<String>,
    /// A part of an equation that is known, such as "dw/dt: -9.81*sin(th)": the rest is looked for; may be given several times
    #[arg(long, value_name = "dX/dt: FORMULA", help_heading = "Identification")]
    known: Vec<String>,
    /// A term that an equation has, such as "dw/dt: u"; may be given several times
    #[arg(long = "require", value_name = "dX/dt: TERM", help_heading = "Identification")]
    required: Vec<String>,
    /// A term that an equation does not have, such as "dw/dt: w^2"; may be given several times
    #[arg(long = "forbid", value_name = "dX/dt: TERM", help_heading = "Identification")]
    forbidden: Vec<String>,
    /// The sign of a coefficient, such as "dw/dt: w < 0", if the equation has the term; may be given several times
    #[arg(long = "sign", value_name = "dX/dt: TERM < 0", help_heading = "Identification")]
    signs: Vec<String>,
    /// Sparse regression [default: best-subset]
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Identification")]
    solver: Option<SolverName>,
    /// STLSQ drops coefficients below this [default: 0.0009]
    #[arg(long, value_name = "X", help_heading = "Identification")]
    threshold: Option<f64>,
    /// Ridge weight of STLSQ and least squares [default: 0.05]
    #[arg(long, value_name = "X", help_heading = "Identification")]
    ridge: Option<f64>,
    /// What is found, or regressed on the terms [default: motion]
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
                return Err(Failure::new(format!("{option} means nothing to the solver `{solver}`"))
                    .hint(format!("add `--solver {}`, or leave {option} out", known.join("` or `--solver "))));
            }
        }
        Ok(())
    }
}
