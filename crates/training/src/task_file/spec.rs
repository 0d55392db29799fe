//! What a task file declares: channels, reward, end.

use anyhow::{Context as _, bail, ensure};
use sindyna_core::{Channel, Kind, Precision, Seed, Space, Spec};

use super::document::{Document, State, StateKind};
use crate::Error;
use crate::problem::FormulaTask;

/// Start states the reward is tried at before anything runs.
const TRIED_REWARDS: usize = 100;

impl Document {
    /// The task with control intervals of `dt` \[s\]; states without a `start` begin at `rest` (n).
    pub(super) fn task(&self, dt: f64, rest: &[f64]) -> anyhow::Result<FormulaTask> {
        let start = self.state.iter().zip(rest);
        let start = start.map(|(state, &rest)| state.start.map_or((rest, rest), |[low, high]| (low, high)));
        let formulas = (self.task.reward.as_str(), self.task.terminated.as_deref());
        let task = FormulaTask::defined(self.spec(dt)?, self.max_steps, start.collect(), formulas, &self.defined()?);
        let task = task.map_err(|e| match e {
            Error::System { why, .. } => anyhow::anyhow!("task.{why}"),
            other => other.into(),
        })?;
        match task.try_reward(TRIED_REWARDS, &mut Seed::new(0).stream("reward on trial", 0)) {
            Ok(()) => Ok(task),
            Err(e) => bail!("task.reward must be a finite number wherever the system goes: {e}"),
        }
    }

    fn spec(&self, dt: f64) -> anyhow::Result<Spec> {
        let state: Vec<Channel> = self.state.iter().map(|s| self.channel(s)).collect::<Result<_, _>>()?;
        let control = self.control.iter().map(|c| {
            let scale = c.low.abs().max(c.high.abs());
            Channel::new(&c.name, &c.unit, Kind::Plain, scale).within(c.low, c.high)
        });
        let (low, high) = self.control.iter().map(|c| (c.low, c.high)).unzip();
        Ok(Spec {
            name: self.name.clone(),
            observation: self.observation(&state)?,
            state,
            control: control.collect(),
            action_space: Space::Box { low, high },
            precision: Precision::F64,
            noise: 0.0,
            dt,
        })
    }

    fn channel(&self, state: &State) -> anyhow::Result<Channel> {
        let kind = match (&state.rate_of, state.kind) {
            (Some(of), _) => Kind::RateOf(self.state_named(of)?),
            (None, StateKind::Angle) => Kind::Angle,
            (None, StateKind::Plain) => Kind::Plain,
        };
        let channel = Channel::new(&state.name, &state.unit, kind, state.scale);
        Ok(match state.bounds {
            Some([low, high]) => channel.within(low, high),
            None => channel,
        })
    }

    /// What the sensors show: what the file lists, or every state, angles that go round as cosine and sine.
    fn observation(&self, state: &[Channel]) -> anyhow::Result<Vec<Channel>> {
        let cosine = |i: usize| waving("cos", Kind::CosOf(i), &state[i]);
        let sine = |i: usize| waving("sin", Kind::SinOf(i), &state[i]);
        let Some(listed) = &self.observation else {
            let shown = state.iter().enumerate().flat_map(|(i, channel)| match channel.kind {
                Kind::Angle if !channel.is_bounded() => vec![cosine(i), sine(i)],
                _ => vec![channel.clone()],
            });
            return Ok(shown.collect());
        };
        let show = |text: &String| match text.split_once(' ') {
            Some(("cos", name)) => Ok(cosine(self.state_named(name)?)),
            Some(("sin", name)) => Ok(sine(self.state_named(name)?)),
            _ => anyhow::Ok(state[self.state_named(text)?].clone()),
        };
        let shown: Vec<Channel> = listed.iter().map(show).collect::<Result<_, _>>().context("observation")?;
        for (i, channel) in state.iter().enumerate() {
            let shows = |what: &Channel| shown.iter().any(|o| o.name == what.name);
            let (name, turned) = (&channel.name, shows(&cosine(i)) && shows(&sine(i)));
            ensure!(
                shows(channel) || turned,
                "observation does not show state `{name}`: equations are found for what is seen. List `{name}`, or \
                 both `cos {name}` and `sin {name}`"
            );
        }
        for (i, channel) in shown.iter().enumerate() {
            ensure!(!shown[..i].contains(channel), "observation lists `{}` twice", channel.name);
        }
        Ok(shown)
    }

    pub(super) fn state_named(&self, name: &str) -> anyhow::Result<usize> {
        self.state.iter().position(|s| s.name == name).with_context(|| {
            let known: Vec<_> = self.state.iter().map(|s| s.name.as_str()).collect();
            format!("no state named `{name}`; known: {}", known.join(", "))
        })
    }

    /// The variables of the reward: states, controls, states after the step, definitions before and after it.
    pub(super) fn names(&self) -> Vec<String> {
        let states = self.state.iter().map(|s| s.name.clone());
        let controls = self.control.iter().map(|c| c.name.clone());
        let after = self.state.iter().map(|s| format!("next_{}", s.name));
        let defined = self.definitions.keys().flat_map(|name| [name.clone(), format!("next_{name}")]);
        states.chain(controls).chain(after).chain(defined).collect()
    }
}

/// Cosine or sine of an angle as a channel.
fn waving(function: &str, kind: Kind, of: &Channel) -> Channel {
    Channel::new(&format!("{function} {}", of.name), "", kind, 1.0).within(-1.0, 1.0)
}
