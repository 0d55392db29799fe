//! A task on a system of which there is nothing but a log.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sindyna_core::{Dataset, Environment, Kind, Observe as _, Precision, Protocol, Seed, Sensors, Spec, Task};
use sindyna_logs::{Clock, Log, LogOptions};
use sindyna_record::run::log_csv;
use sindyna_sindy::Identified;

use super::{Played, Problem};
use crate::Error;
use crate::known::identified_of;
use crate::task_file::TaskFile;

/// Name of the log in a run directory, and in that of an identification.
pub const RECORDED_LOG: &str = "data.csv";

/// Name of what was identified in it, in a run directory and in that of an identification.
pub const RECORDED_MODELS: &str = "posterior.bin";

/// What is known of a log besides its rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Sampling interval \[s\].
    pub dt: f64,
    /// How finely the states were recorded.
    pub precision: Precision,
}

/// Where a log is, and what was identified in it if that is known.
#[derive(Debug, Clone, PartialEq)]
pub struct LogSource {
    /// The log.
    pub log: PathBuf,
    /// `None` for what the log shows.
    pub sampling: Option<Sampling>,
    /// What was identified in it; `None` where nothing was.
    pub models: Option<PathBuf>,
}

/// A task on a system of which there is nothing but a log.
pub(super) struct Recorded {
    task: TaskFile,
    log: Log,
    /// The log as the sensors of the task show it, with the rewards of the task.
    data: Arc<Dataset>,
    models: Option<(Vec<u8>, Identified)>,
}

impl Recorded {
    /// The task file at `path` on what `source` names. Columns of the log are called as the states and controls of the task.
    pub(super) fn load(path: &Path, source: &LogSource) -> Result<Self, Error> {
        // Names are declared whatever the control interval is.
        let declared = TaskFile::load(path, Some(1.0))?;
        let given = declared.dt();
        let refused = |why: String| Error::System { name: declared.spec().name.clone(), why };
        if declared.has_simulator() {
            return Err(refused(
                "its task file has a simulator, and the data are a log: they are one or the other".into(),
            ));
        }
        let log = read(declared.spec(), source, given)?;
        let dt = given.unwrap_or(log.spec.dt);
        if (dt / log.spec.dt - 1.0).abs() > 1e-6 {
            return Err(refused(format!("its `dt` is {dt} s, a step of the log is {} s", log.spec.dt)));
        }
        let task = TaskFile::load(path, Some(log.spec.dt))?.with_precision(log.spec.precision);
        if log.times.is_some() && source.models.is_none() {
            return Err(refused(format!(
                "the samples of {} are not evenly spaced: identify it first, and train with the model",
                source.log.display()
            )));
        }
        let data = Arc::new(seen(&log, task.spec(), &*task.task(), &task.sensors())?);
        let models = match &source.models {
            None => None,
            Some(path) => {
                let bytes = std::fs::read(path).map_err(|e| refused(format!("cannot read {}: {e}", path.display())))?;
                let identified = identified_of(&bytes).map_err(|why| refused(format!("{}: {why}", path.display())))?;
                same_signals(&identified, task.spec())?;
                Some((bytes, identified))
            }
        };
        Ok(Self { task, log, data, models })
    }
}

/// Reads the log that `source` names, with columns as `spec` declares states and controls.
fn read(spec: &Spec, source: &LogSource, dt: Option<f64>) -> Result<Log, Error> {
    let names = |is: &dyn Fn(Kind) -> bool| {
        spec.state.iter().filter(|c| is(c.kind)).map(|c| c.name.clone()).collect::<Vec<_>>()
    };
    let rates = spec.state.iter().filter_map(|c| match c.kind {
        Kind::RateOf(of) => Some((c.name.clone(), spec.state[of].name.clone())),
        _ => None,
    });
    let mut options = LogOptions::new(names(&|_| true)).with_inputs(spec.control.iter().map(|c| c.name.clone()));
    options.angles = Some(names(&|kind| kind == Kind::Angle));
    options.rates = Some(rates.collect());
    options.circles = Some(Vec::new());
    if let Some(Sampling { dt, precision }) = source.sampling {
        (options.clock, options.precision) = (Clock::Given(dt), Some(precision));
    }
    match (Log::read(&source.log, &options), dt) {
        (Err(sindyna_logs::LogError::NoTime { .. }), Some(dt)) => {
            options.clock = Clock::Given(dt);
            Ok(Log::read(&source.log, &options)?)
        }
        (log, _) => Ok(log?),
    }
}

