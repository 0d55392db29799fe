//! The whole job by two builds of sindyna, run in turn: is the newer one slower?
//!
//! Runs `train TASK --seed S --threads 1` with both for every task and seed and compares processor seconds, which hold all of a run (steps, identification, training,
//! evaluation of 100 episodes) and which other work on the machine disturbs little. Ratios are of neighbours in time. Writes results/OUT.json.

use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::Stdio;

use clap::Parser;
use serde::Serialize;
use sindyna_bench::study::{Result, Sindyna, Spread, count, ended_seconds, rounded, store};
use sindyna_record::comparison::Seeds;

#[derive(Debug, Parser)]
struct Options {
    /// The program of the older build.
    older: PathBuf,
    /// The program of the newer one.
    newer: PathBuf,
    /// What the two programs were built from.
    #[arg(long, value_delimiter = ',')]
    commits: Vec<String>,
    /// Tasks.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "pendulum,mountain-car,inverted-pendulum,cart-pole,cart-pole-swing-up"
    )]
    tasks: Vec<String>,
    /// Seeds, such as 20 or 100-119.
    #[arg(long, default_value = "100-119")]
    seeds: Seeds,
    /// Stem of the file in results.
    #[arg(long, default_value = "paired-jobs")]
    out: String,
}

#[derive(Debug, Serialize)]
struct Figures {
    seeds: Seeds,
    commits: Vec<String>,
    cpu_seconds: BTreeMap<String, Pair>,
}

/// One task.
#[derive(Debug, Serialize)]
struct Pair {
    /// By the older build and by the newer.
    solved: [usize; 2],
    older: Spread,
    newer: Spread,
    sums: [Option<f64>; 2],
    newer_over_older: Spread,
}

fn main() -> Result {
    let options = Options::parse();
    let programs = [&options.older, &options.newer].map(|path| Sindyna::at(path));
    let mut cpu_seconds = BTreeMap::new();
    for task in &options.tasks {
        let mut runs: [Vec<(f64, bool)>; 2] = [Vec::new(), Vec::new()];
        for seed in options.seeds.iter() {
            for (program, runs) in programs.iter().zip(&mut runs) {
                runs.push(job(program, task, seed)?);
            }
        }
        let seconds = runs.each_ref().map(|runs| runs.iter().map(|run| run.0).collect::<Vec<f64>>());
        let ratios: Vec<f64> = seconds[1].iter().zip(&seconds[0]).map(|(newer, older)| newer / older).collect();
        let pair = Pair {
            solved: runs.each_ref().map(|runs| count(runs, |run| run.1)),
            older: Spread::of(&seconds[0]),
            newer: Spread::of(&seconds[1]),
            sums: seconds.each_ref().map(|seconds| rounded(seconds.iter().sum())),
            newer_over_older: Spread::of(&ratios),
        };
        writeln!(io::stderr(), "{task}: {pair:?}")?;
        cpu_seconds.insert(task.clone(), pair);
    }
    store(&options.out, Figures { seeds: options.seeds, commits: options.commits, cpu_seconds })
}

/// Processor seconds of a run, and whether it solved the task.
fn job(program: &Sindyna, task: &str, seed: u64) -> Result<(f64, bool)> {
    let folder = tempfile::tempdir()?;
    let before = ended_seconds()?;
    let mut command = program.training(task, seed, &folder.path().join("run"), &["--threads", "1"]);
    let done = command.stderr(Stdio::null()).status()?;
    Ok((ended_seconds()? - before, done.success()))
}
