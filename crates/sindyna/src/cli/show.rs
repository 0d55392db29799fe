//! `sindyna show`: a record, as it is.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use serde::Serialize;
use serde_json::Value;
use sindyna_methods::Known;
use sindyna_record::comparison::{Digest, SETTINGS, gather};
use sindyna_record::identification::{Account, Stepping, read_model};
use sindyna_record::run::{Summary, Timing};
use sindyna_record::{ModelRecord, RunRecord};
use sindyna_report::{Comparison, Group, text};

use super::answer::{Answer, Verdict};
use super::conclusion::Conclusion;
use super::console::width;
use super::{pages, report};
use crate::cli::failure::Failure;

/// Print a record: a run, a model or a comparison
///
/// No simulation or training is run, and no file is written.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Output directory of `sindyna train`, `identify` or `compare`, the digest of a comparison, or a model.json
    #[arg(value_name = "PATH")]
    path: PathBuf,
}

/// What `--json` says of a record.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Shown<'a> {
    /// A run of `sindyna train`.
    Run { summary: &'a Summary, timing: Option<Timing>, identification: Option<&'a Account> },
    /// What `sindyna identify` left.
    Identification { identification: &'a Account },
    /// A file model.json.
    Model { equations: Vec<String>, model: Value },
    /// What `sindyna compare` left.
    Comparison { groups: &'a [Group], missing: Option<String> },
}

pub(crate) fn run(args: &Args) -> Result<Answer, Failure> {
    let path = &args.path;
    if path.is_file() {
        return of_model(path);
    }
    if path.join(SETTINGS).is_file() || Digest::is_in(path) {
        return of_comparison(path);
    }
    if let Some(record) = RunRecord::read(path)? {
        return of_run(path, &record);
    }
    if let Some(record) = ModelRecord::read(path)? {
        let identification = &record.account;
        return Answer::new(
            Verdict::Done,
            text::text(identification, width()),
            &Shown::Identification { identification },
        );
    }
    if path.join("config.toml").is_file() {
        return Err(Failure::new(format!("{} holds no results yet", path.display()))
            .hint(format!("`sindyna train --resume {}` continues a run", path.display())));
    }
    of_comparison(path)
}

fn of_run(path: &Path, record: &RunRecord) -> Result<Answer, Failure> {
    let timing = std::fs::read_to_string(path.join("timing.json")).ok();
    let timing: Option<Timing> = timing.and_then(|text| serde_json::from_str(&text).ok());
    let config = std::fs::read_to_string(path.join("config.toml")).unwrap_or_default();
    let system = pages::system(&config);
    let by_hand = system.iter().flat_map(|system| system.true_equations()).map(ToString::to_string);
    let model = record.identified.as_ref().and_then(|identified| identified.model.as_ref()).or(record.model.as_ref());
    let truth = pages::truth(system.as_ref(), model, by_hand.collect());
    let summary = &record.summary;
    let identification = record.identified.as_ref().map(|identified| &identified.account);
    let conclusion = Conclusion {
        summary,
        timing: timing.as_ref(),
        account: identification,
        truth: &truth,
        unconfirmed: false,
        record: path,
        page: path.join(pages::PAGE).is_file(),
    };
    let text = conclusion.text();
    Answer::new(Verdict::Done, text, &Shown::Run { summary, timing, identification })
}

fn of_model(path: &Path) -> Result<Answer, Failure> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let model = read_model(&text)
        .with_context(|| format!("{} is not a model", path.display()))
        .map_err(|e| Failure::from(e).hint("PATH is a directory with a record, or a model.json"))?;
    let shown = Shown::Model { equations: model.equations(), model: serde_json::from_str(&text)? };
    Answer::new(Verdict::Done, format!("{model}\n{}\n", Stepping::of(&model)), &shown)
}

fn of_comparison(path: &Path) -> Result<Answer, Failure> {
    if !path.is_dir() {
        return Err(Failure::new(format!("{}: no such file or directory", path.display()))
            .hint("PATH is an output directory of `sindyna train`, `identify` or `compare`, or a model.json"));
    }
    let tasks = Known::tasks();
    let names = Known::names(&tasks);
    let digest = if Digest::is_in(path) { Digest::read(path, &names)? } else { gather(path, &names)? };
    let known = Known::of(&digest);
    let comparison = Comparison::new(&digest, &known);
    let groups = comparison.groups();
    let text = format!("{}\n{}", report::table(groups), report::missing(&comparison));
    Answer::new(Verdict::Done, text, &Shown::Comparison { groups, missing: comparison.gaps() })
}
