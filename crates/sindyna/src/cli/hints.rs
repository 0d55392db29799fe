//! What a user of the command can do about an error of a library.

use std::path::Path;

use sindyna_core::{EnvError, FitError};
use sindyna_dyna::DynaError;
use sindyna_logs::{DeclarationError, LogError, Suggestion};
use sindyna_methods::MethodError;
use sindyna_record::RecordError;
use sindyna_rl::Isa;

use crate::Error;
use crate::cli::closest::closest;

/// A hint for the first error in the chain of `error` that has one.
pub(crate) fn of(error: &anyhow::Error) -> Option<String> {
    error.chain().find_map(|cause| {
        if let Some(error) = cause.downcast_ref::<MethodError>() {
            return of_method(error);
        }
        if let Some(error) = cause.downcast_ref::<Error>() {
            return of_error(error);
        }
        let log = cause.downcast_ref::<LogError>().and_then(of_log);
        let environment = || cause.downcast_ref::<DynaError>().and_then(DynaError::environment);
        log.or_else(|| cause.downcast_ref::<RecordError>().and_then(of_record))
            .or_else(|| environment().and_then(of_environment))
    })
}

/// An error that is passed on as it is stands in for its cause.
fn of_error(error: &Error) -> Option<String> {
    match error {
        Error::Log(error) => of_log(error),
        Error::Record(error) => of_record(error),
        Error::Environment(error) => of_environment(error),
        Error::Train(error) => error.environment().and_then(of_environment),
        Error::Fit(FitError::TooFewRows { .. }) => Some("use a longer log".into()),
        error => of_ours(error),
    }
}

fn of_method(error: &MethodError) -> Option<String> {
    Some(match error {
        MethodError::NotAComparison { .. } => "name another directory with --out".into(),
        MethodError::OtherSettings { .. } => {
            "name another directory with --out, or remove this one; `sindyna report` reports its runs".into()
        }
        MethodError::OtherTask { .. } => "give the task another name, or name another directory with --out".into(),
        MethodError::OtherVariant { .. } => {
            "give the variant another name, or name another directory with --out".into()
        }
        MethodError::Record(error) => return of_record(error),
        MethodError::Training(error) => return of_error(error),
        _ => return None,
    })
}

/// What sort of error `error` is, as `--json` calls it (docs/json.md).
pub(crate) fn kind(error: &anyhow::Error) -> &'static str {
    let of_cause = |cause: &(dyn std::error::Error + 'static)| match cause.downcast_ref::<MethodError>() {
        Some(MethodError::Training(error)) => Some(kind_of(error)),
        Some(MethodError::Record(_)) => Some("record"),
        Some(MethodError::Folder { .. }) => Some("io"),
        Some(_) => Some("input"),
        None => match cause.downcast_ref::<Error>() {
            Some(error) => Some(kind_of(error)),
            None if cause.is::<LogError>() => Some("log"),
            None if cause.is::<RecordError>() => Some("record"),
            None if cause.is::<FitError>() => Some("fit"),
            None if cause.is::<std::io::Error>() => Some("io"),
            None => cause.downcast_ref::<DynaError>().map(of_training),
        },
    };
    error.chain().find_map(of_cause).unwrap_or("input")
}

fn kind_of(error: &Error) -> &'static str {
    match error {
        Error::UnknownName { .. } => "name",
        Error::Log(_) => "log",
        Error::Record(_) => "record",
        Error::Fit(_) => "fit",
        Error::Train(error) => of_training(error),
        Error::Mujoco(_) => "mujoco",
        Error::Environment(_) | Error::Pipe { .. } | Error::NoPipe | Error::NoLog => "system",
        Error::TaskFile { .. } => "task-file",
        _ => "setting",
    }
}

/// The system is at fault where it failed during training.
fn of_training(error: &DynaError) -> &'static str {
    if error.environment().is_some() { "system" } else { "training" }
}

fn of_environment(error: &EnvError) -> Option<String> {
    match error {
        EnvError::Reward { .. } => {
            Some("limit the formula: `sqrt(abs(x))` for a root, `x/(1 + abs(x))` for a quotient".into())
        }
        EnvError::Diverged { .. } => Some(
            "a state became infinite within a step of the simulator: limit its formulas, such as `max(x, 0.001)` in a denominator, give the state `bounds`, or make `dt` smaller"
                .into(),
        ),
        _ => None,
    }
}

