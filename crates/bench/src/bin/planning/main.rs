//! Many joints: equations from few real steps, and planners in them.
//!
//! Runs `sindyna train --task-file examples/planning/TASK.toml --controller C --real-steps R --max-real-steps R --seed S` for every task and seed, or, with `--noise N`, as
//! many real steps as it takes (`--noise N` instead of `--max-real-steps R`), holds the equations against MuJoCo's own steps, and writes results/OUT.json and docs/OUT.md. What was run before is taken from runs/planning; delete that folder after a change of the
//! identifier or the planners.

mod page;
mod truth;

use std::fs;
use std::io::{self, Write as _};

use anyhow::Context as _;
use clap::Parser;
use page::{Figures, Group, Run};
use sindyna_bench::study::{Result, Sindyna, Trained, each, root, study};
use sindyna_record::comparison::Seeds;
use sindyna_sindy::Model;
use truth::Truth;

#[derive(Debug, Parser)]
struct Options {
    /// Tasks of examples/planning, each with its controller, first real steps, episodes and seeds: TASK:CONTROLLER:STEPS:EPISODES:SEEDS.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "inverted_double_pendulum:auto:20:10:0-99,cartpole_balance:auto:20:4:0-9,cartpole_swingup:ilqr:20:4:0-9,\
                         cartpole_swingup_sparse:ilqr:20:4:0-9,cartpole_two_poles:ilqr:50:4:0-9,pendulum_swingup:ilqr:20:10:0-9,\
                         reacher_easy:ilqr:20:20:0-9,reacher_hard:ilqr:20:20:0-9,reacher_v5:ilqr:20:20:0-9,acrobot_swingup:ilqr:20:4:0-9"
    )]
    tasks: Vec<Case>,
    /// Noise of the sensors, as parts of the scales of their channels: every task at each; the runs may then add to the real steps.
    #[arg(long, value_delimiter = ',')]
    noise: Vec<f64>,
    /// Runs at a time, a thread each.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "planning-tasks")]
    out: String,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
}

/// A task, what plans, and from how much.
#[derive(Debug, Clone)]
struct Case {
    task: String,
    controller: String,
    steps: usize,
    episodes: usize,
    seeds: Seeds,
}

impl std::str::FromStr for Case {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let parts: Vec<&str> = text.split(':').collect();
        let [task, controller, steps, episodes, seeds] = parts[..] else {
            anyhow::bail!("`{text}` is not TASK:CONTROLLER:STEPS:EPISODES:SEEDS")
        };
        let (task, controller) = (task.to_owned(), controller.to_owned());
        let seeds = seeds.parse::<Seeds>().map_err(|reason| anyhow::anyhow!("`{seeds}`: {reason}"))?;
        Ok(Self { task, controller, steps: steps.parse()?, episodes: episodes.parse()?, seeds })
    }
}

fn main() -> Result {
    let options = Options::parse();
    study(
        (&options.out, &format!("docs/{}.md", options.out)),
        options.page_only,
        || measure(&options),
        |document| page::page(document, &options.out),
    )
}

fn measure(options: &Options) -> Result<Figures> {
    let sindyna = Sindyna::build()?;
    let levels: Vec<Option<f64>> =
        if options.noise.is_empty() { vec![None] } else { options.noise.iter().copied().map(Some).collect() };
    let settings: Vec<(&Case, Option<f64>)> =
        options.tasks.iter().flat_map(|case| levels.iter().map(move |noise| (case, *noise))).collect();
    let mut cases: Vec<(&Case, Option<f64>, u64)> = Vec::new();
    for (case, noise) in &settings {
        cases.extend(case.seeds.iter().map(|seed| (*case, *noise, seed)));
    }
    let runs = each(options.jobs, &cases, |(case, noise, seed)| run(&sindyna, (case, *noise), *seed))?;
    let mut runs = runs.into_iter();
    let groups = settings.iter().map(|(case, noise)| Group {
        noise: *noise,
        task: case.task.clone(),
        controller: case.controller.clone(),
        steps: case.steps,
        runs: runs.by_ref().take(case.seeds.count()).collect(),
    });
    Ok(Figures { groups: groups.collect() })
}

/// One run, from its record if it was run before.
fn run(sindyna: &Sindyna, (case, noise): (&Case, Option<f64>), seed: u64) -> Result<Run> {
    let Case { task, controller, steps, episodes, .. } = case;
    let noisy = noise.map_or_else(String::new, |noise| format!("-{noise}"));
    let out = root().join("runs/planning").join(format!("{task}-{controller}-{steps}-{episodes}{noisy}-{seed}"));
    let (steps, episodes) = (steps.to_string(), episodes.to_string());
    let limit = noise.map_or(("--max-real-steps", steps.clone()), |noise| ("--noise", noise.to_string()));
    let options = [
        "--controller",
        controller,
        "--real-steps",
        &steps,
        limit.0,
        &limit.1,
        "--episodes",
        &episodes,
        "--threads",
        "1",
    ];
    let file = root().join("examples/planning").join(format!("{task}.toml"));
    let path = file.to_str().context("the repository lies at a path that is no text")?;
    let (summary, timing) = match sindyna.train(path, seed, &out, &options)? {
        Trained::Refused(reason) => return Ok(Run { seed, refused: Some(reason), ..Run::default() }),
        Trained::Done(summary, timing) => (summary, timing),
    };
    let model = Model::from_json(&fs::read_to_string(out.join("model.json"))?)?;
    let run = Run {
        seed,
        refused: None,
        real_steps: summary.real_steps,
        claimed: summary.identification.as_ref().and_then(|i| i.explained),
        deviation: Truth::of(&file)?.deviation(&model)?,
        returns: summary.evaluation.map(|e| e.returns).unwrap_or_default(),
        planner: summary.training.algorithm,
        identify_seconds: timing.identify_seconds,
        train_seconds: timing.train_seconds,
        act_seconds: timing.act_seconds,
        slowest_act_seconds: timing.slowest_act_seconds,
        wall_seconds: timing.wall_seconds,
    };
    writeln!(io::stderr(), "{run:?}")?;
    Ok(run)
}
