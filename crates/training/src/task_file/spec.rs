//! What a task file declares: channels, reward, end.

use anyhow::{Context as _, bail};
use sindyna_core::{Channel, Kind, Precision, Seed, Space, Spec};

use super::document::{Document, Normal, StartValue, State, StateKind};
use crate::Error;
use crate::problem::{FormulaTask, Names, Start};

/// Start states the reward is tried at before anything runs.
const TRIED_REWARDS: usize = 100;

impl Document {
    /// The task with control intervals of `dt` \[s\]; states without a `start` begin at `rest` (n).
    pub(super) fn task(&self, dt: f64, rest: &[f64]) -> anyhow::Result<FormulaTask> {
        let start = self.state.iter().zip(rest).map(|(state, &rest)| match state.start {
            None => Start::Uniform(rest, rest),
            Some(StartValue::Range([low, high])) => Start::Uniform(low, high),
            Some(StartValue::Normal(Normal { mean, std })) => Start::Normal(mean, std),
        });
        let start_if = self.task.start_if.as_deref();
        let formulas = (self.task.reward.as_str(), self.task.terminated.as_deref());
        let parameters: Vec<(String, f64)> = self.numbers().collect();
        let names = Names { definitions: &self.defined()?, parameters: &parameters };
        let task = FormulaTask::defined(self.spec(dt)?, self.max_steps, (start.collect(), start_if), formulas, names);
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
            observation: self.observed(&state)?.channels,
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
            (None, Some(StateKind::Angle)) => Kind::Angle,
            (None, Some(StateKind::Plain) | None) => Kind::Plain,
        };
        let channel = Channel::new(&state.name, &state.unit, kind, state.scale);
        Ok(match state.bounds {
            Some([low, high]) => channel.within(low, high),
            None => channel,
        })
    }

    pub(super) fn state_named(&self, name: &str) -> anyhow::Result<usize> {
        self.state.iter().position(|s| s.name == name).with_context(|| {
            let known: Vec<_> = self.state.iter().map(|s| s.name.as_str()).collect();
            format!("no state named `{name}`; known: {}", known.join(", "))
        })
    }

    /// The variables of the reward: states, controls, states after the step, definitions before and after it, parameters.
    pub(super) fn names(&self) -> Vec<String> {
        let states = self.state.iter().map(|s| s.name.clone());
        let controls = self.control.iter().map(|c| c.name.clone());
        let after = self.state.iter().map(|s| format!("next_{}", s.name));
        let defined = self.definitions.keys().flat_map(|name| [name.clone(), format!("next_{name}")]);
        states.chain(controls).chain(after).chain(defined).chain(self.parameters.keys().cloned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use sindyna_core::Seed;

    use super::super::TaskFile;
    use crate::problem::Problem as _;

    /// A task file whose state begins as `start` says.
    fn file(start: &str, start_if: &str) -> anyhow::Result<TaskFile> {
        let text = format!(
            "name = \"point\"\nmax_steps = 10\ndt = 0.1\n[equations]\nx = \"u\"\n[parameters]\nr = 0.5\n[[state]]\nname = \"x\"\nstart = {start}\n\
             bounds = [-3.0, 3.0]\n[[control]]\nname = \"u\"\nlow = -1.0\nhigh = 1.0\n[task]\nreward = \"-x^2\"\nstart_if = \"{start_if}\"\n"
        );
        TaskFile::read(Path::new("point.toml"), text, None)
    }

    #[test]
    fn start_states_are_drawn_as_the_file_says() {
        let task = file("{ mean = 1.0, std = 0.2 }", "x > 2*r").unwrap().task();
        let (mut rng, mut x, mut sum) = (Seed::new(2).numpy(), [0.0], 0.0);
        for _ in 0..4_000 {
            task.initial(&mut rng, &mut x);
            assert!(x[0] > 1.0);
            sum += x[0] - 1.0;
        }
        // The mean of half a normal distribution, σ √(2/π); standard error 0.002.
        let mean = sum / 4_000.0;
        assert!((mean - 0.2 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 0.01, "{mean}");
    }

    #[test]
    fn start_states_that_cannot_be_are_refused() {
        for (start, start_if, says) in [
            (
                "[0.0, 1.0]",
                "x > 2",
                "task.start_if: 0.0 % of the sampled start states are within bounds and satisfy it",
            ),
            ("[0.0, 1.0]", "y > 2", "start_if, a condition on the start state"),
            ("{ mean = 9.0, std = 0.1 }", "x > 0", "task.start_if: 0.0 % of the sampled start states"),
            ("{ mean = 0.0, std = -1.0 }", "x > 0", "state `x`: std of start must be finite and ≥ 0, got -1"),
            ("{ mean = 0.0 }", "x > 0", "start must be [low, high] or { mean = …, std = … }"),
            ("3.0", "x > 0", "start must be [low, high] or { mean = …, std = … }"),
        ] {
            let refusal = format!("{:#}", file(start, start_if).err().unwrap());
            assert!(refusal.contains(says), "{start}: {refusal}");
        }
    }
}
