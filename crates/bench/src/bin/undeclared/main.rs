//! Identification from data whose noise nobody declares: how often right, how often wrong without saying so.
//!
//! Generates logs, gives them to the method and holds what comes back against the truth. Every run has a process of its own and a limit on its time. Writes
//! results/undeclared.json (with `--set functions` results/undeclared-functions.json, with `--set absolute` results/undeclared-absolute.json, with `--positions`
//! results/undeclared-positions.json) and docs/undeclared.md; on the development set, of which nothing is reported, it prints its tables instead. What was run before is
//! taken from runs/undeclared; delete that folder after a change of the identifier. What PySINDy makes of the same logs is added to the page where its results are
//! there. With `--export` the logs are written as files instead, and nothing is identified.

mod page;

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use clap::Parser;
use page::{Figures, Group};
use sindyna_bench::study::{Document, Result, each, kept, load, study};
use sindyna_bench::undeclared::{Case, Run, Set, System, export, find, generate, systems};
use sindyna_core::Seed;
use sindyna_record::comparison::Seeds;

#[derive(Debug, Parser)]
struct Options {
    /// Which systems.
    #[arg(long, value_enum, default_value_t = Set::Reported)]
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
    /// Seeds, such as 10 or 0-9,100-199.
    #[arg(long, default_value = "10")]
    seeds: Seeds,
    /// Without the states that are rates of others: systems that have none are left out.
    #[arg(long)]
    positions: bool,
    /// Seconds a run may take.
    #[arg(long, default_value_t = 60.0)]
    limit: f64,
    /// Runs at a time; times are those of one.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Print the tables, and write no result.
    #[arg(long)]
    print: bool,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Write the logs into this folder and identify nothing.
    #[arg(long)]
    export: Option<PathBuf>,
    /// Do one run in this process.
    #[arg(long, hide = true)]
    alone: Option<String>,
}

fn main() -> Result {
    let options = Options::parse();
    if let Some(case) = &options.alone {
        let case: Case = serde_json::from_str(case)?;
        let run = Run::of(&named(&case.system)?, case)?;
        return Ok(writeln!(io::stdout(), "{}", serde_json::to_string(&run)?)?);
    }
    if let Some(folder) = &options.export {
        return write_logs(folder, &options);
    }
    if options.print || options.set == Set::Development {
        return Ok(writeln!(io::stdout(), "{}", page::tables(&measure(&options)?.groups))?);
    }
    let stem = match (options.positions, options.set) {
        (true, _) => page::POSITIONS,
        (false, Set::Functions) => page::FUNCTIONS,
        (false, Set::Absolute) => page::ABSOLUTE,
        (false, _) => page::REPORTED,
    };
    study(
        (stem, "docs/undeclared.md"),
        options.page_only,
        || measure(&options),
        |_: &Document<Figures>| {
            let reported = load(page::REPORTED)?.context("there is no results/undeclared.json")?;
            page::page(&reported)
        },
    )
}

/// The system called `name`.
fn named(name: &str) -> Result<System> {
    find(name).with_context(|| format!("there is no system named `{name}`"))
}

/// System, noise, samples: those of one group.
fn cells(options: &Options) -> Result<Vec<(System, f64, usize)>> {
    let chosen = match options.systems.as_slice() {
        [] => systems(options.set),
        names => names.iter().map(|name| named(name)).collect::<Result<_>>()?,
    };
    let mut cells = Vec::new();
    for system in chosen.into_iter().filter(|s| !options.positions || s.has_rates()) {
        for &noise in &options.noise {
            cells.extend(options.samples.iter().map(|&samples| (system.clone(), noise, samples)));
        }
    }
    Ok(cells)
}

fn write_logs(folder: &std::path::Path, options: &Options) -> Result {
    for (system, noise, samples) in cells(options)? {
        for seed in options.seeds.iter() {
            let log = generate(&system, samples, noise, Seed::new(seed))?;
            export(folder, &format!("{}-{noise}-{samples}-{seed}", system.name()), &system, &log)?;
        }
    }
    Ok(())
}

fn measure(options: &Options) -> Result<Figures> {
    let cells = cells(options)?;
    let groups = each(options.jobs, &cells, |(system, noise, samples)| {
        let name = system.name();
        let positions = if options.positions { "positions-" } else { "" };
        let stem = format!("{positions}{name}-{noise}-{samples}-{}-{}", options.seeds, options.limit);
        let runs = kept(PathBuf::from("docs/undeclared.md").join(stem + ".json"), || {
            let case = |seed| Case {
                system: name.into(),
                noise: *noise,
                samples: *samples,
                seed,
                positions: options.positions,
            };
            let run = |seed| Run::watched(&case(seed), Duration::from_secs_f64(options.limit));
            options.seeds.iter().map(run).collect::<Result<Vec<Run>>>()
        })?;
        let group = Group::of(&runs);
        writeln!(io::stderr(), "{name} noise {noise} samples {samples}: {}", group.shown())?;
        Ok(group)
    })?;
    Ok(Figures { limit: options.limit, groups })
}
