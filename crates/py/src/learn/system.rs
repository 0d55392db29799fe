//! A system as Python describes it: what is observed, how states follow from that, what may be done.

use ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use sindyna::core::{Channel, Inverse, Kind, Precision, Sensors, Space, Spec};

use crate::library::symbols;

/// Name of everything that Python calls its own way.
const NAME: &str = "system";

/// What is declared about a system. States are called x0, x1, … and inputs u0, u1, … here.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Declared {
    /// Range of each observed value; null where there is none.
    pub(crate) bounds: Vec<(Option<f64>, Option<f64>)>,
    pub(crate) states: Vec<State>,
    pub(crate) actions: Actions,
    /// Whether observations are rounded to float32.
    pub(crate) float32: bool,
    pub(crate) dt: f64,
    pub(crate) max_steps: usize,
    pub(crate) threshold: Option<f64>,
}

/// A state, and how it is seen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct State {
    /// The observed value that it is; or those that are its cosine and its sine.
    pub(crate) seen: Vec<usize>,
    pub(crate) angle: bool,
    /// The state that it is the rate of.
    pub(crate) rate_of: Option<usize>,
}

/// What may be done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Actions {
    /// Real actions, clipped to these ranges.
    Box { low: Vec<f64>, high: Vec<f64> },
    /// Numbered actions, with the inputs of each.
    Numbered(Vec<Vec<f64>>),
}

impl Actions {
    fn space(&self) -> PyResult<Space> {
        Ok(match self {
            Self::Box { low, high } => Space::Box { low: low.clone(), high: high.clone() },
            Self::Numbered(rows) => {
                let width = rows.first().map_or(0, Vec::len);
                let controls = Array2::from_shape_vec((rows.len(), width), rows.concat());
                Space::Discrete {
                    controls: controls.map_err(|_| refused("every action needs as many inputs as the others"))?,
                }
            }
        })
    }
}

pub(crate) fn refused(why: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}

impl Declared {
    pub(crate) fn read(text: &str) -> PyResult<Self> {
        serde_json::from_str(text).map_err(refused)
    }

    /// What the engine is told. Everything that is not declared is of size 1, which no learner is told.
    pub(crate) fn spec(&self) -> PyResult<Spec> {
        let space = self.actions.space()?;
        let k = space.control_dim();
        let names = symbols(self.states.len(), k);
        let (state_names, inputs) = names.split_at(self.states.len());
        let within = |channel: Channel, at: usize| {
            let (low, high) = self.bounds[at];
            channel.within(low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY))
        };
        let mut observation = vec![None; self.bounds.len()];
        let mut states = Vec::new();
        for (i, (state, name)) in self.states.iter().zip(state_names).enumerate() {
            if state.seen.iter().any(|at| *at >= observation.len())
                || state.rate_of.is_some_and(|of| of >= self.states.len())
            {
                return Err(refused("a state is seen where nothing is observed, or the rate of no state"));
            }
            let kind = match state.rate_of {
                Some(of) => Kind::RateOf(of),
                None if state.angle => Kind::Angle,
                None => Kind::Plain,
            };
            let channel = Channel::new(name, "", kind, 1.0);
            match state.seen[..] {
                [at] => {
                    states.push(within(channel, at));
                    observation[at] = states.last().cloned();
                }
                [cosine, sine] => {
                    states.push(channel);
                    for (at, letter, kind) in [(cosine, 'c', Kind::CosOf(i)), (sine, 's', Kind::SinOf(i))] {
                        observation[at] = Some(Channel::new(&format!("{letter}{i}"), "", kind, 1.0).within(-1.0, 1.0));
                    }
                }
                _ => return Err(refused("a state is seen as one value, or as cosine and sine")),
            }
        }
        let control = inputs.iter().enumerate().map(|(i, name)| {
            let channel = Channel::new(name, "", Kind::Plain, 1.0);
            match &space {
                Space::Box { low, high } => channel.within(low[i], high[i]),
                Space::Discrete { controls } => {
                    let column = controls.column(i);
                    let ends = column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (v.min(l), v.max(h)));
                    channel.within(ends.0, ends.1)
                }
            }
        });
        Ok(Spec {
            name: NAME.into(),
            control: control.collect(),
            state: states,
            observation: observation
                .into_iter()
                .collect::<Option<_>>()
                .ok_or_else(|| refused("an observed value belongs to no state"))?,
            action_space: space,
            precision: if self.float32 { Precision::F32 } else { Precision::F64 },
            noise: 0.0,
            dt: self.dt,
        })
    }
}

/// The sensors of `spec`.
pub(crate) fn sensors(spec: &Spec) -> PyResult<Sensors> {
    Sensors::new(spec).ok_or_else(|| refused("an observed value shows no state"))
}

/// The states (T, n) behind observations (T, m) of one episode.
#[pyfunction]
pub(crate) fn states<'py>(
    py: Python<'py>,
    system: &str,
    observations: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let spec = Declared::read(system)?.spec()?;
    let inverse = Inverse::of(&spec).map_err(refused)?;
    let seen = observations.as_array();
    if seen.ncols() != spec.observation_dim() {
        return Err(refused(format!("expected {} observed values, got {}", spec.observation_dim(), seen.ncols())));
    }
    let (mut found, mut near) = (Array2::zeros((seen.nrows(), spec.state_dim())), vec![0.0; spec.state_dim()]);
    let mut x = near.clone();
    for (row, mut slot) in seen.rows().into_iter().zip(found.rows_mut()) {
        inverse.state(&row.to_vec(), &near, &mut x);
        near.copy_from_slice(&x);
        slot.iter_mut().zip(&x).for_each(|(slot, v)| *slot = *v);
    }
    Ok(found.into_pyarray(py))
}