fn of_ours(error: &Error) -> Option<String> {
    Some(match error {
        Error::UnknownName { name, known, what } => return near(name, known).or_else(|| listed(what)),
        Error::Setting { name, .. } => return of_setting(name),
        Error::Override { .. } => {
            "--set takes KEY=VALUE, such as sac.reward_scale=1 or sac.hidden=[64,64]; config.toml has all keys".into()
        }
        Error::TooFewSteps { .. } => "increase --real-steps".into(),
        Error::ConstraintForm { option, .. } => match *option {
            "--known" => "--known \"dw/dt: -9.81*sin(th)\" declares a known part of the equation of w",
            "--require" => "--require \"dw/dt: u\" declares that u is in the equation of w",
            "--forbid" => "--forbid \"dw/dt: u\" declares that u is not in the equation of w",
            _ => "--sign \"dw/dt: w < 0\" declares that the coefficient of w is not positive",
        }
        .into(),
        Error::NotIdentified { .. } => {
            "--model takes an output directory of `sindyna identify` of this version; `train --config` with the config.toml of a run identifies the equations in its log again".into()
        }
        Error::Pipe { .. } => "docs/pipe.md describes the protocol".into(),
        Error::NoPipe => "name it again with --pipe COMMAND".into(),
        Error::NoLog => "leave --model out: the run is evaluated on its own system".into(),
        Error::NoSimulator { .. } => "`inverted-pendulum` has one; leave --simulator out for the other tasks".into(),
        Error::TaskFile { .. } | Error::System { .. } => "docs/task-files.md describes task files".into(),
        Error::Isa(_) => format!("without --isa the widest of this machine is used: {}", Isa::widest()),
        _ => return None,
    })
}

/// How the setting called `name` in `config.toml` is set.
fn of_setting(name: &str) -> Option<String> {
    let option = match name {
        "warmup.rollouts" => "--warmup-rollouts",
        "warmup.rollout_len" => "--real-steps (or --rollout-len)",
        "imagination.max_real_steps" => "--max-real-steps",
        "sac.batch_size" => "--batch-size",
        "optimality.max_updates" => "--max-updates",
        "evaluation_episodes" => "--episodes",
        "sac.discount" => {
            return Some(
                "a discount of 1 gives no finite value in an endless task; --discount 0.999 has a horizon of a thousand steps"
                    .into(),
            );
        }
        "noise" => {
            return Some("--noise is a fraction of every observation's scale: 0.01 is one per cent".into());
        }
        _ => return None,
    };
    Some(format!("{option} sets it"))
}

fn of_log(error: &LogError) -> Option<String> {
    Some(match error {
        LogError::NotText { .. } => {
            "a log is a text file, a header and lines of numbers separated by commas or the like, or NPZ, NPY, MAT, MCAP, Parquet or HDF5".into()
        }
        LogError::BuiltWithout { feature, .. } => format!("a build with `--features {feature}` reads it; or save it as CSV, NPZ or MAT"),
        LogError::Malformed { .. } => "write the file again, or save it as CSV".into(),
        LogError::NoArrays { .. } => "a log has one number per signal and sample".into(),
        LogError::SeveralTopics { topics, .. } => return topics.first().map(|topic| format!("name one, such as --topic {topic}")),
        LogError::UnknownTopic { topic, topics, .. } => return near(topic, topics),
        LogError::Empty { .. } => "a log begins with a header line".into(),
        LogError::OneColumn { header, .. } => match header.chars().find(|c| [';', '\t', ',', '|'].contains(c)) {
            Some('\t') => "use --delimiter tab".into(),
            Some(found) => format!("use --delimiter '{found}'"),
            None => "cells are separated by commas; --delimiter names another character".into(),
        },
        LogError::NoHeader { .. } => "the first line names the columns, such as t,th,w,u".into(),
        LogError::CutOff { .. } => "the file ends in the middle of a line; remove that line".into(),
        LogError::EmptyLine { .. } => "remove it; a column `trajectory` separates trajectories".into(),
        LogError::NotFinite { .. } => {
            "leave the cell of a missing value empty: it ends a trajectory, and each trajectory needs at least two rows".into()
        }
        LogError::Interleaved { .. } => "the rows of one trajectory must stand together, in order".into(),
        LogError::ColumnsNotNamed { path, suggestion, .. } => format!("for example: {}{}", call(path, suggestion), of_inputs(suggestion)),
        LogError::UnknownColumn { column, known, .. } => return near(column, known),
        LogError::NoTime { .. } => {
            "name it with --time-column, or give the time between two rows in seconds with --dt; for a map without seconds, --dt 1".into()
        }
        LogError::OtherInterval { .. } => {
            "leave --dt out, name another column with --time-column, or its unit with --units COLUMN=UNIT; `--time-column none` ignores time stamps".into()
        }
        LogError::TimeUnit { column, .. } => {
            format!("--units {column}=s reads it in seconds, --units {column}=ms in milliseconds, --units {column}=us in microseconds")
        }
        LogError::NotANumber { cell, .. } if cell.contains(':') => {
            "dates are read as ISO 8601 writes them, such as 2026-03-01T12:00:00.5Z: convert others, or ignore them by --time-column none --dt S".into()
        }
        LogError::TimeNotIncreasing { .. } => {
            "a column `trajectory` marks where a new trajectory begins; rows of one trajectory stand in the order of their times; `--time-column none --dt S` ignores time stamps".into()
        }
        LogError::TooManyRows { .. } => "give --resample a longer step".into(),
        LogError::Unit { .. } => "--units COLUMN=UNIT declares its unit".into(),
        LogError::Declared(error) => return of_declaration(error),
        _ => return None,
    })
}

