//! What a user of the command can do about an error of a library.

use std::path::Path;

use sindyna_logs::{LogError, Suggestion};
use sindyna_record::RecordError;

use crate::failure::closest;

/// A hint for the first error in the chain of `error` that has one.
pub(crate) fn of(error: &anyhow::Error) -> Option<String> {
    error.chain().find_map(|cause| {
        let log = cause.downcast_ref::<LogError>().and_then(of_log);
        log.or_else(|| cause.downcast_ref::<RecordError>().and_then(of_record))
    })
}

fn of_log(error: &LogError) -> Option<String> {
    Some(match error {
        LogError::NotText { .. } => "a log is a CSV file: a header, then lines of numbers separated by commas".into(),
        LogError::CarriageReturns { .. } => "end every line with a line feed, as `tr '\\r' '\\n' < LOG` does".into(),
        LogError::Empty { .. } => "a log begins with a header line".into(),
        LogError::OneColumn { .. } => "cells are separated by commas".into(),
        LogError::NoHeader { .. } => "the first line names the columns, such as t,th,w,u".into(),
        LogError::CutOff { .. } => "the file ends in the middle of a line; remove that line".into(),
        LogError::EmptyLine { .. } => "remove it; a column `trajectory` tells rollouts apart".into(),
        LogError::NotFinite { .. } => {
            "remove the row, and begin another `trajectory` after it: what follows is a rollout of its own".into()
        }
        LogError::Interleaved { .. } => "the rows of one trajectory must stand together, in order".into(),
        LogError::ColumnsNotNamed { path, suggestion, .. } => format!("for example: {}", call(path, suggestion)),
        LogError::UnknownColumn { column, known } => return near(column, known),
        LogError::UnknownState { state, known, .. } => return near(state, known),
        LogError::NoTime { similar: Some(column), .. } => format!(
            "if `{column}` holds the time in seconds, name it `t` in the header; else give the time between two rows with --dt"
        ),
        LogError::NoTime { .. } => {
            "give the time between two rows in seconds with --dt; for a map without seconds, --dt 1".into()
        }
        LogError::TimeNotIncreasing { .. } => {
            "a column `trajectory` tells where another rollout begins; --dt S leaves `t` aside".into()
        }
        LogError::Uneven { suggested, .. } => format!(
            "--resample {suggested} interpolates to even steps; --dt S takes the rows as evenly spaced whatever `t` says"
        ),
        LogError::TooManyRows { .. } => "give --resample a longer step".into(),
        LogError::NotACircle { .. } | LogError::CircleTaken { .. } => {
            "--circles names pairs of columns that are cosine and sine of one angle".into()
        }
        LogError::OwnRate { .. } | LogError::RateTaken { .. } => "--rates names pairs RATE=OF of two states".into(),
        LogError::RateCircle { .. } => "leave one of the pairs of --rates out: its equation is then looked for".into(),
        LogError::AngleAndRate { .. } => "take it off --angles, or say --rates none".into(),
        _ => return None,
    })
}

/// The call that names the columns of the log at `path`.
fn call(path: &Path, Suggestion { states, inputs, has_time }: &Suggestion) -> String {
    let quote = |list: &[String]| match list.join(",") {
        list if list.contains([' ', '(', '*']) => format!("'{list}'"),
        list => list,
    };
    let inputs = if inputs.is_empty() { String::new() } else { format!(" --inputs {}", quote(inputs)) };
    let dt = if *has_time { "" } else { " --dt SECONDS" };
    format!("sindyna identify {} --states {}{inputs}{dt}", path.display(), quote(states))
}

fn of_record(error: &RecordError) -> Option<String> {
    let hint = match error {
        RecordError::InUse { .. } => "wait for it, or name another directory",
        RecordError::Exists { .. } => "name another directory with --out, or remove this one",
        RecordError::NotARun { .. } => {
            "`sindyna train TASK` prints the directory of its run; killed before that file was there, it is given again"
        }
        RecordError::Inconsistent { is_digest: true, .. } => {
            "`sindyna report` makes it again from the directory of the comparison"
        }
        RecordError::Inconsistent { .. } => "`sindyna compare` makes again what is taken away",
        RecordError::NotAComparison { .. } => "name the directory of a comparison",
        RecordError::NoRuns { .. } => "`sindyna compare --out DIR` makes some",
        RecordError::OtherRun { .. } => "take it away; `sindyna compare` makes it again",
        _ => return None,
    };
    Some(hint.into())
}

/// The name among `known` that was meant.
fn near(name: &str, known: &[String]) -> Option<String> {
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    closest(name, &known).map(|near| format!("did you mean `{near}`?"))
}
