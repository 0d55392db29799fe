//! Task files: any MJCF model with observations, reward, end and limits given in TOML (`docs/task-files.md`).

mod document;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, bail, ensure};
use sindyna_core::{Channel, Environment, Kind, Precision, Seed, Sensors, Space, Spec, Task};
use sindyna_mujoco::{Library, MujocoEnvironment, MujocoModel, Search};
use sindyna_sindy::{Expr, parse};

use crate::Error;
use crate::problem::{FormulaTask, Problem};
use document::{Document, State, StateKind};
use sindyna_logs::closes_circle;

/// Name of the task file in a run directory.
pub(crate) const RECORDED_TASK: &str = "task.toml";
/// Name of its model there.
const RECORDED_MODEL: &str = "model.xml";
/// Steps of the simulation in one control interval.
const MOST_FRAMES: usize = 100_000;
/// Steps of an episode.
const MOST_STEPS: usize = 10_000_000;
/// The largest number for scales, starts and limits: widths of ranges, and squares, are finite too.
const LARGEST: f64 = 1e150;
/// Start states the reward is tried at before anything runs.
const TRIED_REWARDS: usize = 100;

/// A task read from a file, with its model compiled.
#[derive(Clone)]
pub(crate) struct TaskFile {
    task: Arc<FormulaTask>,
    sensors: Sensors,
    library: Library,
    model: MujocoModel,
    frame_skip: usize,
    source: Source,
}

/// What the task was read from.
#[derive(Clone)]
struct Source {
    text: String,
    /// Where in `text` the model is named, quotes included.
    model_name: Range<usize>,
    model_path: PathBuf,
    model_text: Vec<u8>,
}

impl TaskFile {
    /// Reads the task file at `path` and the model it names, and finds MuJoCo for it.
    pub(crate) fn load(path: &Path) -> Result<Self, Error> {
        let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()));
        let wrong = |e: anyhow::Error| Error::TaskFile { path: path.to_owned(), source: e.into() };
        text.and_then(|text| Self::read(path, text)).map_err(wrong)
    }

    fn read(path: &Path, text: String) -> anyhow::Result<Self> {
        let document: Document = toml::from_str(&text)?;
        document.check()?;
        let model_path = path.parent().unwrap_or(Path::new("")).join(document.model.get_ref());
        let model_text =
            fs::read(&model_path).with_context(|| format!("cannot read its model {}", model_path.display()))?;
        let library = Library::load(&Search::from_environment())?;
        let model = MujocoModel::from_file(&library, &model_path)?;
        document.check_model(&model)?;
        let task = document.task(&model)?;
        let sensors = Sensors::new(&task.spec).expect("every observation was made for a state");
        let (model_name, frame_skip) = (document.model.span(), document.frame_skip);
        let source = Source { text, model_name, model_path, model_text };
        Ok(Self { task: Arc::new(task), sensors, library, model, frame_skip, source })
    }

    /// The same with noise on its sensors: `fraction` of every observation channel's scale.
    pub(crate) fn with_noise(mut self, fraction: f64) -> Self {
        Arc::make_mut(&mut self.task).spec.noise = fraction;
        self.sensors = Sensors::new(&self.task.spec).expect("noise changes no channel");
        self
    }

    /// The task and its model as files of a run directory, where they are enough to run it again.
    ///
    /// A model that needs other files (meshes, included models) does not compile there; the record then names the
    /// original.
    fn recorded(&self) -> anyhow::Result<Vec<(&'static str, Vec<u8>)>> {
        let Source { text, model_name, model_path, model_text } = &self.source;
        let apart = tempfile::tempdir().context("cannot make a temporary directory")?;
        let copy = apart.path().join(RECORDED_MODEL);
        fs::write(&copy, model_text).with_context(|| format!("cannot write {}", copy.display()))?;
        let model = match MujocoModel::from_file(&self.library, &copy) {
            Ok(_) => RECORDED_MODEL.into(),
            Err(_) => std::path::absolute(model_path)?.display().to_string(),
        };
        let mut text = text.clone();
        text.replace_range(model_name.clone(), &toml::Value::String(model).to_string());
        Ok(vec![(RECORDED_MODEL, model_text.clone()), (RECORDED_TASK, text.into_bytes())])
    }
}

impl Problem for TaskFile {
    fn spec(&self) -> &Spec {
        &self.task.spec
    }

    fn task(&self) -> Arc<dyn Task> {
        self.task.clone()
    }

    fn sensors(&self) -> Sensors {
        self.sensors.clone()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        Ok(Box::new(MujocoEnvironment::new(&self.model, self.frame_skip, self.task(), self.sensors())?))
    }

    fn check(&self) -> Result<(), Error> {
        match self.task.complaint() {
            None => Ok(()),
            Some(complaint) => Err(Error::Reward { complaint: complaint.to_owned() }),
        }
    }

    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        let wrong = |e: anyhow::Error| Error::TaskFile { path: self.source.model_path.clone(), source: e.into() };
        self.recorded().map_err(wrong)
    }
}

