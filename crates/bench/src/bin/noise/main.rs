//! What sensor noise costs: equations, coefficients, regulators. Controllers trained in the equations are in the program `loop`.
//!
//! For every task, noise level, number of real steps and seed the equations are identified without being told how noisy the sensors are, and again told so; where the task
//! is to balance, linear-quadratic regulators of the models act on the noisy true system. Writes results/noise.json, docs/noise.md and docs/noise.svg. What was run
//! before is taken from runs/noise; delete that folder after a change of the identifier.

mod page;

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Parser;
use page::{Figures, Group, Regulators, Row};
use sindyna_bench::study::{Result, each, kept, study};
use sindyna_bench::{measure, rivals, system, warm_up};
use sindyna_control::{Costs, Lqr};
use sindyna_core::{Dataset, Dynamics, Seed};
use sindyna_dyna::evaluate;
use sindyna_envs::System;
use sindyna_record::comparison::Seeds;
use sindyna_sindy::{Identifier, Model, NoiseChoice};
use sindyna_truth::Truth;

/// Points of the box over which models are judged.
const POINTS: usize = 10_000;

/// Episodes of each regulator.
const EPISODES: usize = 20;

#[derive(Debug, Parser)]
struct Options {
    /// Tasks.
    #[arg(long, value_delimiter = ',', default_value = "cart-pole,mountain-car,pendulum,inverted-pendulum")]
    tasks: Vec<String>,
    /// Those of them whose models are regulated around x = 0, u = 0.
    #[arg(long, value_delimiter = ',', default_value = "cart-pole,inverted-pendulum")]
    balanced: Vec<String>,
    /// Standard deviations of the sensors' noise, as parts of each channel's scale.
    #[arg(long, value_delimiter = ',', default_value = "0.001,0.01,0.05")]
    noises: Vec<f64>,
    /// Numbers of real steps.
    #[arg(long, value_delimiter = ',', default_value = "100,300,1000")]
    steps: Vec<usize>,
    /// Seeds, such as 20 or 0-9,100-199.
    #[arg(long, default_value = "20")]
    seeds: Seeds,
    /// Runs at a time.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "noise")]
    out: String,
}

fn main() -> Result {
    let options = Options::parse();
    study(
        (&options.out, &format!("docs/{}.md", options.out)),
        options.page_only,
        || figures(&options),
        |document| page::page(document, &options.out),
    )
}

fn figures(options: &Options) -> Result<Figures> {
    let mut cells: Vec<(&String, f64, usize)> = Vec::new();
    for task in &options.tasks {
        for &noise in &options.noises {
            cells.extend(options.steps.iter().map(|r| (task, noise, *r)));
        }
    }
    let cases: Vec<_> = cells.iter().flat_map(|cell| options.seeds.iter().map(move |seed| (*cell, seed))).collect();
    let rows = each(options.jobs, &cases, |((task, noise, steps), seed)| {
        let stem = format!("{task}-{noise}-{steps}-{seed}.json");
        let regulate = options.balanced.contains(task);
        let row = kept(PathBuf::from("noise").join(stem), || row(task, *noise, *steps, *seed, regulate))?;
        writeln!(io::stderr(), "{task}, noise {noise}, {steps} steps, seed {seed}: error {:?}", row.error())?;
        Ok(row)
    })?;
    let of = cells.iter().zip(rows.chunks(options.seeds.count().max(1)));
    let groups = of.map(|((task, noise, steps), rows)| Group::of((task, *noise, *steps), rows)).collect();
    Ok(Figures { groups, notes: Vec::new() })
}

/// One identification, and the same told how noisy the sensors are.
fn row(task: &str, noise: f64, steps: usize, seed: u64, regulate: bool) -> Result<Row> {
    let system = system(task)?.with_noise(noise);
    let identifier = Identifier::new(system.spec()).with_noise(NoiseChoice::Estimated);
    let truth = Truth::of(&system, POINTS);
    let data = warm_up(&system, steps, Seed::new(seed))?;
    let (measured, model) = measure(&truth, &identifier, &data).ok().unzip();
    let returned = |model: &dyn Dynamics| regulated(&system, model, Seed::new(seed));
    let regulators = regulate.then(|| Regulators {
        least_squares: linear(&system, &data).and_then(|model| returned(&model)),
        identified: model.as_ref().and_then(|model| returned(model)),
        true_system: returned(&system.dynamics()),
    });
    // The one that estimates has forgotten what is declared.
    let declared = Identifier::new(system.spec()).with_noise(NoiseChoice::Declared);
    let told = measure(&truth, &declared, &data).ok();
    let told = told.map(|(measured, _)| measured);
    Ok(Row { seed, resets: data.n_rollouts(), measured, told, rivals: rivals(&truth, &identifier, &data), regulators })
}

/// x⁺ = x + Δt (A x + B u) by least squares.
fn linear(system: &System, data: &Dataset) -> Option<Model> {
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
