//! Updates of SAC, training of ensembles, steps of models.

use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::Command;

use anyhow::Context as _;
use serde_json::{Value, json};
use sindyna_bench::study::{Result, Sindyna, Spread, built};

use crate::ask::{Peers, number};

/// Rounds of `product_ceiling`.
const WINDOWS: &str = "100";

/// Hidden widths.
const WIDTHS: [&str; 2] = ["64", "256"];

/// Task and environment of Gymnasium.
const ENVIRONMENTS: [(&str, &str); 4] = [
    ("pendulum", "Pendulum-v1"),
    ("mountain-car", "MountainCarContinuous-v0"),
    ("cart-pole", "CartPole-v1"),
    ("inverted-pendulum", "InvertedPendulum-v5"),
];

#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// How often everything is measured, in turn.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Stem of the file in results [default: the measurement's name].
    #[arg(long)]
    out: Option<String>,
    #[command(flatten)]
    peers: Peers,
}

/// Numbers by name, one per round.
#[derive(Debug, Default)]
struct Rounds(BTreeMap<String, Vec<f64>>);

impl Rounds {
    fn push(&mut self, name: &str, value: f64) {
        self.0.entry(name.to_owned()).or_default().push(value);
    }

    fn spread(&self, name: &str) -> Spread {
        Spread::of(self.0.get(name).map_or(&[], Vec::as_slice))
    }

    /// Of numbers of the same round.
    fn ratios(&self, a: &str, b: &str) -> Spread {
        let of = |name: &str| self.0.get(name).cloned().unwrap_or_default();
        Spread::of(&of(a).iter().zip(of(b)).map(|(a, b)| a / b).collect::<Vec<_>>())
    }

    fn spreads(&self) -> BTreeMap<&String, Spread> {
        self.0.iter().map(|(name, values)| (name, Spread::of(values))).collect()
    }
}

/// The number in front of `unit` in a text.
fn before(text: &str, unit: &str) -> Result<f64> {
    let (front, _) = text.split_once(unit).with_context(|| format!("no `{unit}` in {text}"))?;
    let from = front
        .rfind(|c: char| !(c.is_ascii_digit() || c == '.'))
        .map_or(0, |i| i + front[i..].chars().next().map_or(1, char::len_utf8));
    Ok(front[from..].parse()?)
}

/// What an example prints.
fn example(peers: &Peers, release: &Path, name: &str, arguments: &[&str]) -> Result<String> {
    peers.run(Command::new(release.join("examples").join(name)).args(arguments))
}

pub(crate) fn updates(options: &Options) -> Result {
    let release = built(&["-p", "sindyna-rl", "--examples"])?;
    let sizes = WIDTHS.iter().map(|width| of_width(options, &release, width)).collect::<Result<Vec<_>>>()?;
    options.peers.store(options.out.as_deref().unwrap_or("updates"), json!({"sizes": sizes}))
}

/// One thread, batch 256. Ours are taken over whole runs, as the peers' are, before and after each peer, so that each ratio is of neighbours.
fn of_width(options: &Options, release: &Path, width: &str) -> Result<Value> {
    let peers = &options.peers;
    let ours = || -> Result<f64> {
        let text = example(peers, release, "updates_per_second", &[width])?;
        let is_real = |line: &&str| line.starts_with(&format!("{width}x{width}")) && !line.contains("numbered");
        before(text.lines().find(is_real).context("no updates")?, " over all")
    };
    let (mut rates, mut steps, mut ratios, mut in_turn, mut shares) =
        (Rounds::default(), Rounds::default(), Rounds::default(), Rounds::default(), Rounds::default());
    let mut products = 0.0;
    for round in 0..options.rounds {
        for name in ["sbx", "sb3"] {
            let first = ours()?;
            let peer = peers.ask(&[&format!("{name}-updates"), width])?;
            let then = ours()?;
            let rate = number(&peer, "updates_per_s")?;
            rates.push("ours", first);
            rates.push("ours", then);
            rates.push(name, rate);
            steps.push(name, number(&peer, "with_steps_per_s")?);
            ratios.push(name, f64::midpoint(first, then) / rate);
        }
        let text = example(peers, release, "product_ceiling", &[width, WINDOWS])?;
        products = before(&text, " MFLOP")?;
        let lines: Vec<(&str, f64, f64)> = text.lines().filter_map(ceiling).collect();
        for (name, median, _) in &lines {
            in_turn.push(name, *median);
        }
        let best = |kind: &str, of: fn(&(&str, f64, f64)) -> f64| {
            lines.iter().filter(|line| line.0.starts_with(kind)).map(of).fold(0.0, f64::max)
        };
        shares.push("median", best("update", |line| line.1) / best("products", |line| line.1));
        shares.push("best", best("update", |line| line.2) / best("products", |line| line.2));
        writeln!(io::stderr(), "{width}x{width} round {}: {rates:?}", round + 1)?;
    }
    Ok(json!({
        "width": width.parse::<usize>()?, "batch": 256, "mflop_per_update": products, "updates_per_second": rates.spreads(),
        "with_environment_step_per_second": steps.spreads(), "ours_over_sbx": ratios.spread("sbx"), "ours_over_sb3": ratios.spread("sb3"),
        "share_of_fastest_products": shares.spreads(), "in_turn_in_one_process": in_turn.spreads(),
    }))
}

