//! How often the equations found are the true ones: one JSON line per seed.
//!
//! `exact SYSTEM STEPS FIRST LAST` identifies SYSTEM from STEPS real steps with the defaults, for seeds FIRST to LAST, and
//! holds what was found against 10,000 true rates.

use std::io::Write as _;

use clap::Parser;
use serde::Serialize;
use sindyna_bench::{Measured, Rivals, measure, rivals, system, warm_up};
use sindyna_core::Seed;
use sindyna_sindy::Identifier;
use sindyna_truth::Truth;

/// Points of the box over which exactness is judged.
const POINTS: usize = 10_000;

#[derive(Debug, Parser)]
struct Options {
    /// The system, such as `cart-pole` or `lorenz`.
    system: String,
    /// Real steps.
    steps: usize,
    /// First seed.
    first: u64,
    /// Last seed.
    last: u64,
}

#[derive(Debug, Serialize)]
struct Line<'a> {
    system: &'a str,
    steps: usize,
    seed: u64,
    resets: usize,
    /// Why nothing was identified.
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
    #[serde(flatten)]
    measured: Option<Measured>,
    #[serde(flatten)]
    rivals: Rivals,
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let system = system(&options.system)?;
    let identifier = Identifier::new(system.spec());
    let truth = Truth::of(&system, POINTS);
    let mut out = std::io::stdout().lock();
    for seed in options.first..=options.last {
        let data = warm_up(&system, options.steps, Seed::new(seed))?;
        let (measured, refused) = match measure(&truth, &identifier, &data) {
            Ok((measured, _)) => (Some(measured), None),
            Err(reason) => (None, Some(reason.to_string())),
        };
        let rivals = rivals(&truth, &identifier, &data);
        let (steps, resets) = (options.steps, data.n_rollouts());
        let line = Line { system: system.name(), steps, seed, resets, refused, measured, rivals };
        serde_json::to_writer(&mut out, &line)?;
        writeln!(out)?;
    }
    Ok(())
}
