//! What `train` does with its time, by a sampling profile of the whole process on one thread.
//!
//! Writes results/OUT.json; the program `performance` makes the page. Needs Linux's perf.

use std::io::{self, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::bail;
use clap::Parser;
use serde::Serialize;
use serde_json::{Map, Value, json};
use sindyna_bench::study::{Result, Sindyna, median, pinned, root, rounded, store};

/// What symbols contain that belong to a part; the first part that matches has the samples.
const PARTS: [(&str, &[&str]); 6] = [
    ("products of updates", &["sindyna_rl::kernel"]),
    ("drawing batches", &["replay::Replay::sample"]),
    ("model", &["sindyna_sindy", "dynamics::Held", "_sin_fma", "_cos_fma", "_sincos_fma", "_tan_fma"]),
    ("true system and sensors", &["sindyna_envs", "Sensors", "Simulated", "Imagined", "Bounded", "Region"]),
    ("loops over networks' numbers", &["vectorize"]),
    ("the rest of updates", &["sindyna_rl::"]),
];

const OTHER: &str = "other";

#[derive(Debug, Parser)]
struct Options {
    /// Tasks.
    #[arg(long, value_delimiter = ',', default_value = "pendulum,mountain-car,cart-pole,inverted-pendulum")]
    tasks: Vec<String>,
    /// So many seeds, from 0.
    #[arg(long, default_value_t = 5)]
    seeds: u64,
    /// The core on which all runs.
    #[arg(long, default_value_t = 1)]
    core: usize,
    /// Stem of the file in results.
    #[arg(long, default_value = "parts")]
    out: String,
}

#[derive(Debug, Serialize)]
struct Figures {
    seeds: u64,
    tasks: Vec<Value>,
}

fn main() -> Result {
    let options = Options::parse();
    let (sindyna, folder) = (built_with_symbols()?, tempfile::tempdir()?);
    let mut tasks = Vec::new();
    for task in &options.tasks {
        let profile = |seed| shares(&sindyna, (task, seed), options.core, folder.path());
        let runs = (0..options.seeds).map(profile).collect::<Result<Vec<_>>>()?;
        let names = PARTS.iter().map(|(name, _)| *name).chain([OTHER]).enumerate();
        let middle = |i: usize| median(runs.iter().map(|run| run[i])).and_then(rounded);
        let shares: Map<String, Value> = names.map(|(i, name)| (name.to_owned(), json!(middle(i)))).collect();
        writeln!(io::stderr(), "{task}: {shares:?}")?;
        tasks.push(json!({"task": task, "shares": shares}));
    }
    store(&options.out, Figures { seeds: options.seeds, tasks })
}

/// The command with the names of its functions, which releases do not have.
fn built_with_symbols() -> Result<Sindyna> {
    let folder = root().join("target/unstripped");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo);
    build.args(["build", "--release", "--quiet", "--config", "profile.release.strip=false", "--target-dir"]);
    if !build.arg(&folder).current_dir(root()).status()?.success() {
        bail!("cargo build failed");
    }
    Ok(Sindyna::at(&folder.join("release/sindyna")))
}

/// The share of each part, and of the rest.
fn shares(sindyna: &Sindyna, (task, seed): (&str, u64), core: usize, folder: &Path) -> Result<Vec<f64>> {
    let (data, out) = (folder.join("perf.data"), folder.join(format!("{task}-{seed}")));
    let train = sindyna.training(task, seed, &out, &["--threads", "1"]);
    let mut record = Command::new("perf");
    record.args(["record", "-q", "-F", "5000", "-o"]).arg(&data).arg(train.get_program()).args(train.get_args());
    pinned(&record, core).stdout(Stdio::null()).stderr(Stdio::null()).status()?;
    let mut report = Command::new("perf");
    let report =
        report.arg("report").arg("-i").arg(&data).args(["--no-children", "--stdio", "-s", "symbol"]).output()?;
    if !report.status.success() {
        bail!("perf report failed: {}", String::from_utf8_lossy(&report.stderr));
    }
    Ok(parted(&String::from_utf8_lossy(&report.stdout)))
}

/// What `perf report` says, by parts.
fn parted(report: &str) -> Vec<f64> {
    let mut found = vec![0.0; PARTS.len() + 1];
    for line in report.lines() {
        let Some((percent, symbol)) = line.trim().split_once('%') else { continue };
        let (Ok(percent), true) = (percent.parse::<f64>(), symbol.trim_start().starts_with('[')) else { continue };
        let part = PARTS.iter().position(|(_, names)| names.iter().any(|name| symbol.contains(name)));
        found[part.unwrap_or(PARTS.len())] += percent / 100.0;
    }
    found
}

#[cfg(test)]
mod tests {
    #[test]
    fn samples_count_for_the_first_part_that_matches() {
        let report = "# Overhead\n    60.00%  [.] sindyna_rl::kernel::gemm\n  25.00%  [.] sindyna_rl::sac::update\n  10.00%  [.] __sincos_fma\n   5.00%  [k] page_fault\n";
        assert_eq!(super::parted(report), [0.6, 0.0, 0.1, 0.0, 0.0, 0.25, 0.05]);
    }
}
