//! `sindyna report`: the page of a record, or of a comparison, made again.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::json;
use sindyna_core::number::fixed;
use sindyna_methods::Known;
use sindyna_record::comparison::{Digest, gather};
use sindyna_record::run::DirLock;
use sindyna_record::{RecordError, sweep};
use sindyna_report::{Comparison, Group};

use super::answer::{Answer, Verdict};
use crate::cli::failure::Failure;
use crate::cli::{pages, report_files};

/// Rebuild the report of a run, a model or a comparison
///
/// No simulation or training is run. DIR is the output directory of `sindyna train`, `sindyna identify` or `sindyna compare` (of any version), or the folder `digest` of a
/// comparison.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Directory of a run, a model, a comparison, or the digest of one
    #[arg(value_name = "DIR", default_value = "runs/compare")]
    directory: PathBuf,
    /// Write the report on a comparison as Markdown to FILE instead, with its figures in a folder of that name beside it; DIR stays as it is
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
}

/// What `--json` says of a comparison.
#[derive(Serialize)]
pub(super) struct Told<'a> {
    pub(super) record: &'a Path,
    pub(super) report: PathBuf,
    pub(super) groups: &'a [Group],
    /// What was asked for and is not there.
    pub(super) missing: Option<String>,
}

pub(crate) fn run(args: &Args) -> Result<Answer, Failure> {
    const HINT: &str =
        "DIR is an output directory of `sindyna train`, `identify` or `compare`, or the digest of a comparison";
    let directory = &args.directory;
    if let Err(source) = std::fs::read_dir(directory) {
        let error = RecordError::Io { action: "read", path: directory.clone(), source };
        return Err(Failure::from(error).hint(HINT));
    }
    if directory.join("config.toml").is_file() {
        if args.markdown.is_some() {
            return Err(Failure::new(format!("{} is no comparison", directory.display()))
                .hint("--markdown applies to comparisons; the report of a run or a model is report.html"));
        }
        let report = pages::again(directory)?;
        let text = format!("report: {}\n", report.display());
        return Answer::new(Verdict::Done, text, &json!({"record": directory, "report": report}));
    }
    // What is written into the directory is swept away by a comparison at work there; a Markdown file lies elsewhere.
    let held = match args.markdown {
        None => Some(DirLock::take(directory).map_err(|at_work| {
            Failure::from(at_work).hint("wait for it, or write the results so far with --markdown FILE")
        })?),
        Some(_) => None,
    };
    let tasks = Known::tasks();
    let names = Known::names(&tasks);
    let digest = if Digest::is_in(directory) { Digest::read(directory, &names) } else { gather(directory, &names) };
    let digest = digest.map_err(|error| Failure::from(error).hint(HINT))?;
    if digest.runs.is_empty() {
        return Err(Failure::new(format!("{} holds no runs", directory.display()))
            .hint("`sindyna compare --out DIR` writes them"));
    }
    if held.is_some() && !Digest::is_in(directory) {
        sweep(directory)?;
        digest.write(&directory.join(report_files::DIGEST))?;
    }
    let known = Known::of(&digest);
    let comparison = Comparison::new(&digest, &known);
    let (report, written) = match &args.markdown {
        Some(path) => {
            report_files::write_markdown(&comparison, directory, path)?;
            (path.clone(), path.display().to_string())
        }
        None => {
            report_files::write(&comparison, directory)?;
            (directory.join(pages::PAGE), contents(directory))
        }
    };
    let text = format!("{}\n{}report: {written}\n", table(comparison.groups()), missing(&comparison));
    let told = Told { record: directory, report, groups: comparison.groups(), missing: comparison.gaps() };
    Answer::new(Verdict::Done, text, &told)
}

/// What lies in the directory of a report.
pub(super) fn contents(directory: &Path) -> String {
    format!("{} (report.html to look at, figures, table.md, summary.json)", directory.display())
}

/// A line about runs that are not there, if some are not.
pub(super) fn missing(comparison: &Comparison<'_>) -> String {
    comparison.gaps().map_or_else(String::new, |gaps| gaps + "\n")
}

/// The table for the terminal.
pub(super) fn table(groups: &[Group]) -> String {
    let head = ["task", "method", "solved", "real steps", "ratio to sindy", "return", "lowest"];
    let mut lines = vec![head.map(str::to_owned)];
    let number = |value: Option<f64>, digits: usize| value.map_or_else(|| "–".into(), |v| fixed(v, digits));
    for group in groups {
        let (steps, returns) = (group.steps.as_ref(), group.returns.as_ref());
        lines.push([
            group.task.clone(),
            sindyna_report::method_name(&group.method),
            format!("{} of {}", group.solved, group.runs),
            number(steps.map(|steps| steps.median), 0),
            number(steps.and_then(|steps| steps.over_sindy.as_ref()).map(|ratio| ratio.value), 0),
            number(returns.map(|returns| returns.mean), 1),
            returns.map_or_else(
                || number(None, 1),
                |r| r.lowest.map_or_else(|| "no policy".into(), |v| number(Some(v), 1)),
            ),
        ]);
    }
    sindyna_report::text::aligned(&lines, super::console::width())
}
