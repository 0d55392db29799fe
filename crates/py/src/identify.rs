//! Equations of motion with noise nobody has declared: sindyna's own estimator.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::Deserialize;
use serde_json::json;
use sindyna_core::{Certainty, Channel, Kind, Precision, Space, Spec};
use sindyna_sindy::{
    BestSubset, EquationConstraint, Identified, Identifier, LibraryChoice, NoiseChoice, Recording, SolverChoice, Watch,
};

use crate::interrupt::apart;
use crate::library::{Recipe, symbols};
use crate::model::Model;

/// What is known of a system and how it is to be identified.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    n_states: usize,
    n_controls: usize,
    dt: f64,
    /// States that are angles.
    angles: Vec<usize>,
    /// Pairs of a state and the state whose rate it is.
    rates: Vec<(usize, usize)>,
    library: Option<Recipe>,
    terms: Vec<String>,
    /// Standard deviations of the errors of the states that are believed at least (n).
    declared_noise: Option<Vec<f64>>,
    rounding_only: bool,
    constraints: Vec<(usize, Knowledge, String)>,
    max_size: Option<usize>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum Knowledge {
    Known,
    Require,
    Forbid,
    Positive,
    Negative,
}

impl Knowledge {
    fn of(self, formula: String) -> EquationConstraint {
        match self {
            Self::Known => EquationConstraint::Known(formula),
            Self::Require => EquationConstraint::Required(formula),
            Self::Forbid => EquationConstraint::Forbidden(formula),
            Self::Positive => EquationConstraint::Positive(formula),
            Self::Negative => EquationConstraint::Negative(formula),
        }
    }
}

impl Settings {
    fn spec(&self) -> Spec {
        let names = symbols(self.n_states, self.n_controls);
        let (states, controls) = names.split_at(self.n_states);
        let sigma = |i: usize| self.declared_noise.as_ref().and_then(|s| s.get(i)).copied();
        let kind = |i: usize| match self.rates.iter().find(|(rate, _)| *rate == i) {
            Some((_, of)) => Kind::RateOf(*of),
            None if self.angles.contains(&i) => Kind::Angle,
            None => Kind::Plain,
        };
        let state = |(i, name): (usize, &String)| Channel::new(name, "", kind(i), sigma(i).unwrap_or(1.0));
        let states: Vec<Channel> = states.iter().enumerate().map(state).collect();
        let bound = vec![f64::INFINITY; controls.len()];
        Spec {
            name: "system".into(),
            observation: states.clone(),
            state: states,
            control: controls.iter().map(|name| Channel::new(name, "", Kind::Plain, 1.0)).collect(),
            action_space: Space::Box { low: bound.iter().map(|v| -v).collect(), high: bound },
            precision: Precision::F64,
            noise: if self.declared_noise.is_some() { 1.0 } else { 0.0 },
            dt: self.dt,
        }
    }

    fn identifier(self) -> PyResult<Identifier> {
        let refused = |e: &dyn std::fmt::Display| PyValueError::new_err(e.to_string());
        let mut identifier = Identifier::new(&self.spec());
        if self.rounding_only {
            identifier = identifier.with_noise(NoiseChoice::Rounding);
        }
        if let Some(max_size) = self.max_size {
            let solver = BestSubset::default().with_max_size(max_size);
            identifier = identifier.with_solver(SolverChoice::BestSubset(solver));
        }
        if let Some(library) = self.library {
            identifier = identifier.with_library(LibraryChoice::Custom(library.into())).map_err(|e| refused(&e))?;
        }
        if !self.terms.is_empty() {
            identifier = identifier.with_own_terms(self.terms).map_err(|e| refused(&e))?;
        }
        for (state, known, formula) in self.constraints {
            identifier =
                identifier.with_constraint(&format!("x{state}"), known.of(formula)).map_err(|e| refused(&e))?;
        }
        Ok(identifier)
    }
}

/// Identifies the equations behind recordings: times (T + 1), states (T + 1, n), inputs (T, k) held from sample to sample.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    recordings: Vec<(PyReadonlyArray1<'_, f64>, PyReadonlyArray2<'_, f64>, PyReadonlyArray2<'_, f64>)>,
    settings: &str,
) -> PyResult<(Model, String)> {
    let settings: Settings = serde_json::from_str(settings).map_err(|e| PyValueError::new_err(e.to_string()))?;
    let identifier = settings.identifier()?;
    let recordings: Vec<Recording> = recordings
        .iter()
        .map(|(times, states, controls)| {
            Recording::new(times.as_array().to_vec(), states.as_array().to_owned(), controls.as_array().to_owned())
        })
        .collect();
    let found = apart(py, move |stop| {
        let go_on = || !stop.is_set();
        let found = identifier.identify_recordings_watched(&recordings, &Watch::going_on(&go_on));
        found.map(|found| (account(&found), found.model))
    })?;
    let (account, model) = found.map_err(|e| PyValueError::new_err(e.to_string()))?;
    Ok((Model::new(model), account))
}

/// The account of an identification, as JSON; numbers that are not finite are null.
pub(crate) fn account(found: &Identified) -> String {
    let certainty = match found.certainty() {
        Certainty::Exact => "exact",
        Certainty::Adequate => "adequate",
        Certainty::Ambiguous => "ambiguous",
        Certainty::Doubted => "doubted",
    };
    let doubts: Vec<Option<String>> =
        found.report.equations.iter().map(|e| e.doubt.map(|doubt| doubt.to_string())).collect();
    json!({ "certainty": certainty, "doubts": doubts, "report": found.report }).to_string()
}
