//! What all commands have in common.

use std::io::Write as _;

use super::failure::Failure;
use super::plain::plain;

/// How a command that ran came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Done,
    MissedTarget,
    Interrupted,
}

/// Writes `text` to stdout, for people to read.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    write_out(&plain(text))
}

/// Writes `text` to stdout as it is; a reader that has gone away (`| head`) is not an error.
pub(crate) fn write_out(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::from(anyhow::Error::new(e).context("cannot write to stdout"))
                .hint("results go to stdout: see that what it leads to has room"))
        }
        _ => Ok(()),
    }
}

/// Threads to work with.
const MOST_THREADS: i64 = 1_024;

/// What every long-running command understands.
#[derive(Debug, clap::Args)]
pub(crate) struct Common {
    /// Threads to work with; results do not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
    /// No progress on stderr
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

impl Common {
    /// A thread pool of the size asked for.
    pub(crate) fn pool(&self) -> Result<rayon::ThreadPool, Failure> {
        // None given: rayon's own variable counts, but no more than an option could ask for; 0 is all cores.
        let variable = || std::env::var("RAYON_NUM_THREADS").ok()?.parse::<usize>().ok();
        let threads = self.threads.map_or_else(|| variable().unwrap_or(0), usize::from).min(MOST_THREADS as usize);
        Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?)
    }
}

/// Writes an option that was given over the setting it is for.
pub(crate) fn set<T: Clone>(setting: &mut T, option: &Option<T>) {
    if let Some(value) = option {
        setting.clone_from(value);
    }
}
