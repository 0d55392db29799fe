//! The method under test: the one place to change when another is to be tried.

use ndarray::Axis;
use sindyna_core::{Channel, Dynamics, Kind, Precision, Space, Spec};
use sindyna_sindy::{Identifier, Recording};

use crate::equations::Term;
use crate::log::{Log, Role, Trajectory};

/// What a method makes of a log.
pub struct Found {
    /// Terms of each state's equation.
    pub equations: Vec<Vec<Term>>,
    /// Whether the method claims that nothing is left to explain, and names no other terms that explain as much.
    pub adequate: bool,
    /// One sampling interval of what was found.
    pub dynamics: Box<dyn Dynamics>,
}

/// Identifies equations from `log` with the defaults: no noise declared, no terms added.
///
/// # Errors
/// Why nothing was identified.
pub fn identify(log: &Log) -> anyhow::Result<Found> {
    let spec = spec(log);
    let found = Identifier::new(&spec).identify_recordings(&recordings(log))?;
    let (model, names) = (found.model, log.variables());
    let terms = model.shifted_terms();
    let row = |i: usize| {
        let errors = &found.report.equations[i].standard_errors;
        let term = |(at, e): (usize, &sindyna_sindy::Entry)| {
            let text = terms[e.term].display(&names).to_string();
            let error = errors.get(at).copied().filter(|e| e.is_finite() && *e > 0.0);
            Term { text, rate: e.rate, coefficient: e.coefficient, error }
        };
        model.coefficients(i).iter().enumerate().map(term).collect()
    };
    let judged = |i: &usize| !model.kinematic()[*i];
    Ok(Found {
        equations: (0..log.states.len()).map(row).collect(),
        adequate: (0..log.states.len()).filter(judged).all(|i| {
            let equation = &found.report.equations[i];
            equation.reached_floor && equation.equally_good.is_empty()
        }),
        dynamics: Box::new(model),
    })
}

/// The log as a declared system, as `sindyna identify` declares one whose noise nobody gave.
fn spec(log: &Log) -> Spec {
    let reach = |of: fn(&Trajectory) -> &ndarray::Array2<f64>, i: usize| {
        let columns = log.trajectories.iter().map(|t| of(t).index_axis(Axis(1), i));
        let largest = columns.flatten().fold(0.0, |largest: f64, v| largest.max(v.abs()));
        if largest > 0.0 { largest } else { 1.0 }
    };
    let kind = |role: &Role| match role {
        Role::Plain => Kind::Plain,
        Role::Angle | Role::Turning => Kind::Angle,
        Role::RateOf(of) => Kind::RateOf(*of),
    };
    let states = log.states.iter().zip(&log.roles).enumerate();
    let state: Vec<_> = states.map(|(i, (s, r))| Channel::new(s, "", kind(r), reach(|t| &t.states, i))).collect();
    let controls = log.controls.iter().enumerate();
    let control: Vec<_> = controls.map(|(i, u)| Channel::new(u, "", Kind::Plain, reach(|t| &t.controls, i))).collect();
    let high: Vec<f64> = control.iter().map(|c| c.prior.scale).collect();
    Spec {
        name: "log".into(),
        observation: state.clone(),
        state,
        control,
        action_space: Space::Box { low: high.iter().map(|h| -h).collect(), high },
        precision: Precision::F64,
        noise: 0.0,
        dt: log.dt,
    }
}

/// The recordings with the times of their samples.
fn recordings(log: &Log) -> Vec<Recording> {
    let even = |t: &Trajectory| (0..t.states.nrows()).map(|i| i as f64 * log.dt).collect();
    let recording = |t: &Trajectory| {
        Recording::new(t.times.clone().unwrap_or_else(|| even(t)), t.states.clone(), t.controls.clone())
    };
    log.trajectories.iter().map(recording).collect()
}
