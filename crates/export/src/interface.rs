//! How a policy meets the equations: what it observes of a state, what its actions put on the system, and where episodes begin.

use sindyna_core::{Channel, Kind, Precision, Seed, Space, Spec, Task};
use sindyna_sindy::{Expr, Function};

/// What stands between equations over the states of a task and its policy.
pub struct Interface {
    /// Observed values (m) as functions of the states.
    pub(super) readings: Vec<Expr>,
    /// Whether the sensors show single precision.
    pub(super) rounded: bool,
    /// The control of every numbered action; none where actions are controls.
    pub(super) numbered: Vec<Vec<f64>>,
    /// Smallest and largest control (k each).
    pub(super) controls: Vec<(f64, f64)>,
    /// Declared range of every state, infinite where there is none: what the equations were simulated within.
    pub(super) bounds: Vec<(f64, f64)>,
    /// Controls without a policy (k).
    pub(super) held: Vec<f64>,
    /// States that episodes begin in.
    pub(super) starts: Vec<Vec<f64>>,
    /// Names and units of the states.
    pub(super) labels: Vec<String>,
    /// Name of the task.
    pub(super) name: String,
}

/// Start states that a page offers.
const STARTS: u64 = 12;

impl Interface {
    /// That of `task`, whose sensors show its states, cosines and sines of them, or `formulas` of the states, by the names of their channels; `None`
    /// for others.
    pub fn of(task: &dyn Task, formulas: &[(String, Expr)], seed: u64) -> Option<Self> {
        let spec = task.spec();
        let readings = spec.observation.iter().map(|o| reading(spec, formulas, o)).collect::<Option<Vec<_>>>()?;
        let start = |i: u64| {
            let mut x = vec![0.0; spec.state_dim()];
            task.initial(&mut Seed::new(seed).stream("start of the page", i), &mut x);
            x
        };
        let (numbered, controls) = match &spec.action_space {
            Space::Box { low, high } => (Vec::new(), low.iter().copied().zip(high.iter().copied()).collect()),
            Space::Discrete { controls } => {
                let range = |column: ndarray::ArrayView1<'_, f64>| {
                    column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
                };
                let ranges = controls.columns().into_iter().map(range).collect();
                (controls.rows().into_iter().map(|row| row.to_vec()).collect(), ranges)
            }
        };
        Some(Self {
            readings,
            rounded: spec.precision == Precision::F32,
            numbered,
            controls,
            held: vec![0.0; spec.control_dim()],
            bounds: spec.state.iter().map(|c| c.prior.bounds).collect(),
            starts: (0..STARTS).map(start).collect(),
            labels: spec.state.iter().map(label).collect(),
            name: spec.name.clone(),
        })
    }

    /// That of equations without a policy, from the states of a log: `starts` (n each), controls within `controls` (k) that begin at `held` (k).
    pub fn without_policy(
        name: String,
        labels: Vec<String>,
        starts: Vec<Vec<f64>>,
        (controls, held): (Vec<(f64, f64)>, Vec<f64>),
    ) -> Self {
        let bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); labels.len()];
        Self {
            readings: Vec::new(),
            rounded: false,
            numbered: Vec::new(),
            controls,
            held,
            bounds,
            starts,
            labels,
            name,
        }
    }
}

fn reading(spec: &Spec, formulas: &[(String, Expr)], observed: &Channel) -> Option<Expr> {
    let wave = |function, i| Expr::Call(function, Box::new(Expr::Variable(i)));
    match observed.kind {
        Kind::CosOf(i) => Some(wave(Function::Cos, i)),
        Kind::SinOf(i) => Some(wave(Function::Sin, i)),
        _ => {
            let state = spec.state.iter().position(|state| state.name == observed.name).map(Expr::Variable);
            state.or_else(|| formulas.iter().find(|(name, _)| *name == observed.name).map(|(_, f)| f.clone()))
        }
    }
}

fn label(channel: &Channel) -> String {
    if channel.unit.is_empty() { channel.name.clone() } else { format!("{} [{}]", channel.name, channel.unit) }
}