/// The data of `log` as `sensors` show its states, with the rewards of `task`.
fn seen(log: &Log, spec: &Spec, task: &dyn Task, sensors: &Sensors) -> Result<Dataset, Error> {
    let refused = |why: String| Error::System { name: spec.name.clone(), why };
    let (sensors, mut rng) = (sensors.without_noise(), Seed::new(0).stream("a log", 0));
    let (m, k) = (spec.observation_dim(), spec.control_dim());
    let mut data = Dataset::new(m, k, k, log.spec.dt);
    let mut observation = vec![0.0; m];
    for rollout in log.data.rollouts() {
        let states: Vec<Vec<f64>> = rollout.observations.rows().into_iter().map(|row| row.to_vec()).collect();
        for (i, state) in states.iter().enumerate() {
            sensors.observe(state, &mut rng, &mut observation);
            let broken = |e: sindyna_core::DatasetError| refused(format!("the log cannot be seen: {e}"));
            let Some(before) = i.checked_sub(1) else {
                data.begin(&observation).map_err(broken)?;
                continue;
            };
            let u = rollout.controls.row(before).to_vec();
            if let Some((channel, value)) =
                spec.control.iter().zip(&u).find(|(c, v)| **v < c.prior.bounds.0 || **v > c.prior.bounds.1)
            {
                let (low, high) = channel.prior.bounds;
                let name = &channel.name;
                return Err(refused(format!(
                    "the log has {name} = {value}, its task file lets `{name}` go from {low} to {high}"
                )));
            }
            let reward = task.reward(&states[before], &u, &u, state);
            data.push(&u, &u, reward, &observation).map_err(broken)?;
        }
    }
    Ok(data)
}

/// Refuses models of other states or inputs than the task declares.
fn same_signals(identified: &Identified, spec: &Spec) -> Result<(), Error> {
    let names = |channels: &[sindyna_core::Channel]| channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    for (what, theirs, ours) in [
        ("states", identified.model.states(), names(&spec.state)),
        ("inputs", identified.model.controls(), names(&spec.control)),
    ] {
        if theirs != ours {
            let why = format!("its {what} are {}, those of the model {}", ours.join(", "), theirs.join(", "));
            return Err(Error::System { name: spec.name.clone(), why });
        }
    }
    Ok(())
}

impl Problem for Recorded {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn protocol(&self) -> Protocol {
        self.task.protocol()
    }

    fn task(&self) -> Arc<dyn Task> {
        self.task.task()
    }

    fn sensors(&self) -> Sensors {
        self.task.sensors()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        Ok(Box::new(Played::new(self.spec().clone(), self.data.clone(), None)))
    }

    fn copies(&self) -> usize {
        1
    }

    fn log(&self) -> Option<&Dataset> {
        Some(&self.data)
    }

    fn identified(&self) -> Option<&Identified> {
        self.models.as_ref().map(|(_, identified)| identified)
    }

    fn check(&self) -> Result<(), Error> {
        self.task.check()
    }

    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        let mut files = self.task.files()?;
        files.push((RECORDED_LOG, log_csv(&self.log.spec, &self.log.data, self.log.times.as_deref())?));
        files.extend(self.models.as_ref().map(|(bytes, _)| (RECORDED_MODELS, bytes.clone())));
        Ok(files)
    }
}
