//! Standard errors of coefficients against the truth: do 95 % intervals cover, and is the error no more than the data must leave?
//!
//! Identifies logs with noise that is not declared, those of the program `undeclared`, over many seeds. Writes results/coverage.json and docs/coverage.md.

use std::io::{self, Write as _};

use anyhow::Context as _;
use clap::Parser;
use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, count, each, percent, rounded, study};
use sindyna_bench::undeclared::{Case, Run, find};
use sindyna_record::comparison::Seeds;

/// Of a standard normal number 95 % lie within this.
const WITHIN: f64 = 1.959_964;

#[derive(Debug, Parser)]
struct Options {
    /// Systems.
    #[arg(long, value_delimiter = ',', default_value = "lorenz,van-der-pol,duffing")]
    systems: Vec<String>,
    /// Noise, as part of each state's standard deviation over the log.
    #[arg(long, default_value_t = 0.01)]
    noise: f64,
    /// Samples in a log.
    #[arg(long, default_value_t = 300)]
    samples: usize,
    /// Seeds, such as 200 or 0-9,100-199.
    #[arg(long, default_value = "200")]
    seeds: Seeds,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "coverage")]
    out: String,
}

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
struct Figures {
    noise: f64,
    samples: usize,
    groups: Vec<Group>,
}

/// One system.
#[derive(Debug, Serialize, Deserialize)]
struct Group {
    system: String,
    seeds: usize,
    right: usize,
    right_and_adequate: usize,
    coefficients: usize,
    coverage: Option<f64>,
    error_over_bound: Option<f64>,
}

fn main() -> Result {
    let options = Options::parse();
    let measure = || {
        let groups = options.systems.iter().map(|name| measure(name, &options)).collect::<Result<_>>()?;
        Ok(Figures { noise: options.noise, samples: options.samples, groups })
    };
    study((&options.out, &format!("docs/{}.md", options.out)), options.page_only, measure, |document| {
        Ok(page(document))
    })
}

fn measure(name: &str, options: &Options) -> Result<Group> {
    let system = find(name).with_context(|| format!("there is no system named `{name}`"))?;
    let seeds: Vec<u64> = options.seeds.iter().collect();
    let runs = each(options.jobs, &seeds, |&seed| {
        let case =
            Case { system: name.to_owned(), noise: options.noise, samples: options.samples, seed, positions: false };
        Run::of(&system, case)
    })?;
    let group = summary(name, &runs);
    writeln!(io::stderr(), "{group:?}")?;
    Ok(group)
}

fn summary(name: &str, runs: &[Run]) -> Group {
    let right = || runs.iter().filter(|run| run.verdict.right);
    let scores = right().flat_map(|run| &run.verdict.equations).flat_map(|e| e.standardised.iter().flatten());
    let scores: Vec<f64> = scores.copied().collect();
    let mean = |sum: f64| rounded(sum / scores.len() as f64);
    Group {
        system: name.to_owned(),
        seeds: runs.len(),
        right: right().count(),
        right_and_adequate: count(runs, |run| run.verdict.right && run.adequate),
        coefficients: scores.len(),
        coverage: mean(count(&scores, |z| z.abs() < WITHIN) as f64),
        error_over_bound: rounded((scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64).sqrt()),
    }
}

/// docs/coverage.md.
fn page(document: &Document<Figures>) -> String {
    let Figures { noise, samples, groups } = &document.figures;
    let shown = |value: Option<f64>, digits: usize| value.map_or_else(|| "—".into(), |v| format!("{v:.digits$}"));
    let covers = |g: &Group| shown(g.coverage.map(|c| 100.0 * c), 1);
    let finding = |g: &Group| {
        format!(
            "{}: 95 % intervals hold {} % of {} coefficients; the RMS error is {} times the standard error.",
            g.system,
            covers(g),
            g.coefficients,
            shown(g.error_over_bound, 2)
        )
    };
    let row = |g: &Group| {
        let numbers = [g.seeds, g.right, g.right_and_adequate, g.coefficients].map(|n| n.to_string());
        let shares = [format!("{} %", covers(g)), shown(g.error_over_bound, 2)];
        [g.system.clone()].into_iter().chain(numbers).chain(shares).collect()
    };
    let head = [
        "system",
        "seeds",
        "right terms",
        "of these adequate",
        "coefficients",
        "95 % intervals that cover",
        "error / bound",
    ];
    Page::new("Standard errors")
        .list(groups.iter().map(finding))
        .table(&head, groups.iter().map(row).collect::<Vec<_>>())
        .section("How it was measured")
        .text(&format!(
            "{samples} samples, noise of {} of each state's standard deviation, not declared. Logs and systems are those of [undeclared noise](undeclared.md).",
            percent(*noise)
        ))
        .text(
            "*Error / bound*: RMS of (found − true)/standard error. The standard error is the square root of the diagonal of the inverse Fisher information of all samples \
             together (Cramér, Rao), with the noise as it was estimated. Runs with wrong terms have no true coefficients and are left out.",
        )
        .text(&document.made.origin("coverage"))
        .markdown()
}
