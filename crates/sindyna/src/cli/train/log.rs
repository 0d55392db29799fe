//! A log in the place of a system, as options.

use std::path::Path;

use sindyna_core::InterSample;
use sindyna_sindy::Watch;
use sindyna_training::problem::LogSource;
use sindyna_training::settings::TrainConfig;

use super::super::failure::Failure;
use super::super::identify::{delay, intersample, lag};
use super::super::interrupt::Interrupt;
use super::super::progress::{Looking, Progress};
use super::super::reading::TableOptions;
use crate::identify::{Delay, ForTask, Lag, for_task};

/// Options that say how the log of `--data` is read; its columns are as the task file declares.
#[derive(Debug, Default, PartialEq, clap::Args)]
pub(super) struct DataOptions {
    #[command(flatten)]
    table: TableOptions,
    /// Delay of the inputs in rows, as of `sindyna identify`; the policy acts on the state predicted for the time when its input acts; 0 disables the detection [default: estimated where the equations leave residuals that no
    /// term explains]
    #[arg(long, value_name = "ROWS", value_parser = delay, default_value = "auto", hide_default_value = true, help_heading = "Log")]
    delay: Delay,
    /// Lag of the inputs in seconds, as of `sindyna identify`; what actuators deliver is then part of the state; 0 disables the detection [default: estimated where the equations leave residuals that no
    /// term explains]
    #[arg(long, value_name = "S", value_parser = lag, default_value = "auto", hide_default_value = true, help_heading = "Log")]
    lag: Lag,
    /// Behavior of the inputs between samples, as of `sindyna identify`: `zoh` (held), `foh` (linear) or `bl` (smooth)
    #[arg(long, value_name = "HOLD", value_parser = intersample, help_heading = "Log")]
    intersample: Option<InterSample>,
}

impl DataOptions {
    /// Refuses options without a log that they are for.
    pub(super) fn check(&self, has_log: bool) -> Result<(), Failure> {
        if has_log || *self == Self::default() {
            return Ok(());
        }
        Err(Failure::new("--delay, --lag, --dt, --units and other options of a log require --data")
            .hint("leave them out, or name a log with --data"))
    }

    /// Equations in `log` for the task in the file `task`, found as `config` says.
    pub(super) fn identified(
        &self,
        task: &Path,
        log: &Path,
        config: &TrainConfig,
        (interrupt, progress): (&Interrupt, &Progress),
    ) -> Result<LogSource, Failure> {
        let (go_on, looking) = (|| !interrupt.pressed(), Looking::new(progress));
        let telling = |stage| looking.tell(stage);
        let how = ForTask {
            options: self.table.options()?,
            delay: self.delay,
            lag: self.lag,
            intersample: self.intersample,
            identifier: &|spec| config.identification.identifier(spec),
            watch: &Watch::going_on(&go_on).telling(&telling),
            say: &|told| progress.say(told),
        };
        let found = for_task(task, &[log], &how);
        progress.finish();
        Ok(found?)
    }
}
