//! A program as the system, named by an option.

use std::time::Duration;

use sindyna_training::problem::PipeSource;

use super::failure::Failure;
use super::interrupt::Interrupt;

/// Seconds that an answer may take where none are given.
const SECONDS: f64 = 60.0;

/// Which program is the system.
#[derive(Debug, Default, PartialEq, clap::Args)]
pub(crate) struct PipeOptions {
    /// Program that simulates or drives the system, such as "python3 rig.py": it receives controls and sends states as lines of JSON (docs/pipe.md). It is
    /// started without a shell and is not saved in the record; evaluate, --config and --resume need it again
    #[arg(long, value_name = "COMMAND", help_heading = "Real data")]
    pipe: Option<String>,
    /// Seconds an answer of --pipe may take [default: 60]
    #[arg(long, value_name = "SECONDS", requires = "pipe", help_heading = "Real data")]
    pipe_timeout: Option<f64>,
}

impl PipeOptions {
    /// Whether a program is named.
    pub(crate) fn is_given(&self) -> bool {
        self.pipe.is_some()
    }

    /// The program, where one is named; `interrupt` ends the waiting for it.
    pub(crate) fn source(&self, interrupt: &Interrupt) -> Result<Option<PipeSource>, Failure> {
        let Some(text) = &self.pipe else { return Ok(None) };
        let command = shell_words::split(text).map_err(|e| Failure::new(format!("--pipe `{text}`: {e}")))?;
        if command.is_empty() {
            return Err(Failure::new("--pipe names no program").hint("--pipe \"python3 rig.py\""));
        }
        let seconds = self.pipe_timeout.unwrap_or(SECONDS);
        let timeout = Duration::try_from_secs_f64(seconds).ok().filter(|t| !t.is_zero());
        let timeout =
            timeout.ok_or_else(|| Failure::new(format!("--pipe-timeout must be above 0 s, got {seconds}")))?;
        Ok(Some(PipeSource { command, timeout, stop: interrupt.flag() }))
    }
}
