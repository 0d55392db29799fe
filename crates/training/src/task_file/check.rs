//! What a task file must be before anything is made of it.

use anyhow::{Context as _, ensure};
use sindyna_logs::closes_circle;
use sindyna_sindy::{Expr, parse};

use super::document::{self, Document, Normal, StartValue, State, StateKind};

/// Steps of the simulation in one control interval.
const MOST_FRAMES: usize = 100_000;
/// Steps of an episode.
const MOST_STEPS: usize = 10_000_000;
/// The largest number for scales, starts and limits: widths of ranges, and squares, are finite too.
const LARGEST: f64 = 1e150;

impl Document {
    /// Refuses values no task can have.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let plain = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        let name = &self.name;
        ensure!(!name.is_empty() && name.chars().all(plain), "name must be letters, digits, `-` and `_`, got `{name}`");
        let frames = self.frame_skip.unwrap_or(1);
        for (name, value, most) in [("frame_skip", frames, MOST_FRAMES), ("max_steps", self.max_steps, MOST_STEPS)] {
            ensure!((1..=most).contains(&value), "{name} must be between 1 and {most}, got {value}");
        }
        self.check_simulator()?;
        ensure!(!self.state.is_empty(), "there is no [[state]]");
        ensure!(!self.control.is_empty(), "there is no [[control]], so there is nothing to train");
        if let Some(mark) = self.solved_at {
            ensure!(mark.is_finite(), "solved_at must be finite, got {mark}");
        }
        self.check_names()?;
        self.check_places()?;
        for (name, value) in self.numbers() {
            ensure!(value.is_finite(), "parameter `{name}` must be finite, got {value}");
        }
        let mut rates = Vec::new();
        let near = |what: String, value: f64| {
            ensure!(value.abs() <= LARGEST, "{what} must be at most {LARGEST:e} in magnitude, got {value:e}");
            Ok(())
        };
        for State { name, scale, start, bounds, kind, rate_of, .. } in &self.state {
            ensure!(*scale > 0.0 && scale.is_finite(), "state `{name}`: scale must be finite and > 0, got {scale}");
            near(format!("state `{name}`: scale"), *scale)?;
            for end in bounds.iter().flatten().filter(|end| end.is_finite()) {
                near(format!("state `{name}`: bounds"), *end)?;
            }
            if let Some(StartValue::Normal(Normal { mean, std })) = start {
                ensure!(
                    *std >= 0.0 && std.is_finite(),
                    "state `{name}`: std of start must be finite and ≥ 0, got {std}"
                );
                near(format!("state `{name}`: start"), mean.abs().max(*std))?;
            }
            if let Some(StartValue::Range([low, high])) = start {
                let right = low <= high && low.is_finite() && high.is_finite();
                ensure!(right, "state `{name}`: start must be [low, high], got [{low}, {high}]");
                near(format!("state `{name}`: start"), low.abs().max(high.abs()))?;
            }
            if let Some([low, high]) = bounds {
                ensure!(low < high, "state `{name}`: bounds must be [low, high], got [{low}, {high}]");
                if let Some(StartValue::Range([from, to])) = start {
                    let inside = low <= from && to <= high;
                    ensure!(inside, "state `{name}`: start [{from}, {to}] is not within bounds [{low}, {high}]");
                }
            }
            if let Some(of) = rate_of {
                let pair = (
                    self.state_named(name)?,
                    self.state_named(of).with_context(|| format!("state `{name}`: rate_of"))?,
                );
                ensure!(!closes_circle(&rates, pair), "the rates of states form a circle at `{name}`");
                rates.push(pair);
                ensure!(*kind != Some(StateKind::Angle), "state `{name}` cannot be both an angle and a rate");
            }
        }
        for document::Control { name, low, high, .. } in &self.control {
            let right = low < high && low.is_finite() && high.is_finite();
            ensure!(right, "control `{name}`: low must be below high, both finite; got {low} and {high}");
            near(format!("control `{name}`: low and high"), low.abs().max(high.abs()))?;
        }
        Ok(())
    }

    /// Every name must be one that formulas can use, and stand for one thing.
    fn check_names(&self) -> anyhow::Result<()> {
        let names = self.names();
        for (i, name) in names.iter().enumerate() {
            let symbol = parse(name, std::slice::from_ref(name)) == Ok(Expr::Variable(0));
            let free = symbol && name.trim() == name && !["and", "or"].contains(&name.as_str());
            ensure!(free, "`{name}` is not a valid name: letters, digits and `_`, not beginning with a digit");
            ensure!(
                !names[..i].contains(name),
                "the name `{name}` is used twice (`next_` begins the state after a step)"
            );
        }
        Ok(())
    }

    /// Sites and bodies are those of a model, and stand in definitions.
    fn check_places(&self) -> anyhow::Result<()> {
        let holds = |text: &String| text.contains("site(\"") || text.contains("body(\"");
        let defined = self.definitions.values().any(holds);
        ensure!(!defined || self.model.is_some(), "site() and body() are places of a `model`, and there is none");
        let task = [Some(&self.task.reward), self.task.terminated.as_ref(), self.task.start_if.as_ref()];
        let others = self.observation.iter().flatten().chain(self.equations.iter().flat_map(|all| all.values()));
        let elsewhere = task.into_iter().flatten().chain(others).find(|text| holds(text));
        ensure!(
            elsewhere.is_none(),
            "site() and body() are allowed in [let] only: give the coordinate in `{}` a name there",
            elsewhere.map_or("", String::as_str)
        );
        Ok(())
    }

    /// A simulator is an MJCF model with its `frame_skip`, or equations with `dt`, or none: then the data are a log.
    fn check_simulator(&self) -> anyhow::Result<()> {
        if let Some(dt) = self.dt {
            ensure!(dt > 0.0 && dt.is_finite(), "dt must be finite and above 0, got {dt}");
        }
        let (model, equations) = (self.model.is_some(), self.equations.is_some());
        ensure!(!(model && equations), "`model` and [equations] exclude each other");
        ensure!(
            !model || self.frame_skip.is_some(),
            "a `model` needs a `frame_skip`: its steps in one control interval"
        );
        ensure!(
            !model || self.dt.is_none(),
            "the control interval of a `model` is `frame_skip` of its steps: leave `dt` out"
        );
        ensure!(model || self.frame_skip.is_none(), "`frame_skip` requires a `model`");
        ensure!(!equations || self.dt.is_some(), "[equations] need `dt`: the seconds of one control interval");
        Ok(())
    }
}
