//! `episode.csv`: the first episode of the evaluation, beside the model's prediction of it.

use sindyna_core::{
    Acting, Channel, Dataset, EnvError, Environment, Memory as _, Mode, Outcome, Policy, Rng, Seed, Spec,
};

use crate::table_csv::{Fields, number_rows, text_of};
use crate::{RecordError, TableError};

/// One episode of a policy on the system, and what the model predicts for the same policy from the same start.
///
/// A row per sample: its number, time \[s\], states, inputs held until the next sample, the states and inputs of the prediction,
/// the reward of the step. The columns are in this order; a name has its unit behind it, such as `θ [rad]`, and predictions
/// say so: `θ [rad] (model)`. A field is empty where there is no value: the last sample has no input and no reward, and
/// a prediction ends where the task ends it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeTable {
    /// The states with their units.
    pub states: Vec<String>,
    /// The inputs with their units.
    pub inputs: Vec<String>,
    /// One for each sample.
    pub rows: Vec<EpisodeRow>,
}

/// One sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeRow {
    /// Time since the start \[s\].
    pub t: f64,
    /// The states as the sensors show them (n).
    pub states: Vec<f64>,
    /// The inputs held until the next sample (k).
    pub inputs: Vec<f64>,
    /// The states that the model predicts (n).
    pub model_states: Vec<f64>,
    /// The inputs that the policy gives to the model (k).
    pub model_inputs: Vec<f64>,
    /// Reward of the step to the next sample.
    pub reward: Option<f64>,
}

impl EpisodeTable {
    /// The text of the file.
    ///
    /// # Errors
    /// [`RecordError::Csv`] if it cannot be written.
    pub fn to_csv(&self) -> Result<Vec<u8>, RecordError> {
        let signals = || self.states.iter().chain(&self.inputs);
        let head = ["step", "t"].map(String::from).into_iter().chain(signals().cloned());
        let predicted = signals().map(|name| format!("{name} (model)"));
        let head: Vec<String> = head.chain(predicted).chain(["reward".to_owned()]).collect();
        let (n, k) = (self.states.len(), self.inputs.len());
        let rows = self.rows.iter().enumerate().map(|(step, row)| {
            let mut fields = Fields::of([step as f64, row.t]);
            fields.add(&row.states, n).add(&row.inputs, k).add(&row.model_states, n).add(&row.model_inputs, k);
            fields.add(row.reward.as_slice(), 1);
            fields
        });
        text_of(&head, rows)
    }

    /// Reads the file, of a system with `n` states.
    ///
    /// # Errors
    /// [`TableError`] for any other text.
    pub fn from_csv(text: &str, n: usize) -> Result<Self, TableError> {
        let (head, rows) = number_rows(text, 3 + 2 * n)?;
        let signals = head.len() - 3;
        let odd = !signals.is_multiple_of(2) || signals / 2 < n;
        if odd {
            return Err(TableError::Columns { got: head.len(), needed: 4 + signals });
        }
        let k = signals / 2 - n;
        let row = |mut fields: Fields| {
            let _step = fields.whole();
            EpisodeRow {
                t: fields.take(1).first().copied().unwrap_or_default(),
                states: fields.take(n),
                inputs: fields.take(k),
                model_states: fields.take(n),
                model_inputs: fields.take(k),
                reward: fields.take(1).first().copied(),
            }
        };
        Ok(Self {
            states: head[2..2 + n].to_vec(),
            inputs: head[2 + n..2 + n + k].to_vec(),
            rows: rows.into_iter().map(row).collect(),
        })
    }

