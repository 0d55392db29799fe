//! Identification from data with undeclared noise: one JSON line per run.
//!
//! `undeclared --set development --noise 0,0.01 --samples 300 --seeds 0-2` generates logs, gives them to the method and holds what comes back
//! against the truth. Every run has a process of its own and a limit on its time. With `--export` the logs are written as files
//! instead, and nothing is identified.

use std::fs::File;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use clap::Parser;
use cpu_time::ProcessTime;
use serde::Serialize;
use sindyna_bench::child::{self, Ended, Outcome};
use sindyna_bench::method;
use sindyna_bench::undeclared::{Judge, Set, System, Verdict, export, find, generate, systems};
use sindyna_core::Seed;

#[derive(Debug, Parser)]
struct Options {
    /// Which systems.
    #[arg(long, value_enum, default_value_t = Set::Development)]
    set: Set,
    /// Only these systems.
    #[arg(long, value_delimiter = ',')]
    systems: Vec<String>,
    /// Noise, as parts of each channel's standard deviation over the log.
    #[arg(long, value_delimiter = ',', default_values_t = [0.0, 0.001, 0.01, 0.05])]
    noise: Vec<f64>,
    /// Samples in a log.
    #[arg(long, value_delimiter = ',', default_values_t = [100, 300, 1000, 3000])]
    samples: Vec<usize>,
    /// Seeds, such as 0-9.
    #[arg(long, value_parser = seeds, default_value = "0-9")]
    seeds: (u64, u64),
    /// Without the states that are rates of others: systems that have none are left out.
    #[arg(long)]
    positions: bool,
    /// Seconds a run may take.
    #[arg(long, default_value_t = 60.0)]
    limit: f64,
    /// Write the logs into this folder and identify nothing.
    #[arg(long)]
    export: Option<PathBuf>,
    /// Write the lines to this file.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print the names of the systems and do nothing else.
    #[arg(long)]
    list: bool,
    /// Do one run in this process.
    #[arg(long, hide = true)]
    alone: bool,
}

/// Reads `0-9`, or `3`.
fn seeds(text: &str) -> Result<(u64, u64), std::num::ParseIntError> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    Ok((first.parse()?, last.parse()?))
}

/// Which log.
#[derive(Debug, Clone, Serialize)]
struct Case {
    system: String,
    noise: f64,
    samples: usize,
    seed: u64,
    /// Whether rates were not measured.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    positions: bool,
}

/// One run.
#[derive(Debug, Serialize)]
struct Line {
    #[serde(flatten)]
    case: Case,
    outcome: Outcome,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// Whether the method claims that nothing is left to explain.
    adequate: bool,
    /// Processor time of the identification, all threads together; none where nothing came back.
    seconds: Option<f64>,
    #[serde(flatten)]
    verdict: Verdict,
}

impl Line {
    /// A run without equations.
    fn without(case: Case, outcome: Outcome, reason: Option<String>) -> Self {
        let verdict = Verdict { right: false, coefficient_error: None, deviation: None, equations: Vec::new() };
        Self { case, outcome, reason, adequate: false, seconds: None, verdict }
    }
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let mut out: Box<dyn Write> = match &options.out {
        Some(path) => Box::new(File::create(path).with_context(|| format!("cannot write {}", path.display()))?),
        None => Box::new(io::stdout()),
    };
    if options.list {
        let names: Vec<&str> = systems(options.set).iter().map(System::name).collect();
        writeln!(out, "{}", names.join("\n"))?;
        return Ok(());
    }
    let cases = cases(&options)?;
    for (number, (system, case)) in cases.iter().enumerate() {
        if let Some(folder) = &options.export {
            let log = generate(system, case.samples, case.noise, Seed::new(case.seed))?;
            let stem = format!("{}-{}-{}-{}", case.system, case.noise, case.samples, case.seed);
            export(folder, &stem, system, &log)?;
            continue;
        }
        if options.alone {
            writeln!(out, "{}", serde_json::to_string(&alone(system, case.clone())?)?)?;
            continue;
        }
        let line = watched(case, options.limit)?;
        writeln!(out, "{line}")?;
        out.flush()?;
        progress(number + 1, cases.len(), case, &line)?;
    }
    Ok(())
}

/// Every system with every noise, number of samples and seed.
fn cases(options: &Options) -> anyhow::Result<Vec<(System, Case)>> {
    let named = |name: &String| find(name).with_context(|| format!("there is no system named `{name}`"));
    let chosen = match options.systems.as_slice() {
        [] => systems(options.set),
        names => names.iter().map(named).collect::<anyhow::Result<_>>()?,
    };
    let mut cases = Vec::new();
    for system in chosen.into_iter().filter(|s| !options.positions || s.has_rates()) {
        for &noise in &options.noise {
            for &samples in &options.samples {
                for seed in options.seeds.0..=options.seeds.1 {
                    let case =
                        Case { system: system.name().to_owned(), noise, samples, seed, positions: options.positions };
                    cases.push((system.clone(), case));
                }
            }
        }
    }
    Ok(cases)
}

/// One run in this process.
fn alone(system: &System, case: Case) -> anyhow::Result<Line> {
    let log = generate(system, case.samples, case.noise, Seed::new(case.seed))?;
    let log = if case.positions { log.without_rates() } else { log };
    let judge = Judge::new(system)?;
    let start = ProcessTime::now();
    let found = method::identify(&log);
    let seconds = start.elapsed().as_secs_f64();
    Ok(match found {
        Err(reason) => Line::without(case, Outcome::Refused, Some(format!("{reason:#}"))),
        Ok(found) => Line {
            case,
            outcome: Outcome::Identified,
            reason: None,
            adequate: found.adequate,
            seconds: Some(seconds),
            verdict: judge.judge(&found.equations)?,
        },
    })
}

/// One run in a process of its own, as a line of JSON.
fn watched(case: &Case, limit: f64) -> anyhow::Result<String> {
    let (noise, samples, seed) = (case.noise.to_string(), case.samples.to_string(), case.seed.to_string());
    let arguments = ["--alone", "--systems", &case.system, "--noise", &noise, "--samples", &samples, "--seeds", &seed];
    let arguments = arguments.into_iter().chain(case.positions.then_some("--positions"));
    let ended = child::run(&arguments.map(str::to_owned).collect::<Vec<_>>(), Duration::from_secs_f64(limit))?;
    let without = |outcome, reason| serde_json::to_string(&Line::without(case.clone(), outcome, reason));
    Ok(match ended {
        Ended::Done(text) => text.trim_end().to_owned(),
        Ended::TimedOut => without(Outcome::TimedOut, None)?,
        Ended::Crashed(reason) => without(Outcome::Crashed, Some(reason))?,
    })
}

/// Says on standard error how far it is.
fn progress(number: usize, of: usize, case: &Case, line: &str) -> anyhow::Result<()> {
    let line: serde_json::Value = serde_json::from_str(line)?;
    let said = match (line["outcome"].as_str(), line["right"].as_bool(), line["adequate"].as_bool()) {
        (Some("identified"), Some(true), _) => "right",
        (Some("identified"), _, Some(true)) => "wrong, and claimed adequate",
        (Some("identified"), ..) => "wrong, and said so",
        (Some(outcome), ..) => outcome,
        _ => "unreadable",
    };
    let seconds = line["seconds"].as_f64().map_or(String::new(), |s| format!(", {s:.2} s"));
    let Case { system, noise, samples, seed, .. } = case;
    writeln!(io::stderr(), "{number}/{of} {system} noise {noise} samples {samples} seed {seed}: {said}{seconds}")?;
    Ok(())
}
