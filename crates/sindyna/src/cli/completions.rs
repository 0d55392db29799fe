//! `sindyna completions`: what shells complete.

use clap_complete::Shell;
use serde_json::json;

use super::answer::Answer;
use crate::cli::failure::Failure;

/// Write shell completions to stdout
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Shell that completes
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

const EXAMPLE: &str = "\
Example:  sindyna completions bash > ~/.local/share/bash-completion/completions/sindyna";

pub(crate) fn run(args: &Args, mut definition: clap::Command) -> Result<Answer, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut definition, "sindyna", &mut script);
    let script = String::from_utf8(script)?;
    let result = json!({"shell": args.shell.to_string(), "script": script});
    Answer::raw(script, &result)
}
