//! `sindyna man`: manual pages.

use std::fs;
use std::path::PathBuf;

use anyhow::Context as _;
use clap_mangen::Man;
use serde_json::json;
use sindyna_record::Own;

use super::answer::{Answer, Verdict};
use crate::cli::failure::Failure;

/// Write the manual page to stdout, or those of all commands to a directory
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Directory for the pages sindyna.1, sindyna-train.1 and so on; created if missing
    #[arg(value_name = "DIR")]
    directory: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Example:  sindyna man | man -l -";

pub(crate) fn run(args: &Args, definition: clap::Command) -> Result<Answer, Failure> {
    let Some(directory) = &args.directory else {
        let page = page(definition)?;
        let result = json!({"page": page});
        return Answer::raw(page, &result);
    };
    fs::create_dir_all(directory).with_context(|| format!("cannot make the directory {}", directory.display()))?;
    let mut written = Vec::new();
    let mut definition = definition.disable_help_subcommand(true);
    definition.build();
    let commands = definition.get_subcommands().map(|command| (format!("sindyna-{}", command.get_name()), command));
    for (name, command) in std::iter::once(("sindyna".to_owned(), &definition)).chain(commands) {
        // The heading of a page is the name of its file.
        let shown: &'static str = Box::leak(name.clone().into_boxed_str());
        let path = directory.join(format!("{name}.1"));
        let own = Own { path: &path, what: "a manual page of sindyna" };
        own.save(page(command.clone().name(shown))?.as_bytes()).map_err(|e| Failure::of_own(e, "another DIR"))?;
        written.push(path);
    }
    let text = written.iter().map(|path| format!("written: {}\n", path.display())).collect();
    Answer::new(Verdict::Done, text, &json!({"written": written}))
}

fn page(command: clap::Command) -> Result<String, Failure> {
    let mut page = Vec::new();
    Man::new(command).render(&mut page)?;
    Ok(String::from_utf8(page)?)
}
