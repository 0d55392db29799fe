//! ODEBench: identify from one trajectory, predict another.
//!
//! R² is that of the trajectory identified from (*reconstruction*) and of one from another start (*generalisation*), each simulated
//! from its true start and compared with the clean truth. Every run has a process of its own and a limit on its time. Writes results/odebench.json and
//! docs/odebench.md.

mod page;

use std::io::{self, Write as _};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use clap::Parser;
use cpu_time::ProcessTime;
use page::{Figures, Run, Summary};
use sindyna_bench::child::{self, Ended, Outcome};
use sindyna_bench::method;
use sindyna_bench::odebench::{Problem, Spoilt, compared, problems, r_squared, simulate};
use sindyna_bench::study::{self, count, each};
use sindyna_core::Seed;

/// R² above which a prediction counts as accurate, as in the benchmark's paper.
const ACCURATE: f64 = 0.9;

#[derive(Debug, Parser)]
struct Options {
    /// Numbers of the problems; all of them without.
    #[arg(long, value_delimiter = ',')]
    ids: Vec<u32>,
    /// Noise: x becomes x (1 + noise ε).
    #[arg(long, value_delimiter = ',', default_values_t = [0.0, 0.05])]
    noise: Vec<f64>,
    /// Shares of the samples dropped at random.
    #[arg(long, value_delimiter = ',', default_values_t = [0.0, 0.5])]
    dropped: Vec<f64>,
    /// Seed of noise and drops.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Seconds a run may take.
    #[arg(long, default_value_t = 10.0)]
    limit: f64,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Write another result file and page, for trying.
    #[arg(long, default_value = "odebench")]
    out: String,
    /// Do one run in this process.
    #[arg(long, hide = true)]
    alone: bool,
}

fn main() -> study::Result {
    let options = Options::parse();
    let chosen: Vec<Problem> =
        problems()?.into_iter().filter(|p| options.ids.is_empty() || options.ids.contains(&p.id)).collect();
    if options.alone {
        let problem = chosen.first().context("no such problem")?;
        let spoilt = Spoilt { noise: options.noise[0], dropped: options.dropped[0] };
        writeln!(io::stdout(), "{}", serde_json::to_string(&alone(problem, spoilt, options.seed)?)?)?;
        return Ok(());
    }
    study::study(
        (&options.out, &format!("docs/{}.md", options.out)),
        options.page_only,
        || measure(&chosen, &options),
        page::page,
    )
}

/// All kinds of data, one after the other.
fn measure(problems: &[Problem], options: &Options) -> study::Result<Figures> {
    let mut figures = Figures { limit: options.limit, summaries: Vec::new(), runs: Vec::new() };
    for &noise in &options.noise {
        for &dropped in &options.dropped {
            let spoilt = Spoilt { noise, dropped };
            let begun = Instant::now();
            let runs = each(options.jobs, problems, |problem| {
                let run = watched(problem, spoilt, options)?;
                let told = (run.outcome, run.generalisation);
                writeln!(io::stderr(), "{} noise {noise} dropped {dropped}: {told:?}", run.id)?;
                Ok(run)
            })?;
            let wall = begun.elapsed().as_secs_f64();
            figures.summaries.push(summary(spoilt, &runs, wall, options.jobs));
            figures.runs.extend(runs);
        }
    }
    Ok(figures)
}

/// One run in this process.
fn alone(problem: &Problem, spoilt: Spoilt, seed: u64) -> anyhow::Result<Run> {
    let (Some(own), Some(other)) = (problem.trajectory(0), problem.trajectory(1)) else {
        return Ok(Run::without(problem, spoilt, Outcome::Refused));
    };
    let log = problem.log(&own, spoilt, &mut Seed::new(seed).stream("odebench", u64::from(problem.id)));
    let start = ProcessTime::now();
    let found = method::identify(&log);
    let seconds = start.elapsed().as_secs_f64();
    let Ok(found) = found else { return Ok(Run::without(problem, spoilt, Outcome::Refused)) };
    let score = |which: usize, truth| {
        let predicted = simulate(&*found.dynamics, &problem.starts[which], problem.times.len())?;
        study::rounded(r_squared(truth, &predicted))
    };
    let (recovered, deviation) = compared(problem, &found.equations, [&own, &other])?;
    Ok(Run {
        adequate: found.adequate,
        recovered,
        deviation: study::rounded(deviation),
        reconstruction: score(0, &own),
        generalisation: score(1, &other),
        seconds: study::rounded(seconds),
        ..Run::without(problem, spoilt, Outcome::Identified)
    })
}

/// One run in a process of its own.
fn watched(problem: &Problem, spoilt: Spoilt, options: &Options) -> anyhow::Result<Run> {
    let (id, noise, dropped) = (problem.id.to_string(), spoilt.noise.to_string(), spoilt.dropped.to_string());
    let seed = options.seed.to_string();
    let arguments = ["--alone", "--ids", &id, "--noise", &noise, "--dropped", &dropped, "--seed", &seed];
    let ended = child::run(&arguments.map(str::to_owned), Duration::from_secs_f64(options.limit))?;
    Ok(match ended {
        Ended::Done(text) => serde_json::from_str(&text)?,
        Ended::TimedOut => Run::without(problem, spoilt, Outcome::TimedOut),
        Ended::Crashed(_) => Run::without(problem, spoilt, Outcome::Crashed),
    })
}

/// What the runs of one kind of data come to; a run without equations counts as not accurate.
fn summary(spoilt: Spoilt, runs: &[Run], wall_seconds: f64, jobs: usize) -> Summary {
    let accurate = |of: fn(&Run) -> Option<f64>| {
        count(runs, |run| of(run).is_some_and(|r| r > ACCURATE)) as f64 / runs.len().max(1) as f64
    };
    let ended = |outcome| count(runs, |run| run.outcome == outcome);
    Summary {
        noise: spoilt.noise,
        dropped: spoilt.dropped,
        problems: runs.len(),
        reconstruction_accurate: accurate(|run| run.reconstruction),
        generalisation_accurate: accurate(|run| run.generalisation),
        recovered: count(runs, |run| run.recovered),
        adequate: count(runs, |run| run.adequate),
        adequate_but_not_recovered: count(runs, |run| run.adequate && !run.recovered),
        refused: ended(Outcome::Refused),
        timed_out: ended(Outcome::TimedOut),
        crashed: ended(Outcome::Crashed),
        seconds: runs.iter().filter_map(|run| run.seconds).sum(),
        wall_seconds,
        jobs,
    }
}