impl Document {
    /// Refuses values no task can have.
    fn check(&self) -> anyhow::Result<()> {
        let plain = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        let name = &self.name;
        ensure!(!name.is_empty() && name.chars().all(plain), "name must be letters, digits, `-` and `_`, got `{name}`");
        for (name, value, most) in
            [("frame_skip", self.frame_skip, MOST_FRAMES), ("max_steps", self.max_steps, MOST_STEPS)]
        {
            ensure!((1..=most).contains(&value), "{name} must be between 1 and {most}, got {value}");
        }
        ensure!(!self.state.is_empty(), "there is no [[state]]");
        ensure!(!self.control.is_empty(), "there is no [[control]]: nothing could be trained");
        if let Some(mark) = self.solved_at {
            ensure!(mark.is_finite(), "solved_at must be finite, got {mark}");
        }
        self.check_names()?;
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
            if let Some([low, high]) = start {
                let right = low <= high && low.is_finite() && high.is_finite();
                ensure!(right, "state `{name}`: start must be [low, high], got [{low}, {high}]");
                near(format!("state `{name}`: start"), low.abs().max(high.abs()))?;
            }
            if let Some([low, high]) = bounds {
                ensure!(low < high, "state `{name}`: bounds must be [low, high], got [{low}, {high}]");
                if let Some([from, to]) = start {
                    let inside = low <= from && to <= high;
                    ensure!(inside, "state `{name}`: start [{from}, {to}] is not within bounds [{low}, {high}]");
                }
            }
            if let Some(of) = rate_of {
                let pair = (
                    self.state_named(name)?,
                    self.state_named(of).with_context(|| format!("state `{name}`: rate_of"))?,
                );
                ensure!(!closes_circle(&rates, pair), "state `{name}` cannot be its own rate, nor by way of others");
                rates.push(pair);
                ensure!(*kind == StateKind::Plain, "state `{name}` cannot be both an angle and a rate");
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
            ensure!(free, "`{name}` is no name for formulas: letters, digits and `_`, not beginning with a digit");
            ensure!(
                !names[..i].contains(name),
                "the name `{name}` is there twice (`next_` begins the state after a step)"
            );
        }
        Ok(())
    }

    /// Refuses a model that has other states or controls than are declared.
    fn check_model(&self, model: &MujocoModel) -> anyhow::Result<()> {
        let (nq, nv, nu) = (model.position_dim(), model.velocity_dim(), model.control_dim());
        let (states, controls) = (self.state.len(), self.control.len());
        let needed = nq + nv;
        ensure!(
            states == needed,
            "its model has {nq} positions and {nv} velocities and needs {needed} [[state]] tables in that order, got \
             {states}"
        );
        ensure!(controls == nu, "its model has {nu} actuators and needs {nu} [[control]] tables, got {controls}");
        Ok(())
    }

    fn task(&self, model: &MujocoModel) -> anyhow::Result<FormulaTask> {
        let start = self.state.iter().zip(model.rest());
        let start = start.map(|(state, &rest)| state.start.map_or((rest, rest), |[low, high]| (low, high)));
        let task =
            FormulaTask::new(self.spec(model)?, start.collect(), &self.task.reward, self.task.terminated.as_deref())
                .map_err(|e| match e {
                    Error::System { why, .. } => anyhow::anyhow!("task.{why}"),
                    other => other.into(),
                })?;
        task.try_reward(TRIED_REWARDS, &mut Seed::new(0).stream("reward on trial", 0));
        match task.complaint() {
            None => Ok(task),
            Some(complaint) => bail!("task.reward must be a finite number wherever the system goes: {complaint}"),
        }
    }

    fn spec(&self, model: &MujocoModel) -> anyhow::Result<Spec> {
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
            dt: self.frame_skip as f64 * model.timestep(),
            max_steps: self.max_steps,
            solved_at: self.solved_at,
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

    fn state_named(&self, name: &str) -> anyhow::Result<usize> {
        self.state.iter().position(|s| s.name == name).with_context(|| {
            let known: Vec<_> = self.state.iter().map(|s| s.name.as_str()).collect();
            format!("no state named `{name}`; known: {}", known.join(", "))
        })
    }

    /// The variables of the reward: states, controls, states after the step.
    fn names(&self) -> Vec<String> {
        let states = self.state.iter().map(|s| s.name.clone());
        let controls = self.control.iter().map(|c| c.name.clone());
        let after = self.state.iter().map(|s| format!("next_{}", s.name));
        states.chain(controls).chain(after).collect()
    }
}

/// Cosine or sine of an angle as a channel.
fn waving(function: &str, kind: Kind, of: &Channel) -> Channel {
    Channel::new(&format!("{function} {}", of.name), "", kind, 1.0).within(-1.0, 1.0)
}
