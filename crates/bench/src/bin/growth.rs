//! How cost grows: an update with the width of the networks and with the batch, a model step with the number of its terms, and runs with the number of seeds on one core
//! and on two.
//!
//! Sizes are measured in turn, so that only ratios within a table mean anything. Writes results/OUT.json; the program `performance` makes the page.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::bail;
use clap::Parser;
use serde::Serialize;
use serde_json::{Value, json};
use sindyna_bench::study::{Result, Sindyna, Spread, built, each, pinned, store};

const TERMS: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
const SEEDS: [u64; 4] = [1, 2, 4, 8];

/// Development seeds begin here.
const FIRST_SEED: u64 = 1000;

#[derive(Debug, Parser)]
struct Options {
    /// How often everything is measured.
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// The core on which updates and model steps are measured.
    #[arg(long, default_value_t = 1)]
    core: usize,
    /// Stem of the file in results.
    #[arg(long, default_value = "growth")]
    out: String,
}

#[derive(Debug, Serialize)]
struct Figures {
    updates: Vec<Value>,
    model_steps: Vec<Value>,
    seeds: Vec<Value>,
}

fn main() -> Result {
    let options = Options::parse();
    let release = built(&["-p", "sindyna", "-p", "sindyna-bench", "-p", "sindyna-rl", "--bins", "--examples"])?;
    let sindyna = Sindyna::at(&release.join("sindyna"));
    let examples = release.join("examples");
    let figures = Figures {
        seeds: seeds(&sindyna, options.rounds)?,
        updates: updates(&examples, &options)?,
        model_steps: model_steps(&examples, &options)?,
    };
    store(&options.out, figures)
}

/// The JSON lines that `command` prints, once per round.
fn rounds(command: &Command, options: &Options) -> Result<Vec<Vec<Value>>> {
    let round = |_| {
        let done = pinned(command, options.core).output()?;
        if !done.status.success() {
            bail!("{command:?} failed: {}", String::from_utf8_lossy(&done.stderr));
        }
        let text = String::from_utf8(done.stdout)?;
        text.lines().map(|line| Ok(serde_json::from_str(line)?)).collect()
    };
    (0..options.rounds).map(round).collect()
}

/// Of one number in the same line of every round.
fn spread(rounds: &[Vec<Value>], line: usize, number: impl Fn(&Value) -> &Value) -> Spread {
    let of = |lines: &Vec<Value>| lines.get(line).and_then(|line| number(line).as_f64()).unwrap_or(f64::NAN);
    Spread::of(&rounds.iter().map(of).collect::<Vec<_>>())
}

fn updates(examples: &Path, options: &Options) -> Result<Vec<Value>> {
    let rounds = rounds(&Command::new(examples.join("cost_of_update")), options)?;
    let first = rounds.first().map(Vec::as_slice).unwrap_or_default();
    let row = |(i, line): (usize, &Value)| json!({"width": line["width"], "batch": line["batch"], "microseconds": spread(&rounds, i, |line| &line["microseconds"])});
    Ok(first.iter().enumerate().map(row).collect())
}

fn model_steps(examples: &Path, options: &Options) -> Result<Vec<Value>> {
    let folder = tempfile::tempdir()?;
    let mut command = Command::new(examples.join("model_steps"));
    for terms in TERMS {
        let path = folder.path().join(format!("{terms}.json"));
        std::fs::write(&path, model(terms).to_string())?;
        command.arg(path);
    }
    let rounds = rounds(&command, options)?;
    let row = |(i, terms): (usize, &usize)| json!({"terms": terms, "nanoseconds": spread(&rounds, i, |line| &line["many"]["median_ns"])});
    Ok(TERMS.iter().enumerate().map(row).collect())
}

/// ẋ = v, v̇ a sum of `terms` sines and cosines, stepped as the pendulum is.
fn model(terms: usize) -> Value {
    let waves = (0..terms).map(|i| format!("{}({}*x)", if i % 2 == 1 { "sin" } else { "cos" }, i / 2 + 1));
    let all: Vec<String> = ["v".to_owned()].into_iter().chain(waves).collect();
    let accelerations: Vec<Value> =
        (0..terms).map(|i| json!({"term": i + 1, "coefficient": 0.1 / (i + 1) as f64})).collect();
    json!({
        "format": 2, "form": "semi_implicit", "dt": 0.05, "states": ["x", "v"], "controls": ["u"], "terms": all,
        "equations": [[{"term": 0, "coefficient": 1.0}], accelerations], "kinematic": [true, false], "n_features": terms + 1,
    })
}

/// Runs of pendulum, each on one thread, one or two at once.
fn seeds(sindyna: &Sindyna, rounds: usize) -> Result<Vec<Value>> {
    let cases: Vec<(u64, usize)> = SEEDS.iter().flat_map(|count| [1, 2].map(|at_once| (*count, at_once))).collect();
    let mut found = vec![Vec::new(); cases.len()];
    for _ in 0..rounds {
        for (found, (count, at_once)) in found.iter_mut().zip(&cases) {
            found.push(together(sindyna, *count, *at_once)?);
        }
    }
    let row = |((count, at_once), found): (&(u64, usize), &Vec<f64>)| json!({"seeds": count, "at_once": at_once, "seconds": Spread::of(found)});
    Ok(cases.iter().zip(&found).map(row).collect())
}

fn together(sindyna: &Sindyna, count: u64, at_once: usize) -> Result<f64> {
    let folder = tempfile::tempdir()?;
    let begun = Instant::now();
    each(at_once, &(0..count).collect::<Vec<_>>(), |seed| {
        let out = folder.path().join(seed.to_string());
        let mut train = sindyna.training("pendulum", FIRST_SEED + seed, &out, &["--threads", "1"]);
        Ok(train.stderr(Stdio::null()).status()?)
    })?;
    Ok(begun.elapsed().as_secs_f64())
}
