//! ODEBench: identify from one trajectory, predict another. One JSON line per run, then one summary per kind of data.
//!
//! R² is that of the trajectory identified from (*reconstruction*) and of one from another start (*generalisation*), each simulated
//! from its true start and compared with the clean truth. Every run has a process of its own and a limit on its time.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use clap::Parser;
use cpu_time::ProcessTime;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};
use sindyna_bench::child::{self, Ended, Outcome};
use sindyna_bench::method;
use sindyna_bench::odebench::{Problem, Spoilt, compared, problems, r_squared, simulate};
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
    #[arg(long, default_value_t = 60.0)]
    limit: f64,
    /// Runs at a time; as many as there are processors without.
    #[arg(long)]
    jobs: Option<usize>,
    /// Do one run in this process.
    #[arg(long, hide = true)]
    alone: bool,
}

/// One run.
#[derive(Debug, Serialize)]
struct Line {
    id: u32,
    description: String,
    noise: f64,
    dropped: f64,
    outcome: Outcome,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// Whether the method claims that nothing is left to explain.
    adequate: bool,
    /// Whether the true rates satisfy the equations found.
    recovered: bool,
    /// RMS error of the rates over the box of both trajectories, as part of their spread, in the worst equation.
    deviation: Option<f64>,
    /// R² of the trajectory identified from; none where the simulation does not stay finite.
    reconstruction: Option<f64>,
    /// R² of the other.
    generalisation: Option<f64>,
    /// Processor time of the identification.
    seconds: Option<f64>,
    /// Terms of each equation with their coefficients.
    equations: Vec<Vec<(String, f64)>>,
}

impl Line {
    fn without(problem: &Problem, spoilt: Spoilt, outcome: Outcome, reason: Option<String>) -> Self {
        Self {
            id: problem.id,
            description: problem.description.clone(),
            noise: spoilt.noise,
            dropped: spoilt.dropped,
            outcome,
            reason,
            adequate: false,
            recovered: false,
            deviation: None,
            reconstruction: None,
            generalisation: None,
            seconds: None,
            equations: Vec::new(),
        }
    }
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let chosen: Vec<Problem> =
        problems()?.into_iter().filter(|p| options.ids.is_empty() || options.ids.contains(&p.id)).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs.unwrap_or(0)).build()?;
    let mut out = io::stdout().lock();
    for &noise in &options.noise {
        for &dropped in &options.dropped {
            let spoilt = Spoilt { noise, dropped };
            if options.alone {
                let problem = chosen.first().context("no such problem")?;
                writeln!(out, "{}", serde_json::to_string(&alone(problem, spoilt, options.seed)?)?)?;
                return Ok(());
            }
            let begun = Instant::now();
            let one = |problem: &Problem| -> anyhow::Result<Value> {
                let line = watched(problem, spoilt, &options)?;
                writeln!(
                    io::stderr(),
                    "{} {} noise {noise} dropped {dropped}: {}, generalisation {}",
                    problem.id,
                    problem.description,
                    line["outcome"],
                    line["generalisation"]
                )?;
                Ok(line)
            };
            // One after the other, whoever is free: some take a thousand times as long as others.
            let lines: Vec<Value> =
                pool.install(|| chosen.par_iter().with_max_len(1).map(one).collect::<anyhow::Result<_>>())?;
            let wall = begun.elapsed().as_secs_f64();
            lines.iter().try_for_each(|line| writeln!(out, "{line}"))?;
            writeln!(out, "{}", json!({"summary": summary(spoilt, &lines, (wall, pool.current_num_threads()))}))?;
            out.flush()?;
        }
    }
    Ok(())
}

/// One run in this process.
fn alone(problem: &Problem, spoilt: Spoilt, seed: u64) -> anyhow::Result<Line> {
    let refused = |reason: String| Line::without(problem, spoilt, Outcome::Refused, Some(reason));
    let (Some(own), Some(other)) = (problem.trajectory(0), problem.trajectory(1)) else {
        return Ok(refused("the true system does not stay finite".into()));
    };
    let log = problem.log(&own, spoilt, &mut Seed::new(seed).stream("odebench", u64::from(problem.id)));
    let start = ProcessTime::now();
    let found = method::identify(&log);
    let seconds = start.elapsed().as_secs_f64();
    let found = match found {
        Ok(found) => found,
        Err(reason) => return Ok(refused(format!("{reason:#}"))),
    };
    let score = |which: usize, truth| {
        let predicted = simulate(&*found.dynamics, &problem.starts[which], problem.times.len())?;
        Some(r_squared(truth, &predicted)).filter(|r| r.is_finite())
    };
    let named = |row: &Vec<sindyna_bench::Term>| row.iter().map(|t| (t.label(&log.states), t.coefficient)).collect();
    let (recovered, deviation) = compared(problem, &found.equations, [&own, &other])?;
    Ok(Line {
        adequate: found.adequate,
        recovered,
        deviation: Some(deviation).filter(|d| d.is_finite()),
        reconstruction: score(0, &own),
        generalisation: score(1, &other),
        seconds: Some(seconds),
        equations: found.equations.iter().map(named).collect(),
        ..Line::without(problem, spoilt, Outcome::Identified, None)
    })
}

/// One run in a process of its own.
fn watched(problem: &Problem, spoilt: Spoilt, options: &Options) -> anyhow::Result<Value> {
    let (id, noise, dropped) = (problem.id.to_string(), spoilt.noise.to_string(), spoilt.dropped.to_string());
    let seed = options.seed.to_string();
    let arguments = ["--alone", "--ids", &id, "--noise", &noise, "--dropped", &dropped, "--seed", &seed];
    let ended = child::run(&arguments.map(str::to_owned), Duration::from_secs_f64(options.limit))?;
    let without = |outcome, reason| serde_json::to_value(Line::without(problem, spoilt, outcome, reason));
    Ok(match ended {
        Ended::Done(text) => serde_json::from_str(&text)?,
        Ended::TimedOut => without(Outcome::TimedOut, None)?,
        Ended::Crashed(reason) => without(Outcome::Crashed, Some(reason))?,
    })
}

/// What the lines of one kind of data come to; a run without equations counts as not accurate.
fn summary(spoilt: Spoilt, lines: &[Value], (wall, jobs): (f64, usize)) -> Value {
    let share = |of: &dyn Fn(&Value) -> bool| lines.iter().filter(|line| of(line)).count() as f64 / lines.len() as f64;
    let accurate = |of: &'static str| share(&|line| line[of].as_f64().is_some_and(|r| r > ACCURATE));
    let count = |of: &dyn Fn(&Value) -> bool| lines.iter().filter(|line| of(line)).count();
    let is = |of: &'static str, outcome: &'static str| count(&|line| line[of] == outcome);
    json!({
        "noise": spoilt.noise,
        "dropped": spoilt.dropped,
        "problems": lines.len(),
        "reconstruction_accurate": accurate("reconstruction"),
        "generalisation_accurate": accurate("generalisation"),
        "recovered": count(&|line| line["recovered"] == true),
        "adequate": count(&|line| line["adequate"] == true),
        "adequate_but_not_recovered": count(&|line| line["adequate"] == true && line["recovered"] == false),
        "refused": is("outcome", "refused"),
        "timed_out": is("outcome", "timed-out"),
        "crashed": is("outcome", "crashed"),
        "seconds": lines.iter().filter_map(|line| line["seconds"].as_f64()).sum::<f64>(),
        "wall_seconds": wall,
        "jobs": jobs,
    })
}
