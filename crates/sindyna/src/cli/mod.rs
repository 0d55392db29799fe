//! The command line.

mod account_text;
mod compare;
mod evaluate;
mod export;
mod failure;
mod hints;
mod identification;
mod identify;
mod interrupt;
mod machine;
mod methods;
mod plain;
mod progress;
mod report;
mod report_files;
mod settings;
mod table;
mod tasks;
mod train;

use std::io::Write as _;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::cli::failure::Failure;
use crate::cli::interrupt::EXIT_INTERRUPTED;
use crate::cli::plain::plain;

/// Learns the equations of motion of a physical system from a fraction of a second of data and trains a controller
/// inside them.
#[derive(Debug, Parser)]
#[command(name = "sindyna", version, propagate_version = true, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 ran but missed its target, 2 could not run, 130 stopped by Ctrl-C with a valid record.
Results go to stdout, progress to stderr.

Begin with:  sindyna train pendulum";

#[derive(Debug, Subcommand)]
enum Command {
    Train(Box<train::Args>),
    Identify(Box<identify::Args>),
    Export(export::Args),
    Evaluate(evaluate::Args),
    Compare(compare::Args),
    Report(report::Args),
    Tasks(tasks::Args),
}

/// How a command that ran came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Done,
    MissedTarget,
    Interrupted,
}

/// Runs the command line of this process.
#[must_use]
pub fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Train(args) => train::run(&args),
        Command::Identify(args) => identify::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Tasks(args) => tasks::run(&args),
    };
    match result {
        Ok(Verdict::Done) => ExitCode::SUCCESS,
        Ok(Verdict::MissedTarget) => ExitCode::from(1),
        Ok(Verdict::Interrupted) => ExitCode::from(EXIT_INTERRUPTED),
        Err(failure) => {
            // With stderr gone there is nobody left to tell.
            let _ = writeln!(std::io::stderr(), "{failure}");
            ExitCode::from(2)
        }
    }
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
    quiet: bool,
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
