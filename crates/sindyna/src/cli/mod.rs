//! The command line.

mod answer;
mod closest;
mod common;
mod compare;
mod completions;
mod conclusion;
mod console;
mod doctor;
mod evaluate;
mod export;
mod failure;
mod hints;
mod identification;
mod identify;
mod inspect;
mod interrupt;
mod machine;
mod man;
mod pages;
mod pipe;
mod plain;
mod progress;
mod reading;
mod report;
mod report_files;
mod settings;
mod show;
mod tasks;
mod text;
mod train;
mod usage;

use std::process::ExitCode;

use clap::{ColorChoice, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use answer::Answer;
use console::{Color, Console};

/// Identify the equations of motion of a physical system from little data, and train a controller in them.
#[derive(Debug, Parser)]
#[command(name = "sindyna", version, propagate_version = true, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    console: Console,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 ran but missed its target, 2 could not run, 130 stopped by Ctrl-C with a valid record.
Results go to stdout, progress to stderr.

Begin with:  sindyna train pendulum";

#[derive(Debug, Subcommand)]
enum Command {
    Train(Box<train::Args>),
    Identify(Box<identify::Args>),
    Inspect(Box<inspect::Args>),
    Export(export::Args),
    Evaluate(evaluate::Args),
    Compare(compare::Args),
    Show(show::Args),
    Report(report::Args),
    Tasks(tasks::Args),
    Doctor(doctor::Args),
    Completions(completions::Args),
    Man(man::Args),
}

/// Runs the command line of this process.
#[must_use]
pub fn main() -> ExitCode {
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    let guessed = Console::guessed(&words);
    let definition = Cli::command().color(match guessed.color {
        Color::Auto => ColorChoice::Auto,
        Color::Always => ColorChoice::Always,
        Color::Never => ColorChoice::Never,
    });
    let parsed = definition.clone().try_get_matches();
    let parsed = parsed.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        // Help and versions were asked for; or nothing was, which help answers.
        Err(shown) if shown.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => shown.exit(),
        Err(shown) if !shown.use_stderr() => shown.exit(),
        Err(error) => {
            let known =
                |word: &&String| definition.get_subcommands().any(|command| command.get_name() == word.as_str());
            let name = words.iter().find(known).map_or("sindyna", String::as_str);
            return ExitCode::from(guessed.say(name, Answer::from(usage::failure(&error))));
        }
    };
    let console = cli.console;
    let answer = match cli.command {
        Command::Train(args) => train::run(&args, console),
        Command::Identify(args) => identify::run(&args, console),
        Command::Inspect(args) => inspect::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Compare(args) => compare::run(&args, console),
        Command::Show(args) => show::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Tasks(args) => tasks::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Completions(args) => completions::run(&args, definition),
        Command::Man(args) => man::run(&args, definition),
    };
    let name = matches.subcommand_name().unwrap_or("sindyna");
    ExitCode::from(console.say(name, answer.unwrap_or_else(Answer::from)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }
}
