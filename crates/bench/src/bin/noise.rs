//! Equations from noisy data: one JSON line per seed.
//!
//! `noise SYSTEM NOISE STEPS FIRST LAST` identifies SYSTEM from STEPS real steps whose sensors have noise of NOISE times each
//! channel's scale, with the defaults, by thresholding, and as a linear system; on systems to be balanced, the
//! linear-quadratic regulators of the models then act on the noisy true system.

use std::io::Write as _;

use clap::Parser;
use serde::Serialize;
use sindyna_bench::{Measured, Rivals, measure, rivals, system, warm_up};
use sindyna_control::{Costs, Lqr};
use sindyna_core::{Dataset, Dynamics, Seed};
use sindyna_dyna::evaluate;
use sindyna_envs::System;
use sindyna_sindy::{Identifier, NoiseChoice};
use sindyna_truth::Truth;

/// Points of the box over which models are judged.
const POINTS: usize = 10_000;

/// Episodes of each regulator.
const EPISODES: usize = 20;

#[derive(Debug, Parser)]
struct Options {
    /// The system, such as `cart-pole`.
    system: String,
    /// Standard deviation of the sensors' noise, as a fraction of each channel's scale.
    noise: f64,
    /// Real steps.
    steps: usize,
    /// First seed.
    first: u64,
    /// Last seed.
    last: u64,
    /// Tell the identifier how noisy the sensors are; else it estimates it.
    #[arg(long)]
    declared: bool,
    /// Regulate the models around x = 0, u = 0.
    #[arg(long)]
    regulate: bool,
}

#[derive(Debug, Serialize)]
struct Line<'a> {
    system: &'a str,
    noise: f64,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    regulators: Option<Regulators>,
}

/// Mean returns on the noisy true system; none where there is no regulator.
#[derive(Debug, Serialize)]
struct Regulators {
    /// Of least squares' linear model.
    least_squares: Option<f64>,
    /// Of the equations found.
    identified: Option<f64>,
    /// Of the true system.
    true_system: Option<f64>,
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let system = system(&options.system)?.with_noise(options.noise);
    let noise = if options.declared { NoiseChoice::Declared } else { NoiseChoice::Estimated };
    let identifier = Identifier::new(system.spec()).with_noise(noise);
    let truth = Truth::of(&system, POINTS);
    let mut out = std::io::stdout().lock();
    for seed in options.first..=options.last {
        let data = warm_up(&system, options.steps, Seed::new(seed))?;
        let (found, refused) = match measure(&truth, &identifier, &data) {
            Ok(found) => (Some(found), None),
            Err(reason) => (None, Some(reason.to_string())),
        };
        let (measured, model) = found.unzip();
        let returned = |model: &dyn Dynamics| regulated(&system, model, Seed::new(seed));
        let regulators = options.regulate.then(|| Regulators {
            least_squares: linear(&system, &data).and_then(|model| returned(&model)),
            identified: model.as_ref().and_then(|model| returned(model)),
            true_system: returned(&system.dynamics()),
        });
        let rivals = rivals(&truth, &identifier, &data);
        let (noise, steps, resets) = (options.noise, options.steps, data.n_rollouts());
        let line = Line { system: system.name(), noise, steps, seed, resets, refused, measured, rivals, regulators };
        serde_json::to_writer(&mut out, &line)?;
        writeln!(out)?;
    }
    Ok(())
}

/// x⁺ = x + Δt (A x + B u) by least squares.
fn linear(system: &System, data: &Dataset) -> Option<sindyna_sindy::Model> {
    Some(Identifier::linear(system.spec()).ok()?.identify(data).ok()?.model)
}

/// Mean return of the regulator of `model` on `system`, started as `seed` says; none if there is no regulator.
fn regulated(system: &System, model: &dyn Dynamics, seed: Seed) -> Option<f64> {
    let spec = system.spec();
    let (x, u) = (vec![0.0; spec.state_dim()], vec![0.0; spec.control_dim()]);
    let costs = Costs::of_scales(spec);
    let lqr = Lqr::around(model, spec, (&x, &u), &costs, &mut seed.stream("differences", 0)).ok()?;
    let mut envs: Vec<_> = (0..EPISODES).map(|_| system.environment()).collect();
    let returns = evaluate(&mut envs, &lqr, EPISODES, seed, "regulated").ok()?;
    Some(returns.iter().sum::<f64>() / returns.len() as f64)
}
