//! MuJoCo's own steps from anywhere, beside those of a model.

use std::fs;
use std::path::Path;

use anyhow::Context as _;
use rand::RngExt as _;
use sindyna_bench::study::Result;
use sindyna_core::{Channel, Dynamics as _, Environment as _, Kind, Precision, Rng, Seed, Sensors, Space, Spec, Task};
use sindyna_mujoco::{Library, MujocoEnvironment, MujocoModel, Search, Tree};
use sindyna_sindy::Model;

/// States and controls at which steps are compared.
const PLACES: usize = 1_000;

/// Places from which it is tried what stays at rest.
const TRIES: usize = 20;

/// How far angles (rad), rates, and positions that have no wider range of start values are from zero, at most.
const ANGLE: f64 = 3.0;
const RATE: f64 = 3.0;
const POSITION: f64 = 0.5;

/// The system of a task file.
pub(crate) struct Truth {
    environment: MujocoEnvironment<Anywhere>,
    /// Ends of each state's range.
    ranges: Vec<(f64, f64)>,
    /// States that are rates.
    rates: Vec<usize>,
    controls: Vec<(f64, f64)>,
}

/// No task.
struct Anywhere(Spec);

impl Task for Anywhere {
    fn spec(&self) -> &Spec {
        &self.0
    }

    fn max_steps(&self) -> usize {
        usize::MAX
    }

    fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
        x.fill(0.0);
    }

    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
        0.0
    }

    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

impl Truth {
    /// Of the task file at `path`.
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let table: toml::Table = fs::read_to_string(path)?.parse()?;
        let list = |name: &str| table.get(name).and_then(toml::Value::as_array).cloned().unwrap_or_default();
        let number = |of: &toml::Value| of.as_float().or(of.as_integer().map(|i| i as f64));
        let (states, controls) = (list("state"), list("control"));
        let name = |of: &toml::Value| of.get("name").and_then(|n| n.as_str().map(str::to_owned)).unwrap_or_default();
        let rates: Vec<usize> = (0..states.len()).filter(|&i| states[i].get("rate_of").is_some()).collect();
        let range = |state: &toml::Value| {
            let start = state.get("start").context("a state without start values")?;
            let ends = match start.as_array() {
                Some(ends) => [0, 1].map(|i| ends.get(i).and_then(number)),
                // Normal ones are near their mean.
                None => [start.get("mean"), start.get("mean")].map(|mean| mean.and_then(number)),
            };
            let [Some(low), Some(high)] = ends else { anyhow::bail!("start values that are no numbers") };
            let is = |kind: &str| state.get("kind").and_then(toml::Value::as_str) == Some(kind);
            Ok(match () {
                () if state.get("rate_of").is_some() => (-RATE, RATE),
                () if is("angle") => (-ANGLE, ANGLE),
                () if high - low > 2.0 * POSITION => (low, high),
                // Where it never is elsewhere, as a target, or where it is not far from its start.
                () => (low.min(-POSITION), high.max(POSITION)),
            })
        };
        let ends = |control: &toml::Value| {
            let [Some(low), Some(high)] = ["low", "high"].map(|end| control.get(end).and_then(number)) else {
                anyhow::bail!("a control without limits")
            };
            Ok((low, high))
        };
        let mut ranges = states.iter().map(range).collect::<Result<Vec<_>>>()?;
        let ends = controls.iter().map(ends).collect::<Result<Vec<_>>>()?;
        let model = table.get("model").and_then(toml::Value::as_str).context("no model")?;
        let skip = table.get("frame_skip").and_then(toml::Value::as_integer).context("no frame_skip")? as usize;
        let library = Library::load(&Search::from_environment())?;
        let model = MujocoModel::from_file(&library, path.with_file_name(model))?;
        let plain = |of: &toml::Value| Channel::new(&name(of), "", Kind::Plain, 1.0);
        let state: Vec<Channel> = states.iter().map(plain).collect();
        let spec = Spec {
            name: "anywhere".into(),
            observation: state.clone(),
            state,
            control: controls.iter().map(plain).collect(),
            action_space: Space::Box {
                low: ends.iter().map(|e| e.0).collect(),
                high: ends.iter().map(|e| e.1).collect(),
            },
            precision: Precision::F64,
            noise: 0.0,
            dt: model.timestep() * skip as f64,
        };
        let sensors = Sensors::new(&spec).context("states are observed")?;
        // A joint meets its stops in no step that begins so far from them. Positions are the first states.
        let apart = RATE * model.timestep() * skip as f64;
        for joint in Tree::of(&model)?.joints {
            if let (Some((low, high)), Some(range)) = (joint.range, ranges.get_mut(joint.position)) {
                *range = (range.0.max(low + apart), range.1.min(high - apart));
            }
        }
        let environment = MujocoEnvironment::new(&model, skip, Anywhere(spec), sensors)?;
        Self { environment, ranges, rates, controls: ends }.with_targets_at_rest()
    }

    /// The same with no rates of what nothing sets in motion: from rest it stays at rest, under any controls.
    fn with_targets_at_rest(mut self) -> Result<Self> {
        let mut rng = Seed::new(0).stream("at rest", 0);
        let mut still = vec![true; self.ranges.len()];
        for _ in 0..TRIES {
            let (mut x, u) = self.place(&mut rng);
            self.rates.iter().for_each(|&i| x[i] = 0.0);
            self.environment.reset_to(&x, &mut rng)?;
            self.environment.step(&u, &mut rng)?;
            self.rates.iter().for_each(|&i| still[i] &= self.environment.state()[i] == 0.0);
        }
        self.rates.iter().filter(|&&i| still[i]).for_each(|&i| self.ranges[i] = (0.0, 0.0));
        Ok(self)
    }

    /// A state and controls.
    fn place(&self, rng: &mut Rng) -> (Vec<f64>, Vec<f64>) {
        let mut draw = |of: &[(f64, f64)]| of.iter().map(|&(low, high)| rng.random_range(low..=high)).collect();
        (draw(&self.ranges), draw(&self.controls))
    }

    /// The largest difference of what a step changes of a rate, as part of the standard deviation of that; `None` where the model diverges.
    pub(crate) fn deviation(mut self, model: &Model) -> Result<Option<f64>> {
        let mut rng = Seed::new(0).stream("places", 0);
        let mut both: Vec<Vec<(f64, f64)>> = vec![Vec::new(); self.rates.len()];
        for _ in 0..PLACES {
            let (x, u) = self.place(&mut rng);
            self.environment.reset_to(&x, &mut rng)?;
            self.environment.step(&u, &mut rng)?;
            let truth = self.environment.state().to_vec();
            let mut found = vec![0.0; x.len()];
            if model.step(&x, &u, &mut rng, &mut found).is_err() {
                return Ok(None);
            }
            for (both, &i) in both.iter_mut().zip(&self.rates) {
                both.push((truth[i] - x[i], found[i] - x[i]));
            }
        }
        let worst = |of: &Vec<(f64, f64)>| {
            let mean = of.iter().map(|(t, _)| t).sum::<f64>() / of.len() as f64;
            let spread = (of.iter().map(|(t, _)| (t - mean).powi(2)).sum::<f64>() / of.len() as f64).sqrt();
            let most = of.iter().map(|(t, f)| (t - f).abs()).fold(0.0, f64::max);
            if spread > 0.0 { most / spread } else { 0.0 }
        };
        Ok(Some(both.iter().map(worst).fold(0.0, f64::max)))
    }
}
