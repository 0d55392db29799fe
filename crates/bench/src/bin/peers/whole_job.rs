//! The whole job, `sindyna train` against a pipeline of PySINDy and an agent, until the task is solved.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Instant;

use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sindyna_bench::study::{Result, Sindyna, Spread, count, kept, median, pinned};
use sindyna_record::comparison::Seeds;
use sindyna_record::run::{Summary, Timing};

use crate::ask::{Peers, number};

const BACKENDS: [&str; 2] = ["sb3", "sbx"];

/// What the peers learn with: hidden width and batch of the pipeline's agents.
const SIZES: [(&str, usize, usize); 4] =
    [("pendulum", 256, 256), ("mountain-car", 64, 512), ("inverted-pendulum", 256, 256), ("cart-pole", 64, 256)];

/// One core each, in turn: ours, a peer, ours, the other peer, for every seed. Ours is the whole process, with an evaluation of 100 real episodes; a peer's seconds leave out
/// its imports and its evaluations on the real system, and end at the first of those (10 episodes) at or above the threshold. On cart-pole, which has numbered actions, the peers
/// are PPO; DQN took longer when tried. At equal networks: ours again, once per seed, with the peer's hidden layers and batch. What was run before is taken from runs/whole-job.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Tasks.
    #[arg(long, value_delimiter = ',', default_value = "pendulum,mountain-car,inverted-pendulum,cart-pole")]
    tasks: Vec<String>,
    /// Seeds, such as 5 or 0-9,100-199.
    #[arg(long, default_value = "5")]
    seeds: Seeds,
    /// Seconds after which a peer is given up: it counts as infinite, as the cap in ratios.
    #[arg(long, default_value_t = 45.0)]
    cap: f64,
    /// Stem of the file in results.
    #[arg(long, default_value = "whole-job")]
    out: String,
    #[command(flatten)]
    peers: Peers,
}

/// A run of ours.
#[derive(Debug, Serialize, Deserialize)]
struct Ours {
    /// None if the system was not solved.
    seconds: Option<f64>,
    updates: u64,
    mean_return: Option<f64>,
    identify: f64,
    train: f64,
    evaluate: f64,
}

/// All runs of a seed.
#[derive(Debug, Serialize, Deserialize)]
struct Runs {
    /// Before each peer.
    ours: Vec<Ours>,
    /// Seconds; none after the cap.
    peers: BTreeMap<String, Option<f64>>,
    equal: Ours,
}

pub(crate) fn measure(options: &Options) -> Result {
    let sindyna = Sindyna::build()?;
    let tasks = options.tasks.iter().map(|task| of_task(&sindyna, task, options)).collect::<Result<Vec<_>>>()?;
    options.peers.store(&options.out, json!({"cap_seconds": options.cap, "tasks": tasks}))
}

fn of_task(sindyna: &Sindyna, task: &str, options: &Options) -> Result<Value> {
    let sizes = SIZES.iter().find(|(name, ..)| *name == task).with_context(|| format!("no peer learns {task}"))?;
    let (_, width, batch) = *sizes;
    let mut runs = Vec::new();
    for seed in options.seeds.iter() {
        let path = PathBuf::from("whole-job").join(format!("{task}-{seed}.json"));
        let found: Runs = kept(path, || one_seed(sindyna, (task, seed), (width, batch), options))?;
        writeln!(io::stderr(), "{task} seed {seed}: {found:?}")?;
        runs.push(found);
    }
    Ok(summary(task, (width, batch), &runs, options.cap))
}

fn one_seed(
    sindyna: &Sindyna,
    (task, seed): (&str, u64),
    (width, batch): (usize, usize),
    options: &Options,
) -> Result<Runs> {
    let (mut own, mut peers) = (Vec::new(), BTreeMap::new());
    for backend in BACKENDS {
        own.push(ours(sindyna, task, seed, options.peers.core, &[])?);
        let (seed, cap) = (seed.to_string(), options.cap.to_string());
        let last = options.peers.ask(&["pipeline", task, "--seed", &seed, "--backend", backend, "--seconds", &cap])?;
        let seconds = if last["solved"] == true { Some(number(&last, "wall_s")?) } else { None };
        peers.insert(backend.to_owned(), seconds);
    }
    let (hidden, batch) = (format!("sac.hidden=[{width},{width}]"), batch.to_string());
    let equal = ours(sindyna, task, seed, options.peers.core, &["--set", &hidden, "--batch-size", &batch])?;
    Ok(Runs { ours: own, peers, equal })
}

