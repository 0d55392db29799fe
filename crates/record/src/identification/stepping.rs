//! How equations are stepped, for people and programs.

use std::fmt;

use serde::{Deserialize, Serialize};
use sindyna_core::Scheme;
use sindyna_core::number::significant;
use sindyna_sindy::{Form, Model};

/// How one control interval is made of the equations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stepping {
    /// `map`, `increment`, `euler`, `semi-implicit-euler` or `rk4`.
    pub scheme: String,
    /// Equal parts of the interval.
    pub substeps: usize,
    /// The interval \[s\].
    pub dt: f64,
}

impl Stepping {
    /// How `model` is stepped.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let (scheme, substeps) = match model.form() {
            Form::Discrete => ("map", 1),
            Form::Increment => ("increment", 1),
            Form::SemiImplicit { substeps } => ("semi-implicit-euler", substeps.max(1)),
            Form::Continuous(Scheme::Euler) => ("euler", 1),
            Form::Continuous(Scheme::Rk4 { substeps }) => ("rk4", substeps),
        };
        Self { scheme: scheme.into(), substeps, dt: model.dt() }
    }
}

/// `stepped by semi-implicit Euler, 0.05 s`
impl fmt::Display for Stepping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let dt = significant(self.dt, 9);
        match (self.scheme.as_str(), self.substeps) {
            ("map", _) => write!(f, "the next state, {dt} s later"),
            ("increment", _) => write!(f, "differences over {dt} s"),
            ("euler", _) => write!(f, "stepped by Euler, {dt} s"),
            ("semi-implicit-euler", 0 | 1) => write!(f, "stepped by semi-implicit Euler, {dt} s"),
            ("semi-implicit-euler", n) => {
                let part = significant(self.dt / n as f64, 9);
                write!(f, "stepped by semi-implicit Euler, {n} steps of {part} s")
            }
            (_, 0 | 1) => write!(f, "stepped by Runge–Kutta of fourth order, {dt} s"),
            (_, n) => {
                let part = significant(self.dt / n as f64, 9);
                write!(f, "stepped by Runge–Kutta of fourth order, {n} steps of {part} s")
            }
        }
    }
}
