//! One run in a process of its own, which can be stopped.

use std::io::Read as _;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// Time between two looks at the process.
const LOOK: Duration = Duration::from_millis(10);

/// How an identification ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Equations came back.
    Identified,
    /// The method, or the system, gave a reason why not.
    Refused,
    /// Nothing came back in time.
    TimedOut,
    /// The process broke.
    Crashed,
}

/// How a process ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// With this on its standard output.
    Done(String),
    /// Not within the limit.
    TimedOut,
    /// By itself, without success.
    Crashed(String),
}

/// Runs this program with `arguments` for at most `limit`.
///
/// # Errors
/// If no process can be started or watched.
pub fn run(arguments: &[String], limit: Duration) -> std::io::Result<Ended> {
    let program = std::env::current_exe()?;
    let mut child = Command::new(program).args(arguments).stdout(Stdio::piped()).spawn()?;
    let pipe = child.stdout.take();
    let reader = thread::spawn(move || {
        let mut text = String::new();
        pipe.map_or(Ok(0), |mut pipe| pipe.read_to_string(&mut text)).map(|_| text)
    });
    let Some(status) = wait(&mut child, limit)? else {
        child.kill()?;
        child.wait()?;
        return Ok(Ended::TimedOut);
    };
    let text = reader.join().map_err(|_| std::io::Error::other("the reader of a run panicked"))??;
    Ok(if status.success() { Ended::Done(text) } else { Ended::Crashed(status.to_string()) })
}

/// The status with which `child` ended; none if it still runs after `limit`.
fn wait(child: &mut Child, limit: Duration) -> std::io::Result<Option<std::process::ExitStatus>> {
    let start = Instant::now();
    loop {
        match child.try_wait()? {
            Some(status) => return Ok(Some(status)),
            None if start.elapsed() > limit => return Ok(None),
            None => thread::sleep(LOOK),
        }
    }
}
