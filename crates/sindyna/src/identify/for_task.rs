//! Equations for a task: what a controller is trained in where there is nothing but a log.

use std::path::Path;
use std::sync::Arc;

use sindyna_core::{InterSample, Spec};
use sindyna_sindy::{Identifier, Watch};
use sindyna_training::problem::{LogSource, Problem, declared, on_log, read_logs};
use sindyna_training::settings::TrainConfig;

use super::asked::{Asked, Delay, Lag};
use super::hypotheses::looked;
use super::looked::Looked;
use super::unmeasured::Unmeasured;
use crate::Error;
use crate::logs::{Log, LogOptions};

/// How equations for a task are looked for, and who is told.
pub(crate) struct ForTask<'a> {
    /// How cells and time stamps are read; columns are as the task declares.
    pub(crate) options: LogOptions,
    pub(crate) delay: Delay,
    pub(crate) lag: Lag,
    /// What inputs do between samples, if that was said.
    pub(crate) intersample: Option<InterSample>,
    /// Makes an identifier for a system.
    pub(crate) identifier: &'a (dyn Fn(&Spec) -> Result<Identifier, Error> + Sync),
    pub(crate) watch: &'a Watch<'a>,
    /// Is told what was read, and what is tried.
    pub(crate) say: &'a (dyn Fn(&str) + Sync),
}

/// Equations for the task in the file `task_file`, found in the logs at `paths` as [`log`](super::log) finds them. Rates that the task declares and no column shows are
/// those that were not measured.
///
/// # Errors
/// [`Error`] if logs cannot be read as the task declares, no equations are found, or they are such that no controller can be trained in them.
pub(crate) fn for_task<P: AsRef<Path>>(task_file: &Path, paths: &[P], how: &ForTask<'_>) -> Result<LogSource, Error> {
    let (log, missing) = read_logs(task_file, paths, how.options.clone())?;
    (how.say)(&format!("read: {} rows, {} steps; searching for equations", log.rows, log.data.n_steps()));
    for note in &log.notes {
        (how.say)(&format!("note: {note}"));
    }
    let unmeasured = if missing.is_empty() { Unmeasured::Auto } else { Unmeasured::Given(missing) };
    let asked = Asked {
        unmeasured: &unmeasured,
        delay: how.delay,
        lag: how.lag,
        intersample: how.intersample,
        kept: &|log: &Log| Ok(log.samples()),
        identifier: how.identifier,
        watch: how.watch,
        say: how.say,
    };
    let names = paths.iter().map(|path| path.as_ref().display().to_string()).collect::<Vec<_>>().join(", ");
    let read = log.notes.clone();
    let Looked { found, log, .. } = looked(log, &asked)?;
    for note in log.notes.iter().filter(|note| !read.contains(note)) {
        (how.say)(&format!("note: {note}"));
    }
    LogSource::found(&names, &log, &found)
}

/// The problem of the task in the file `task_file` on the logs at `paths`, in which equations are found first, as [`log`](super::log) finds them. `settings` such as
/// `identification.library=paper` change how; `watch` may end it.
///
/// # Errors
/// [`Error`] if logs cannot be read as the task declares, no equations are found, or they are such that no controller can be trained in them.
pub fn of_log<P: AsRef<Path>>(
    task_file: &Path,
    paths: &[P],
    settings: &[String],
    watch: &Watch<'_>,
) -> Result<Arc<dyn Problem>, Error> {
    // Settings do not depend on the control interval.
    let config = TrainConfig::defaults(&*declared(task_file, 1.0)?.task());
    let config = settings.iter().try_fold(config, |config, setting| config.with(setting))?;
    let how = ForTask {
        options: LogOptions::default(),
        delay: Delay::Auto,
        lag: Lag::Auto,
        intersample: None,
        identifier: &|spec| config.identification.identifier(spec),
        watch,
        say: &|_| {},
    };
    on_log(task_file, &for_task(task_file, paths, &how)?)
}
