//! The command line.

mod closest;
mod common;
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
mod pages;
mod plain;
mod progress;
mod report;
mod report_files;
mod settings;
mod tasks;
mod train;

use std::io::Write as _;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use common::Verdict;
use interrupt::EXIT_INTERRUPTED;

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