/// What to declare instead.
fn of_declaration(error: &DeclarationError) -> Option<String> {
    Some(match error {
        DeclarationError::UnknownState { state, known, .. } => return near(state, known),
        DeclarationError::NotACircle { .. } | DeclarationError::CircleTaken { .. } => {
            "--circles names pairs of columns that are cosine and sine of one angle".into()
        }
        DeclarationError::OwnRate { .. } | DeclarationError::RateTaken { .. } => {
            "--rates names pairs RATE=OF of two states".into()
        }
        DeclarationError::RateCircle { .. } => {
            "leave one of the pairs of --rates out; its equation is then identified".into()
        }
        DeclarationError::AngleAndRate { .. } => "remove it from --angles, or use --rates none".into(),
        _ => return None,
    })
}

/// How inputs are named, where none was recognised.
fn of_inputs(suggestion: &Suggestion) -> &'static str {
    if suggestion.inputs.is_empty() { "; columns that are set from outside are named by --inputs" } else { "" }
}

/// The call that names the columns of the log at `path`.
fn call(path: &Path, Suggestion { states, inputs, has_time, time_column }: &Suggestion) -> String {
    let quote = |list: &[String]| match list.join(",") {
        list if list.contains([' ', '(', '*']) => format!("'{list}'"),
        list => list,
    };
    let inputs = if inputs.is_empty() { String::new() } else { format!(" --inputs {}", quote(inputs)) };
    let time = match time_column {
        _ if *has_time => String::new(),
        Some(column) => format!(" --time-column {}", quote(std::slice::from_ref(column))),
        None => " --dt SECONDS".into(),
    };
    format!("sindyna identify {} --states {}{inputs}{time}", path.display(), quote(states))
}

fn of_record(error: &RecordError) -> Option<String> {
    let hint = match error {
        RecordError::InUse { .. } => "wait for it, or name another directory",
        RecordError::Exists { .. } => "name another directory with --out, or remove this one",
        RecordError::NotARun { .. } => {
            "`sindyna train TASK` prints the directory of its run; if it was killed before it wrote this file, give the same command again"
        }
        RecordError::Inconsistent { is_digest: true, .. } => {
            "`sindyna report` rebuilds it from the directory of the comparison"
        }
        RecordError::Inconsistent { .. } => "remove the file; `sindyna compare` repeats the run",
        RecordError::NotAComparison { .. } => {
            "an output directory of `sindyna train`, `identify` or `compare` has a config.toml or a compare.toml"
        }
        RecordError::NoRuns { .. } => "`sindyna compare --out DIR` writes them",
        RecordError::OtherRun { .. } => "remove it; `sindyna compare` repeats the run",
        _ => return None,
    };
    Some(hint.into())
}

/// Where names of this kind are told.
fn listed(what: &str) -> Option<String> {
    (what == "task").then(|| "a system of your own is a file: `train --task-file my.toml`, `compare --tasks my.toml` (docs/task-files.md)".into())
}

/// The name among `known` that was meant.
fn near(name: &str, known: &[String]) -> Option<String> {
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    closest(name, &known).map(|near| format!("did you mean `{near}`?"))
}
