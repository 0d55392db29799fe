//! A task on a system of which there is nothing but a log.

use std::path::Path;
use std::sync::Arc;

use ndarray::{Axis, s};
use sindyna_core::number::significant;
use sindyna_core::{Channel, Dataset, Environment, Observe as _, Protocol, Seed, Sensors, Spec, Task};
use sindyna_logs::{Clock, Log, LogError, LogOptions, Note};
use sindyna_sindy::{Form, Identified, Model};

use super::actuators::{self, commanded};
use super::late::LatePlant;
use super::log_source::{Contents, LogSource, columns};
use super::{Late, OwnSystem, Played, Problem};
use crate::Error;
use crate::task_file::TaskFile;

/// Part by which a control interval may be shorter than the median interval of samples that are not evenly spaced.
const SHORTER: f64 = 1e-3;

/// A task on a system of which there is nothing but a log, and what was identified in it.
pub(super) struct Recorded {
    task: TaskFile,
    /// The log as the sensors of the task show it, with the rewards of the task.
    data: Arc<Dataset>,
    identified: Identified,
    /// Sampling interval of the log \[s\].
    dt: f64,
    /// Time after which its inputs begin to act \[s\].
    delay: f64,
    /// Time constant of the lag through which they act \[s\]; 0 for none.
    lag: f64,
    /// The log and what was identified in it, as files.
    files: [(&'static str, Vec<u8>); 2],
}

impl Recorded {
    /// The task file at `path` on what `source` has. Columns of the log are called as the states and controls of the task.
    pub(super) fn load(path: &Path, source: &LogSource) -> Result<Self, Error> {
        let Read { task, log, times, identified, files } = Read::of(path, source, source)?;
        let (own, of_log) = (task.spec().dt, source.dt());
        let refused = |why: String| Error::System { name: task.spec().name.clone(), why };
        let broken = |e: sindyna_core::DatasetError| refused(format!("the log cannot be used: {e}"));
        let log = if source.lag() > 0.0 { commanded(&log, source.lag()).map_err(broken)? } else { log };
        let data = seen(&log, times, task.spec(), &*task.task(), &task.sensors())?;
        if data.n_steps() == 0 {
            return Err(refused(format!("its `dt` is {own} s, and no trajectory of the log is as long")));
        }
        let data = Arc::new(data);
        Ok(Self { task, data, identified, dt: of_log, delay: source.delay(), lag: source.lag(), files })
    }
}

/// A task, and what is known of its system.
struct Read {
    task: TaskFile,
    /// The log as it was identified, so many steps of which are a control interval.
    log: Dataset,
    times: usize,
    identified: Identified,
    files: [(&'static str, Vec<u8>); 2],
}

impl Read {
    /// The task file at `path` for a policy that knows `own`, on what `source` has.
    fn of(path: &Path, source: &LogSource, own: &LogSource) -> Result<Self, Error> {
        let task = of(path, own, source.dt())?;
        let name = task.spec().name.clone();
        let refused = |why: String| Error::System { name: name.clone(), why };
        let (interval, of_log) = (task.spec().dt, source.dt());
        let times = (interval / of_log).round().max(1.0);
        let task = task.with_precision(source.precision());
        // No column shows what actuators deliver.
        let measured = Spec { state: measured(&task, own).to_vec(), ..task.spec().clone() };
        let Contents { log, identified, files } = source.read(&measured, interval / times)?;
        if interval < of_log * (1.0 - SHORTER) || (interval / (times * log.spec.dt) - 1.0).abs() > 1e-6 {
            return Err(refused(format!(
                "its `dt` is {interval} s, which is no multiple of the sampling interval of the log, {of_log} s"
            )));
        }
        let says_nothing = |why: &str| refused(format!("its `dt` is {interval} s, and the equations {why}"));
        let is_continuous = matches!(identified.model.form(), Form::Continuous(_));
        if Late::of((source.delay(), source.lag()), interval).is_within() && !is_continuous {
            return Err(says_nothing(&format!(
                "are not continuous in time: of inputs that act {} s late they say nothing",
                significant(source.delay(), 6)
            )));
        }
        let identified = if source.lag() > 0.0 {
            let lagged = identified.with_actuators(source.lag(), &actuators::names(&measured));
            lagged
                .ok_or_else(|| says_nothing("are not stepped by Runge–Kutta: of inputs with a lag they say nothing"))?
        } else {
            identified
        };
        let identified = identified.over_intervals(interval).ok_or_else(|| {
            says_nothing(&format!("say nothing but what follows after the sampling interval of the log, {of_log} s"))
        })?;
        Ok(Self { task, log: log.data, times: times as usize, identified, files })
    }
}

/// The states of `task`, for a policy that knows `own`, that were measured.
fn measured<'a>(task: &'a TaskFile, own: &LogSource) -> &'a [Channel] {
    let actuators = if own.lag() > 0.0 { task.spec().control_dim() } else { 0 };
    &task.spec().state[..task.spec().state_dim() - actuators]
}

/// The task file at `path` for a policy that knows `own`, and the system that moves as what was identified from other logs, `source`.
pub(super) fn on_twin(path: &Path, source: &LogSource, own: &LogSource) -> Result<(TaskFile, LatePlant), Error> {
    let Read { task, identified, .. } = Read::of(path, source, own)?;
    let late = Late::of((source.delay(), source.lag()), task.spec().dt);
    let plant = LatePlant::new(Arc::new(identified.model), late, task.spec().state_dim());
    Ok((task, plant))
}

/// What the file at `path` declares of a task on what `source` has, with control intervals of `dt` \[s\] if it tells none. States of which it does not say what they are and by whole turns of which the equations found in the
/// log are not changed are angles; what actuators deliver are the last ones.
pub(super) fn of(path: &Path, source: &LogSource, dt: f64) -> Result<TaskFile, Error> {
    let file = without_simulator(path, Some(dt))?;
    let angles = source.angles_among(file.open())?;
    let actuators = if source.lag() > 0.0 { actuators::names(file.spec()) } else { Vec::new() };
    let file =
        if actuators.is_empty() { file.with_angles(&angles)? } else { file.with_actuators(&angles, &actuators)? };
    Ok(file.with_precision(source.precision()))
}

/// What the task file at `path` declares, whatever its system is; `dt` \[s\] is the control interval where it tells none.
///
/// # Errors
/// [`Error::TaskFile`] if it describes no task.
pub fn declared(path: &Path, dt: f64) -> Result<Arc<dyn Problem>, Error> {
    Ok(Arc::new(TaskFile::load(path, Some(dt))?))
}

/// The logs at `paths` as those of the task in the file `task_file`: its states and controls are columns. States that are rates of others need be none: these are told
/// too, as (rate, state). `options` say how cells and time stamps are read.
///
/// # Errors
/// [`Error::Log`] if a log cannot be read so, [`Error::System`] if the task has a simulator.
pub fn read_logs<P: AsRef<Path>>(
    task_file: &Path,
    paths: &[P],
    options: LogOptions,
) -> Result<(Log, Vec<(String, String)>), Error> {
    let task = without_simulator(task_file, Some(1.0))?;
    let (mut options, mut unmeasured) = (columns(task.spec(), options), Vec::new());
    if !task.declares_kinds() {
        options.angles = None;
    }
    loop {
        match (Log::read_all(paths, &options), task.dt()) {
            (Err(LogError::NoTime { .. }), Some(dt)) => options.clock = Clock::Given(dt),
            (Err(LogError::UnknownColumn { column, .. }), _) if has_rate(&options, &column) => {
                unmeasured.extend(take_rate(&mut options, &column));
            }
            (log, _) => return Ok((in_units_of(task.spec(), log?)?, unmeasured)),
        }
    }
}

/// `log`, if none of its columns was turned into radians that the task of `spec` declares in what they were in.
fn in_units_of(spec: &Spec, log: Log) -> Result<Log, Error> {
    let declared = |column: &str, unit: &str| {
        spec.state.iter().chain(&spec.control).any(|channel| channel.name == column && channel.unit == unit)
    };
    let mut radians = log.notes.iter().filter_map(|note| match note {
        Note::Radians { column, unit } => Some((column, unit)),
        _ => None,
    });
    if let Some((column, unit)) = radians.find(|(column, unit)| declared(column, unit)) {
        let why = format!(
            "the task declares {column} in {unit}, but angles of logs are read in radians; declare it in radians, with its bounds"
        );
        return Err(Error::System { name: spec.name.clone(), why });
    }
    Ok(log)
}

/// Whether `column` is the rate of another state.
fn has_rate(options: &LogOptions, column: &str) -> bool {
    options.rates.iter().flatten().any(|(rate, _)| rate == column)
}

/// Takes the state `column` and what it is the rate of out of `options`.
fn take_rate(options: &mut LogOptions, column: &str) -> Vec<(String, String)> {
    options.states.retain(|state| state != column);
    options.limits.retain(|(state, ..)| state != column);
    let (taken, kept) = options.rates.take().unwrap_or_default().into_iter().partition(|(rate, _)| rate == column);
    options.rates = Some(kept);
    taken
}

/// The task file at `path`, which must have no simulator.
fn without_simulator(path: &Path, dt: Option<f64>) -> Result<TaskFile, Error> {
    let file = TaskFile::load(path, dt)?;
    if file.has_simulator() {
        let why = "its task file has a simulator, so the data cannot be a log".into();
        return Err(Error::System { name: file.spec().name.clone(), why });
    }
    Ok(file)
}

/// The data of `log` as `sensors` show its states after each `times` of its steps, with the mean of the controls over these and the rewards of `task`. Its controls may be larger than the
/// task allows: equations hold for them as well.
fn seen(log: &Dataset, times: usize, spec: &Spec, task: &dyn Task, sensors: &Sensors) -> Result<Dataset, Error> {
    let refused = |why: String| Error::System { name: spec.name.clone(), why };
    let (sensors, mut rng) = (sensors.without_noise(), Seed::new(0).stream("a log", 0));
    let (m, k) = (spec.observation_dim(), spec.control_dim());
    let mut data = Dataset::new(m, k, k, spec.dt);
    let mut observation = vec![0.0; m];
    for rollout in log.rollouts() {
        let states: Vec<Vec<f64>> =
            rollout.observations.rows().into_iter().step_by(times).map(|row| row.to_vec()).collect();
        for (i, state) in states.iter().enumerate() {
            sensors.observe(state, &mut rng, &mut observation);
            let broken = |e: sindyna_core::DatasetError| refused(format!("the log cannot be used: {e}"));
            let Some(before) = i.checked_sub(1) else {
                data.begin(&observation).map_err(broken)?;
                continue;
            };
            let over = rollout.controls.slice(s![times * before..times * i, ..]);
            let u = over.mean_axis(Axis(0)).map_or_else(Vec::new, |mean| mean.to_vec());
            let reward = task.reward(&states[before], &u, &u, state);
            data.push(&u, &u, reward, &observation).map_err(broken)?;
        }
    }
    Ok(data)
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

    fn sampling_interval(&self) -> Option<f64> {
        Some(self.dt)
    }

    fn delay(&self) -> f64 {
        self.delay
    }

    fn lag(&self) -> f64 {
        self.lag
    }

    fn late(&self, model: &Model) -> Option<Arc<dyn Problem>> {
        let late = Late::of((self.delay, self.lag), self.spec().dt);
        if late.is_now() {
            return None;
        }
        let plant = LatePlant::new(Arc::new(model.clone()), late, self.spec().state_dim());
        Some(Arc::new(OwnSystem::driven(self.task.task(), self.task.sensors(), move || plant.clone())))
    }

    fn identified(&self) -> Option<&Identified> {
        Some(&self.identified)
    }

    fn check(&self) -> Result<(), Error> {
        self.task.check()
    }

    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        let mut files = self.task.files()?;
        files.extend(self.files.iter().cloned());
        Ok(files)
    }
}
