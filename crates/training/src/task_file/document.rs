//! A task file as it is written.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

/// The keys of a task file. What they mean is told in `docs/task-files.md`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub(super) name: String,
    /// The MJCF file, relative to the task file; its place in the text is kept for the record.
    pub(super) model: Option<Spanned<String>>,
    pub(super) frame_skip: Option<usize>,
    /// Seconds of one control interval, where no model tells.
    pub(super) dt: Option<f64>,
    /// The rate of each state, as a formula of states, controls and parameters.
    pub(super) equations: Option<BTreeMap<String, String>>,
    /// Numbers with names, for all formulas; those that are drawn for every episode are states from [`Document::with_drawn`] on.
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, Parameter>,
    /// Names for terms of the states and of each other.
    #[serde(default, rename = "let")]
    pub(super) definitions: BTreeMap<String, String>,
    pub(super) max_steps: usize,
    pub(super) solved_at: Option<f64>,
    pub(super) observation: Option<Vec<String>>,
    pub(super) state: Vec<State>,
    pub(super) control: Vec<Control>,
    pub(super) task: Formulas,
}

/// A number with a name.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a parameter must be a number, [low, high] or { mean = …, std = … }")]
pub(super) enum Parameter {
    /// The same always.
    Number(f64),
    /// Drawn for every episode.
    Drawn(StartValue),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct State {
    pub(super) name: String,
    #[serde(default)]
    pub(super) unit: String,
    #[serde(default = "one")]
    pub(super) scale: f64,
    /// Distribution of start values; the model's rest position, or 0, if there is none.
    pub(super) start: Option<StartValue>,
    pub(super) bounds: Option<[f64; 2]>,
    /// What is declared.
    pub(super) kind: Option<StateKind>,
    pub(super) rate_of: Option<String>,
    /// Whether it is a parameter, which never changes within an episode.
    #[serde(skip)]
    pub(super) still: bool,
}

/// How a start value is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged, expecting = "start must be [low, high] or { mean = …, std = … }")]
pub(super) enum StartValue {
    /// Uniformly from low to high.
    Range([f64; 2]),
    /// From a normal distribution.
    Normal(Normal),
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Normal {
    pub(super) mean: f64,
    pub(super) std: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum StateKind {
    Plain,
    Angle,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Control {
    pub(super) name: String,
    #[serde(default)]
    pub(super) unit: String,
    pub(super) low: f64,
    pub(super) high: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Formulas {
    pub(super) reward: String,
    pub(super) terminated: Option<String>,
    /// A condition on start states; others are drawn again.
    pub(super) start_if: Option<String>,
}

impl Document {
    /// The same with what actuators of the controls deliver as last states, with the `names` (k) and at rest at first; none for none.
    pub(super) fn with_actuators(mut self, names: &[String]) -> Self {
        for (name, control) in names.iter().zip(&self.control) {
            self.state.push(State {
                name: name.clone(),
                unit: control.unit.clone(),
                scale: control.low.abs().max(control.high.abs()),
                start: Some(StartValue::Range([0.0, 0.0])),
                bounds: None,
                kind: Some(StateKind::Plain),
                rate_of: None,
                still: false,
            });
            self.observation.iter_mut().for_each(|observation| observation.push(name.clone()));
        }
        self
    }
}

fn one() -> f64 {
    1.0
}
