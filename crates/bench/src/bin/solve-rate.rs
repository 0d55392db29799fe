//! Trains every task with the defaults on several seeds and tabulates what came of it.
//!
//! Runs `sindyna train TASK --seed S` one after the other. Writes results/OUT.json and results/OUT.md.

use std::io::{self, Write as _};

use clap::Parser;
use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, Sindyna, Trained, count, median, plain, share, study};
use sindyna_record::comparison::Seeds;
use sindyna_report::stats::mean;

#[derive(Debug, Parser)]
struct Options {
    /// Tasks.
    #[arg(long, value_delimiter = ',', default_value = "pendulum,mountain-car,inverted-pendulum,cart-pole")]
    tasks: Vec<String>,
    /// Seeds, such as 10 or 100-199.
    #[arg(long, default_value = "10")]
    seeds: Seeds,
    /// Stem of the two files in results.
    #[arg(long, default_value = "solve-rate")]
    out: String,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Options passed on to `sindyna train`, after --.
    #[arg(last = true)]
    options: Vec<String>,
}

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
struct Figures {
    version: String,
    options: Vec<String>,
    runs: Vec<Run>,
}

/// One run.
#[derive(Debug, Serialize, Deserialize)]
struct Run {
    task: String,
    seed: u64,
    solved: Option<bool>,
    threshold: Option<f64>,
    mean_return: Option<f64>,
    std_return: Option<f64>,
    model_return: Option<f64>,
    real_steps: usize,
    real_episodes: usize,
    updates: u64,
    converged: bool,
    nonzero: Option<usize>,
    equations: Option<Vec<String>>,
    wall_seconds: f64,
    machine: String,
    threads: usize,
}

fn main() -> Result {
    let options = Options::parse();
    let path = format!("results/{}.md", options.out);
    study((&options.out, &path), options.page_only, || measure(&options), |document| Ok(page(document)))
}

fn measure(options: &Options) -> Result<Figures> {
    let sindyna = Sindyna::build()?;
    let folder = tempfile::tempdir()?;
    let mut runs = Vec::new();
    for task in &options.tasks {
        for seed in options.seeds.iter() {
            let out = folder.path().join(format!("{task}-{seed}"));
            let (summary, timing) = match sindyna.train(task, seed, &out, &options.options)? {
                Trained::Done(summary, timing) => (*summary, timing),
                Trained::Refused(reason) => anyhow::bail!("{task} seed {seed}: {reason}"),
            };
            let told = summary.evaluation.as_ref().map(|e| e.mean_return);
            let seconds = timing.wall_seconds;
            writeln!(io::stderr(), "{task} seed {seed}: return {told:?}, solved {:?}, {seconds:.1} s", summary.solved)?;
            runs.push(Run {
                task: task.clone(),
                seed,
                solved: summary.solved,
                threshold: summary.threshold,
                mean_return: told,
                std_return: summary.evaluation.map(|e| e.std_return),
                model_return: summary.training.model_return,
                real_steps: summary.real_steps,
                real_episodes: summary.real_episodes,
                updates: summary.training.updates,
                converged: summary.training.converged,
                nonzero: summary.identification.as_ref().map(|i| i.nonzero),
                equations: summary.identification.map(|i| i.equations),
                wall_seconds: timing.wall_seconds,
                machine: timing.machine,
                threads: timing.threads,
            });
        }
    }
    Ok(Figures { version: sindyna.version()?, options: options.options.clone(), runs })
}

fn page(document: &Document<Figures>) -> String {
    let (made, Figures { version, runs, .. }) = (&document.made, &document.figures);
    let mut tasks: Vec<&str> = runs.iter().map(|run| run.task.as_str()).collect();
    tasks.dedup();
    let solved = count(runs, |run| run.solved == Some(true));
    let row = |task: &&str| {
        let rows: Vec<&Run> = runs.iter().filter(|run| run.task == *task).collect();
        let returns: Vec<f64> = rows.iter().filter_map(|run| run.mean_return).collect();
        let lowest = returns.iter().copied().min_by(f64::total_cmp);
        let seconds = || rows.iter().map(|run| run.wall_seconds);
        let episodes = || rows.iter().map(|run| run.real_episodes);
        let slowest = seconds().max_by(f64::total_cmp);
        vec![
            (*task).to_owned(),
            format!("{} of {}", rows.iter().filter(|run| run.solved == Some(true)).count(), rows.len()),
            rows.iter().map(|run| run.real_steps).max().unwrap_or(0).to_string(),
            format!("{}–{}", episodes().min().unwrap_or(0), episodes().max().unwrap_or(0)),
            format!("{} ({})", plain(mean(&returns)), plain(lowest)),
            plain(rows.first().and_then(|run| run.threshold)),
            median(rows.iter().map(|run| run.updates as f64)).map_or_else(String::new, |u| format!("{u:.0}")),
            format!("{} ({})", plain(median(seconds())), plain(slowest)),
        ]
    };
    let head = [
        "task",
        "solved",
        "real steps",
        "resets",
        "return, mean over seeds (lowest)",
        "threshold",
        "updates, median",
        "seconds, median (largest)",
    ];
    let machine = runs.first().map_or("", |run| run.machine.as_str());
    Page::new("Solved with the defaults")
        .text(&format!("{solved} of {} runs solve their task ({}).", runs.len(), share(solved, runs.len())))
        .table(&head, tasks.iter().map(row))
        .text(&format!("`{}`, {version} ({}), {machine}.", made.command, made.commit))
        .markdown()
}