/// Name, median and best rate of a line of `product_ceiling`: `update, avx512   5140/s (best 5214)`.
fn ceiling(line: &str) -> Option<(&str, f64, f64)> {
    let (front, rest) = line.split_once("/s (best")?;
    let (name, median) = front.rsplit_once(' ')?;
    let (best, _) = rest.trim().split_once(|c: char| !(c.is_ascii_digit() || c == '.'))?;
    Some((name.trim(), median.parse().ok()?, best.parse().ok()?))
}

pub(crate) fn ensemble(options: &Options) -> Result {
    let (peers, release) = (&options.peers, built(&["-p", "sindyna-rl", "--examples"])?);
    let ours = |preset: &str| -> Result<(f64, f64)> {
        let text = example(peers, &release, "ensemble_speed", &[preset])?;
        Ok((before(&text, " examples/s")?, before(&text, " µs per imagined step")?))
    };
    let mut presets = Vec::new();
    for preset in ["janner", "paper"] {
        let (mut rates, mut ratios, mut told) = (Rounds::default(), Rounds::default(), Value::Null);
        for round in 0..options.rounds {
            let (first, step) = ours(preset)?;
            told = peers.ask(&["torch-ensemble", preset])?;
            let (then, _) = ours(preset)?;
            rates.push("ours", first);
            rates.push("ours", then);
            ratios.push("step", step);
            for adam in ["plain", "fused"] {
                let rate = number(&told, &format!("{adam}_adam_per_s"))?;
                rates.push(&format!("torch_{adam}"), rate);
                ratios.push(adam, f64::midpoint(first, then) / rate);
            }
            writeln!(io::stderr(), "{preset} round {}: {rates:?}", round + 1)?;
        }
        presets.push(json!({
            "preset": preset, "members": told["members"], "parameters": told["parameters"], "examples_per_second": rates.spreads(),
            "ours_over_torch_plain": ratios.spread("plain"), "ours_over_torch_fused": ratios.spread("fused"),
            "microseconds_per_imagined_step": ratios.spread("step"),
        }));
    }
    peers.store(options.out.as_deref().unwrap_or("ensemble"), json!({"presets": presets}))
}

/// Ours are of the model of `sindyna train TASK --seed 0`.
pub(crate) fn model_steps(options: &Options) -> Result {
    let peers = &options.peers;
    let release = built(&["-p", "sindyna", "-p", "sindyna-bench", "--bins", "--examples"])?;
    let sindyna = Sindyna::at(&release.join("sindyna"));
    let folder = tempfile::tempdir()?;
    let mut tasks = Vec::new();
    for (task, environment) in ENVIRONMENTS {
        let out = folder.path().join(task);
        // The policy is not asked for.
        sindyna.training(task, 0, &out, &["--max-updates", "8"]).status()?;
        let model = out.join("model.json").to_string_lossy().into_owned();
        let mut found = Rounds::default();
        for _ in 0..options.rounds {
            let ours: Value = serde_json::from_str(&example(peers, &release, "model_steps", &[&model])?)?;
            found.push("ours_one", number(&ours["one"], "median_ns")?);
            found.push("ours_many", number(&ours["many"], "median_ns")?);
            found.push("ours_many_at_best", number(&ours["many"], "least_ns")?);
            found.push("gymnasium_one", number(&peers.ask(&["gymnasium-steps", environment])?, "median_ns")?);
            let pysindy = peers.ask(&["pysindy-steps", task])?;
            found.push("pysindy_one", number(&pysindy, "one_ns")?);
            found.push("pysindy_of_10000", number(&pysindy, "many_ns")?);
            found.push("million", 1e3 / number(&ours["many"], "median_ns")?);
        }
        writeln!(io::stderr(), "{task}: {found:?}")?;
        let million = found.spread("million");
        let ratios = [("gymnasium_one", "ours_one"), ("pysindy_one", "ours_one"), ("pysindy_of_10000", "ours_many")];
        let [gymnasium, pysindy, many] = ratios.map(|(theirs, ours)| found.ratios(theirs, ours));
        found.0.remove("million");
        tasks.push(json!({
            "task": task, "nanoseconds": found.spreads(), "million_steps_per_second": million, "gymnasium_over_ours": gymnasium,
            "pysindy_over_ours": pysindy, "pysindy_of_10000_over_ours_many": many,
        }));
    }
    peers.store(options.out.as_deref().unwrap_or("model-steps"), json!({"tasks": tasks}))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_from_what_the_examples_print() -> Result {
        for (text, unit, rate) in [
            ("64x64: 5021 updates/s (4876 over all), 3.10 µs per action", " over all", 4876.0),
            ("janner: 35600 examples/s, 61 GFLOP/s in products, 862464 parameters, avx512", " examples/s", 35600.0),
            ("janner: 6.7 µs per imagined step", " µs per imagined step", 6.7),
            ("64x64, batch 256, 33.5 MFLOP per update", " MFLOP", 33.5),
        ] {
            assert!((before(text, unit)? - rate).abs() < 1e-12, "{text}");
        }
        let line = "update, avx512              5140/s (best    5214),  172 GFLOP/s,  101 % of the fastest products";
        assert_eq!(ceiling(line), Some(("update, avx512", 5140.0, 5214.0)));
        assert_eq!(ceiling("64x64, batch 256, 33.5 MFLOP per update"), None);
        Ok(())
    }
}
