//! Controllers under noise that nobody declares: how often a task is solved, how many real steps it takes, and whether the prediction holds.
//!
//! Runs `sindyna train TASK --noise F --real-steps R --seed S` with the defaults for every task, noise, number of first real steps and seed.
//! Writes results/OUT.json and docs/OUT.md. What was run before is taken from runs/loop; delete that folder after a change of the
//! identifier or the trainer.

mod page;

use std::io::{self, Write as _};
use std::path::Path;

use clap::Parser;
use page::{Figures, Group, Middle, Run};
use sindyna_bench::study::{Result, Sindyna, Trained, count, each, median, root, rounded, study};
use sindyna_record::comparison::Seeds;

#[derive(Debug, Parser)]
struct Options {
    /// Tasks, or task files.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "cart-pole,mountain-car,pendulum,inverted-pendulum,cart-pole-swing-up"
    )]
    tasks: Vec<String>,
    /// Noise, as parts of each channel's scale.
    #[arg(long, value_delimiter = ',', default_value = "0,0.001,0.01,0.05")]
    noises: Vec<f64>,
    /// Numbers of first real steps; without noise only the least of them, since nothing is gained by more.
    #[arg(long, value_delimiter = ',', default_value = "10,100,300,1000")]
    steps: Vec<usize>,
    /// Seeds, such as 20 or 0-9,100-199.
    #[arg(long, default_value = "20")]
    seeds: Seeds,
    /// Runs at a time, a thread each.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "loop")]
    out: String,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Options passed on to `sindyna train`, after --.
    #[arg(last = true)]
    options: Vec<String>,
}

/// Task, noise, first real steps.
type Cell = (String, f64, usize);

fn main() -> Result {
    let options = Options::parse();
    study((&options.out, &format!("docs/{}.md", options.out)), options.page_only, || measure(&options), page::page)
}

fn measure(options: &Options) -> Result<Figures> {
    let sindyna = Sindyna::build()?;
    let least = options.steps.iter().copied().min();
    let mut cells: Vec<Cell> = Vec::new();
    for task in &options.tasks {
        for &noise in &options.noises {
            let steps = options.steps.iter().filter(|r| noise > 0.0 || Some(**r) == least);
            cells.extend(steps.map(|r| (task.clone(), noise, *r)));
        }
    }
    let cases: Vec<(&Cell, u64)> = cells.iter().flat_map(|cell| options.seeds.iter().map(move |s| (cell, s))).collect();
    let runs = each(options.jobs, &cases, |(cell, seed)| train(&sindyna, cell, *seed, &options.options))?;
    let groups = cells.iter().zip(runs.chunks(options.seeds.count().max(1))).map(|(cell, runs)| summary(cell, runs));
    Ok(Figures {
        stem: options.out.clone(),
        options: options.options.clone(),
        groups: groups.collect(),
        notes: Vec::new(),
    })
}

/// What a task is called, where it is a task file: by that.
fn name(task: &str) -> String {
    Path::new(task).file_stem().map_or_else(|| task.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// What came of a training run, from its record if it was run before.
fn train(sindyna: &Sindyna, (task, noise, steps): &Cell, seed: u64, options: &[String]) -> Result<Run> {
    let out = root().join("runs/loop").join(format!("{}-{noise}-{steps}-{seed}", name(task)));
    let fixed =
        ["--noise", &noise.to_string(), "--real-steps", &steps.to_string(), "--threads", "1"].map(str::to_owned);
    let done = sindyna.train(task, seed, &out, &[&fixed, options].concat())?;
    let (summary, timing) = match done {
        Trained::Refused(reason) => return Ok(Run { seed, refused: Some(reason), ..Run::default() }),
        Trained::Done(summary, timing) => (summary, timing),
    };
    let mean_return = summary.evaluation.map(|e| e.mean_return);
    let prediction = summary.training.prediction.map(|p| [p.mean, p.low, p.high]);
    let run = Run {
        seed,
        mean_return,
        solved: summary.solved,
        threshold: summary.threshold,
        real_steps: summary.real_steps,
        real_episodes: summary.real_episodes,
        updates: summary.training.updates,
        prediction,
        held: prediction.zip(mean_return).is_some_and(|([_, low, high], r)| low - 1e-9 <= r && r <= high + 1e-9),
        agrees: summary.training.confirmation.map(|c| c.agrees),
        seconds: timing.wall_seconds,
        refused: None,
    };
    writeln!(io::stderr(), "{}: return {mean_return:?}, solved {:?}", out.display(), run.solved)?;
    Ok(run)
}

/// Whether the run said beforehand that the task may not be solved: its interval reaches below the threshold, or its confirmation episode disagreed.
fn warned(run: &Run) -> bool {
    let below = |[_, low, _]: [f64; 3]| run.threshold.is_none_or(|threshold| low < threshold);
    run.prediction.is_none_or(below) || run.agrees == Some(false)
}

fn summary((task, noise, steps): &Cell, runs: &[Run]) -> Group {
    let done: Vec<&Run> = runs.iter().filter(|run| run.refused.is_none()).collect();
    // Task files without `solved_at` have nothing to fail at.
    let failed = done.iter().filter(|run| run.solved == Some(false) || run.mean_return.is_none());
    let middle = |of: fn(&Run) -> usize| Middle {
        median: median(done.iter().map(|run| of(run) as f64)),
        most: done.iter().map(|run| of(run)).max(),
    };
    let returns = || done.iter().filter_map(|run| run.mean_return);
    let number = |holds: fn(&Run) -> bool| count(done.iter().copied(), holds);
    Group {
        task: name(task),
        noise: *noise,
        steps: *steps,
        seeds: runs.len(),
        refused: runs.len() - done.len(),
        solved: number(|run| run.solved == Some(true)),
        target: done.iter().any(|run| run.threshold.is_some()),
        failed_without_a_word: failed.clone().filter(|run| !warned(run)).map(|run| run.seed).collect(),
        failed: failed.map(|run| run.seed).collect(),
        median_return: median(returns()).and_then(rounded),
        lowest_return: returns().min_by(f64::total_cmp).and_then(rounded),
        real_steps: middle(|run| run.real_steps),
        real_episodes: middle(|run| run.real_episodes),
        predicted: number(|run| run.prediction.is_some()),
        held: number(|run| run.held),
        confirmations: number(|run| run.agrees.is_some()),
        agreed: number(|run| run.agrees == Some(true)),
        median_updates: median(done.iter().map(|run| run.updates as f64)),
        median_seconds: median(done.iter().map(|run| run.seconds)).and_then(rounded),
        runs: runs.to_vec(),
    }
}