/// Seconds of the process, and what the record says.
fn ours(sindyna: &Sindyna, task: &str, seed: u64, core: usize, options: &[&str]) -> Result<Ours> {
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("run");
    let begun = Instant::now();
    let train = sindyna.training(task, seed, &out, &[&["--threads", "1"], options].concat());
    pinned(&train, core).stdout(Stdio::null()).stderr(Stdio::null()).status()?;
    let seconds = begun.elapsed().as_secs_f64();
    let summary = Summary::from_json(&fs::read_to_string(out.join("summary.json"))?)?;
    let timing: Timing = serde_json::from_str(&fs::read_to_string(out.join("timing.json"))?)?;
    Ok(Ours {
        seconds: (summary.solved == Some(true)).then_some(seconds),
        updates: summary.training.updates,
        mean_return: summary.evaluation.map(|e| e.mean_return),
        identify: timing.identify_seconds,
        train: timing.train_seconds,
        evaluate: timing.evaluate_seconds,
    })
}

/// What is not there is infinite.
fn infinite(seconds: Option<f64>) -> f64 {
    seconds.unwrap_or(f64::INFINITY)
}

fn summary(task: &str, (width, batch): (usize, usize), runs: &[Runs], cap: f64) -> Value {
    let own: Vec<&Ours> = runs.iter().flat_map(|run| &run.ours).collect();
    let of =
        |backend: &str| runs.iter().map(|run| infinite(run.peers.get(backend).copied().flatten())).collect::<Vec<_>>();
    let total = |backend: &str| of(backend).iter().map(|seconds| seconds.min(cap)).sum::<f64>();
    let middle = |backend: &str| median(of(backend)).unwrap_or(f64::INFINITY);
    let before = |a: &&str, b: &&str| middle(a).total_cmp(&middle(b)).then(total(a).total_cmp(&total(b)));
    let better = BACKENDS.into_iter().min_by(before).unwrap_or(BACKENDS[0]);
    let place = BACKENDS.iter().position(|backend| *backend == better).unwrap_or(0);
    // Over seeds, each of runs that were neighbours: what else the machine does differs more than seeds do.
    let ratio = |mine: &dyn Fn(&Runs) -> f64| {
        let one = |(run, peer): (&Runs, f64)| peer.min(cap) / mine(run);
        Spread::of(&runs.iter().zip(of(better)).map(one).collect::<Vec<_>>())
    };
    let part = |of: fn(&Ours) -> f64| Spread::of(&own.iter().map(|run| of(run)).collect::<Vec<_>>());
    let equal: Vec<f64> = runs.iter().map(|run| infinite(run.equal.seconds)).collect();
    let updates: Vec<f64> = runs.iter().map(|run| run.equal.updates as f64).collect();
    let mut at_equal = described(&equal, None);
    at_equal["hidden"] = json!([width, width]);
    at_equal["batch"] = json!(batch);
    at_equal["ratio"] = json!(ratio(&|run| infinite(run.equal.seconds)));
    at_equal["updates"] = json!(Spread::of(&updates));
    json!({
        "task": task,
        "ours": described(&own.iter().map(|run| infinite(run.seconds)).collect::<Vec<_>>(), None),
        "peers": BACKENDS.map(|backend| (backend, described(&of(backend), Some(cap)))).into_iter().collect::<BTreeMap<_, _>>(),
        "better_peer": better,
        "ratio": ratio(&|run| infinite(run.ours[place].seconds)),
        "ratio_is_at_least": middle(better).is_infinite(),
        "parts_of_ours": {"identify": part(|run| run.identify), "train": part(|run| run.train), "evaluate": part(|run| run.evaluate)},
        "updates_of_ours": part(|run| run.updates as f64),
        "mean_returns_of_ours": runs.iter().map(|run| run.ours[0].mean_return).collect::<Vec<_>>(),
        "equal": at_equal,
    })
}

/// Median and range of seconds; what was not solved is null, `more_than` the cap.
fn described(seconds: &[f64], cap: Option<f64>) -> Value {
    let solved = count(seconds, |s| s.is_finite());
    let mut found = json!(Spread::of(seconds));
    found["solved"] = json!(solved);
    found["runs"] = json!(seconds.len());
    found["more_than"] = json!(cap.filter(|_| solved < seconds.len()));
    found
}
