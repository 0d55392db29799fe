//! Command lines that cannot be understood, in the style of all other errors.

use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::failure::Failure;

/// What is wrong with the command line, and what was meant.
pub(crate) fn failure(error: &clap::Error) -> Failure {
    let text = error.render().to_string();
    // The first paragraph tells what is wrong; suggestions, usage and where help is follow.
    let message = text.split("\n\n").next().unwrap_or_default();
    let message = message.strip_prefix("error: ").unwrap_or(message).trim_end();
    // Rust's words for numbers that are none.
    let message = message.replace("invalid float literal", "it is not a number");
    let message = message.replace("invalid digit found in string", "it is not a whole number");
    Failure::usage(message).hint(hint(error))
}

fn hint(error: &clap::Error) -> String {
    let suggested = [ContextKind::SuggestedSubcommand, ContextKind::SuggestedArg, ContextKind::SuggestedValue];
    let names = suggested.iter().find_map(|kind| match error.get(*kind)? {
        ContextValue::String(name) => Some(vec![name.clone()]),
        ContextValue::Strings(names) if !names.is_empty() => Some(names.clone()),
        _ => None,
    });
    if let Some(names) = names {
        return format!("did you mean `{}`?", names.join("` or `"));
    }
    if let Some(ContextValue::String(value)) = error.get(ContextKind::InvalidValue)
        && let Some(Ok(percent)) = value.trim().strip_suffix('%').map(|number| number.trim().parse::<f64>())
    {
        return format!("{value} is {}", percent / 100.0);
    }
    let missing = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(names)) if error.kind() == ErrorKind::MissingRequiredArgument => names.as_slice(),
        _ => &[],
    };
    if missing.iter().any(|name| name == "<TASK>") {
        return "`sindyna tasks` lists tasks; --task-file names a system of your own (docs/task-files.md)".into();
    }
    let usage = error.get(ContextKind::Usage).map(ToString::to_string);
    let usage = usage.map(|text| text.trim_start_matches("Usage:").trim().to_owned()).filter(|text| !text.is_empty());
    usage.map_or_else(
        || "`--help` describes every option".into(),
        |usage| format!("usage: {usage} (more with `--help`)"),
    )
}
