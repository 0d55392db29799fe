//! Processes that are measured.

use std::process::Command;

use super::record::Result;

/// Processor seconds that all child processes took which have ended.
///
/// # Errors
/// Where the system does not tell.
#[cfg(unix)]
pub fn ended_seconds() -> Result<f64> {
    use nix::sys::resource::{UsageWho, getrusage};
    use nix::sys::time::TimeValLike as _;
    let used = getrusage(UsageWho::RUSAGE_CHILDREN)?;
    Ok((used.user_time() + used.system_time()).num_microseconds() as f64 / 1e6)
}

/// Processor seconds that all child processes took which have ended.
///
/// # Errors
/// Always: only Unix tells.
#[cfg(not(unix))]
pub fn ended_seconds() -> Result<f64> {
    anyhow::bail!("this system does not tell the processor time of processes that have ended")
}

/// `command` held to one core and one thread, where the system can.
#[must_use]
pub fn pinned(command: &Command, core: usize) -> Command {
    let mut held = if cfg!(target_os = "linux") {
        let mut taskset = Command::new("taskset");
        taskset.args(["-c", &core.to_string()]).arg(command.get_program());
        taskset
    } else {
        Command::new(command.get_program())
    };
    held.args(command.get_args()).env("RAYON_NUM_THREADS", "1");
    held
}
