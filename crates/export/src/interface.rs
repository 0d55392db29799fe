//! How a policy meets the equations: what it observes of a state, what its actions put on the system, and where episodes begin.

use sindyna_core::{Channel, Kind, Precision, Seed, Space, Spec, Task};

/// An observed value as a function of the states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    State(usize),
    Cosine(usize),
    Sine(usize),
}

impl Reading {
    /// In a language that writes calls of functions as C does.
    pub(super) fn code(self, cosine: &str, sine: &str) -> String {
        match self {
            Self::State(i) => format!("x[{i}]"),
            Self::Cosine(i) => format!("{cosine}(x[{i}])"),
            Self::Sine(i) => format!("{sine}(x[{i}])"),
        }
    }
}

/// What stands between equations over the states of a task and its policy.
pub struct Interface {
    pub(super) readings: Vec<Reading>,
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
    /// That of `task`, whose sensors show its states or cosines and sines of them; `None` for others.
    pub fn of(task: &dyn Task, seed: u64) -> Option<Self> {
        let spec = task.spec();
        let readings = spec.observation.iter().map(|o| reading(spec, o)).collect::<Option<Vec<_>>>()?;
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

fn reading(spec: &Spec, observed: &Channel) -> Option<Reading> {
    match observed.kind {
        Kind::CosOf(i) => Some(Reading::Cosine(i)),
        Kind::SinOf(i) => Some(Reading::Sine(i)),
        _ => spec.state.iter().position(|state| state.name == observed.name).map(Reading::State),
    }
}

fn label(channel: &Channel) -> String {
    if channel.unit.is_empty() { channel.name.clone() } else { format!("{} [{}]", channel.name, channel.unit) }
}