    /// The rows of an episode on the system: its `states`, the controls and rewards in the only rollout of `data`.
    #[must_use]
    pub fn of(states: &[Vec<f64>], data: &Dataset, spec: &Spec) -> Self {
        let rollout = data.rollouts().next();
        let row = |(i, x): (usize, &Vec<f64>)| EpisodeRow {
            t: i as f64 * data.dt(),
            states: x.clone(),
            inputs: rollout.filter(|r| i < r.controls.nrows()).map_or_else(Vec::new, |r| r.controls.row(i).to_vec()),
            reward: rollout.and_then(|r| r.rewards.get(i).copied()),
            ..EpisodeRow::default()
        };
        Self {
            states: labels(&spec.state),
            inputs: labels(&spec.control),
            rows: states.iter().enumerate().map(row).collect(),
        }
    }

    /// Adds what `model`, which was reset to the first state, does under `policy`; `state` reads its state.
    pub fn predict<E: Environment>(&mut self, model: &mut E, state: impl Fn(&E) -> Vec<f64>, policy: &dyn Policy) {
        let space = model.spec().action_space.clone();
        let (mut action, mut control) = (vec![0.0; space.action_dim()], vec![0.0; space.control_dim()]);
        // The best action draws nothing, and a model without sensor noise neither.
        let mut rng = Seed::new(0).stream("prediction of an episode", 0);
        let mut policy = Acting::begin(policy);
        for row in &mut self.rows {
            row.model_states = state(model);
            let observation = model.observation().to_vec();
            policy.act(&observation, Mode::Exploit, &mut rng, &mut action);
            if row.inputs.is_empty() || !space.control_into(&action, &mut control) {
                return;
            }
            row.model_inputs.clone_from(&control);
            match model.step(&action, &mut rng) {
                Ok(Outcome { terminated: false, truncated: false, .. }) => {}
                // What ends it is still a state.
                Ok(_) | Err(_) => return,
            }
        }
    }
}

/// Names of channels with their units behind them.
fn labels(channels: &[Channel]) -> Vec<String> {
    channels.iter().map(label).collect()
}

fn label(channel: &Channel) -> String {
    let Channel { name, unit, .. } = channel;
    if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") }
}

/// `names` with the units behind them that the first channel of this name has.
#[must_use]
pub fn labels_of(names: &[String], channels: &[&[Channel]]) -> Vec<String> {
    let channel = |name: &String| channels.iter().copied().flatten().find(|c| c.name == *name);
    names.iter().map(|name| channel(name).map_or_else(|| name.clone(), label)).collect()
}

/// Steps of an episode that are written down.
const MOST_STEPS: usize = 2_000;

/// An environment whose first episode is written down.
#[derive(Debug)]
pub struct Watched<E> {
    environment: E,
    data: Dataset,
    wanted: bool,
    /// Whether the first episode goes on.
    running: bool,
}

impl<E: Environment> Watched<E> {
    /// `environment`, before its first episode, which is written down if it is `wanted`: of a long one the first 2,000 steps.
    pub fn new(environment: E, wanted: bool) -> Self {
        let spec = environment.spec();
        let (m, k, a) = (spec.observation_dim(), spec.control_dim(), spec.action_space.action_dim());
        let data = Dataset::new(m, k, a, spec.dt);
        Self { environment, data, wanted, running: false }
    }

    /// The first episode, as far as it went.
    pub fn into_episode(self) -> Dataset {
        self.data
    }
}

impl<E: Environment> Environment for Watched<E> {
    fn spec(&self) -> &Spec {
        self.environment.spec()
    }

    fn observation(&self) -> &[f64] {
        self.environment.observation()
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        self.environment.reset(rng)?;
        // What a sensor cannot show ends the recording, not the evaluation.
        self.running =
            self.wanted && self.data.n_rollouts() == 0 && self.data.begin(self.environment.observation()).is_ok();
        Ok(())
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        let outcome = self.environment.step(action, rng)?;
        if self.running {
            let mut control = vec![0.0; self.spec().control_dim()];
            let known = self.spec().action_space.control_into(action, &mut control);
            let observation = self.environment.observation();
            self.running = known
                && self.data.push(action, &control, outcome.reward, observation).is_ok()
                && self.data.n_steps() < MOST_STEPS
                && !(outcome.terminated || outcome.truncated);
        }
        Ok(outcome)
    }
}
