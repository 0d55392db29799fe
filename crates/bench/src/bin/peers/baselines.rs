//! Our model-free baseline beside Stable-Baselines3's SAC with the same settings: real steps until solved, and what is reached.

use std::fs;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::bail;
use serde_json::{Map, Value, json};
use sindyna_bench::study::{Result, Sindyna, each, kept, load, root};
use sindyna_report::stats::{interval, mean, median};

use crate::ask::Peers;

/// Runs `sindyna compare --methods sac`, reads the settings it left, and trains Stable-Baselines3 with them under the same protocol: checks of a hundred episodes from new start
/// states at the same intervals, solved at the first that reaches the threshold, a hundred episodes at the end. Steps do not depend on how busy the machine is. What is done is
/// kept in runs/baselines; in the result file other tasks stay as they are.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Tasks.
    #[arg(long, value_delimiter = ',', default_value = "pendulum,mountain-car,inverted-pendulum")]
    tasks: Vec<String>,
    /// So many seeds, from 0.
    #[arg(long, default_value_t = 20)]
    seeds: u64,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Stem of the file in results.
    #[arg(long, default_value = "baselines")]
    out: String,
    #[command(flatten)]
    peers: Peers,
}

pub(crate) fn measure(options: &Options) -> Result {
    let sindyna = Sindyna::build()?;
    let folder = root().join("runs/baselines/ours");
    let (seeds, jobs) = (options.seeds.to_string(), options.jobs.to_string());
    let mut compare = Command::new(sindyna.path());
    compare.args(["compare", "--methods", "sac", "--tasks", &options.tasks.join(",")]);
    compare.args(["--seeds", &seeds, "--threads", &jobs, "--out"]).arg(&folder).stdout(Stdio::null());
    if !compare.status()?.success() {
        bail!("the comparison failed");
    }
    let earlier: Option<Value> = load(&options.out)?;
    let mut tasks = earlier.and_then(|e| e["tasks"].as_object().cloned()).unwrap_or_default();
    let made_by: toml::Table = fs::read_to_string(folder.join("compare.toml"))?.parse()?;
    for task in &options.tasks {
        let of_task = folder.join("runs").join(task).join("sac");
        let settings: toml::Table = fs::read_to_string(of_task.join("settings.toml"))?.parse()?;
        let settings = serde_json::to_value(settings)?;
        let seeds: Vec<u64> = (0..options.seeds).collect();
        let own = |seed: &u64| -> Result<Value> {
            let text = fs::read_to_string(of_task.join(format!("seed-{seed}.json")))?;
            let outcome: Value = serde_json::from_str(&text)?;
            let returns: Vec<f64> = serde_json::from_value(outcome["returns"].clone())?;
            Ok(json!({"seed": seed, "solved_after": outcome["solved_after"], "return": mean(&returns)}))
        };
        let ours = seeds.iter().map(own).collect::<Result<Vec<_>>>()?;
        let theirs = each(options.jobs, &seeds, |seed| {
            let path = PathBuf::from("baselines/sb3").join(task).join(format!("seed-{seed}.json"));
            let run: Value =
                kept(path, || options.peers.ask(&["baseline", task, &seed.to_string(), &settings.to_string()]))?;
            writeln!(io::stderr(), "sb3 {task} seed {seed}: {}, {}", run["solved_after"], run["return"])?;
            Ok(run)
        })?;
        tasks.insert(
            task.clone(),
            compared((task, options.seeds), &ours, &theirs, json!({"made_by": made_by, "settings": settings})),
        );
    }
    options.peers.store(&options.out, json!({"tasks": tasks}))
}

/// Of two lists of runs.
fn compared((task, seeds): (&str, u64), ours: &[Value], theirs: &[Value], known: Value) -> Value {
    // A run that never solves the task needs infinitely many steps.
    let steps =
        |runs: &[Value]| runs.iter().map(|r| r["solved_after"].as_f64().unwrap_or(f64::INFINITY)).collect::<Vec<_>>();
    let returns = |runs: &[Value]| runs.iter().filter_map(|r| r["return"].as_f64()).collect::<Vec<_>>();
    let ratio = |of: &[Vec<f64>]| {
        let (a, b) = (median(&of[0])?, median(&of[1])?);
        // Where both never solve it, neither needs more steps.
        Some(if a.total_cmp(&b).is_eq() { 1.0 } else { a / b })
    };
    let [(a, b), (x, y)] = [(steps(ours), steps(theirs)), (returns(ours), returns(theirs))];
    let ends = |found: Option<sindyna_report::stats::Interval>| found.map(|i| [i.low, i.high]);
    let found = json!({
        "command": format!("cargo run --release -p sindyna-bench --bin peers -- baselines --tasks {task} --seeds {seeds}"),
        "sindyna": ours, "stable_baselines3": theirs, "median_steps": [median(&a), median(&b)],
        "ratio_interval": ends(interval(&[&a, &b], ratio)), "mean_return": [mean(&x), mean(&y)],
        "return_difference_interval": ends(interval(&[&x, &y], |of| Some(mean(&of[0])? - mean(&of[1])?))),
        "ratio_of_medians": ratio(&[a, b]),
    });
    let (mut all, found) =
        (known.as_object().cloned().unwrap_or_default(), found.as_object().cloned().unwrap_or_default());
    all.extend(found);
    Value::Object(Map::from_iter(all))
}
