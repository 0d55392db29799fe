//! `sindyna compare`: methods side by side.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;
use sindyna_core::number::plural;
use sindyna_methods::{Contender, Job, Known, Method, Pace, Store, Variant, first_check};
use sindyna_record::comparison::{Outcome, Seeds, gather};
use sindyna_report::Comparison;
use sindyna_rl::Isa;
use sindyna_training::problem::{self, Problem, Source};

use super::answer::{Answer, Verdict};
use super::common::Common;
use super::console::Console;
use super::pages;
use super::report::Told;
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::progress::Progress;
use crate::cli::report_files;

/// Compare methods by the real steps each needs to solve each task
///
/// Each run (task, method, seed) writes a file; report.html shows all of them. An interrupted comparison continues when the same command is given
/// again; finished runs are not repeated. Tables, figures and the page include every run in the directory, also those of earlier commands with other
/// tasks, methods or seeds. The folder `digest` holds their data (`sindyna report`). Each run uses one core; results do not depend on the
/// number of cores.
#[derive(Debug, clap::Args)]
#[command(after_help = METHODS, allow_negative_numbers = true)]
pub(crate) struct Args {
    /// Tasks, `sindyna tasks` lists them; a name that ends in .toml is a task file with a simulator (docs/task-files.md)
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        value_parser = name,
        default_value = "cart-pole,mountain-car,pendulum,inverted-pendulum,cart-pole-swing-up"
    )]
    tasks: Vec<String>,
    /// Methods (listed below)
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        value_parser = name,
        default_value = "sindy,sac,lqr,expert,random"
    )]
    methods: Vec<String>,
    /// `sindy` with other settings under a name, such as "stlsq: solver=stlsq,threshold=0.1"; it is called `sindy+stlsq` then. Keys are those of
    /// config.toml; a key may be shortened to its last part, such as `polyak` for `sac.polyak`, if that is unique. May be repeated
    #[arg(long = "variant", value_name = "NAME: KEY=VALUE,…")]
    variants: Vec<Variant>,
    /// Seeds: N for 0 to N−1, or a list of seeds and ranges such as 0-9,100-199
    #[arg(long, value_name = "N|LIST", default_value = "10")]
    seeds: Seeds,
    /// Maximum number of real steps of sac, sac20, mbpo, mbpo-paper and sindy-mbpo; other methods have no limit [default: 5000 on cart-pole and pendulum, else 20000]
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    budget: Option<u64>,
    /// Standard deviation of Gaussian noise on every sensor, as a fraction of its scale. It is unknown to all methods and applies in evaluation, too.
    /// Several values, such as 0,0.01, are compared as separate tasks: pendulum and pendulum+noise-0.01
    #[arg(long, value_name = "FRACTIONS", value_delimiter = ',', default_value = "0", value_parser = noise)]
    noise: Vec<f64>,
    /// Continue after a task is solved, until the budget is used
    #[arg(long)]
    whole_budget: bool,
    /// Directory of the comparison, new or to be continued
    #[arg(long, value_name = "DIR", default_value = "runs/compare")]
    out: PathBuf,
    #[command(flatten)]
    common: Common,
}

const METHODS: &str = "\
Methods:
  sindy          equations from ten or more real steps, soft actor-critic in them: `sindyna train`
  least-squares  the loop of `sindyna train` with a linear model, fitted by least squares
  ensemble       the loop of `sindyna train` with an ensemble of neural networks (Janner's)
  mbpo           soft actor-critic on the system and in an ensemble of networks (Janner 2019)
  mbpo-paper     the same with the ensemble whose size the SINDy paper gives
  sindy-mbpo     mbpo with identified equations instead of the ensemble
  sac            soft actor-critic on the system, one update a step
  sac20          the same with twenty updates a step
  oracle         soft actor-critic in the true equations: an upper bound for learned models
  lqr            a linear-quadratic regulator of a linear model from 30 real steps (balancing tasks)
  sindy-lqr      the same of equations identified from ten real steps
  expert         a controller written by hand with knowledge of the equations
  random         uniformly random actions";

/// What `--json` says of a comparison that was run.
#[derive(Serialize)]
struct Ran<'a> {
    #[serde(flatten)]
    told: Told<'a>,
    runs: usize,
    done_before: usize,
}

pub(crate) fn run(args: &Args, console: Console) -> Result<Answer, Failure> {
    let interrupt = Interrupt::listen()?;
    let progress = Progress::new(console);
    let jobs = args.jobs(&progress)?;
    let settings = settings(args)?;
    let store = Store::open(&args.out, &settings, &jobs)?;
    let (before, left): (Vec<&Job>, Vec<&Job>) = jobs.iter().partition(|job| store.done(job).is_some());
    let stop = || interrupt.pressed();
    let pool = args.common.pool()?;
    let mut pace = Pace::new(left.iter().copied(), pool.current_num_threads());
    before.iter().for_each(|job| pace.know(job, store.seconds(job).unwrap_or(0.0)));
    let time = if left.is_empty() { String::new() } else { format!(", {}", pace.left()) };
    progress.say(&format!("{}, {} of them done before{time}", plural(jobs.len(), "run"), before.len()));
    let state = Mutex::new(State { done: 0, pace, running: Vec::new() });
    let locked = || state.lock().unwrap_or_else(PoisonError::into_inner);
    pool.install(|| {
        // One job after the other goes to whichever core is free.
        left.iter().par_bridge().try_for_each(|job| {
            if stop() {
                return Ok(());
            }
            locked().begin(job, left.len(), &progress);
            let begun = Instant::now();
            let outcome = job.run(&interrupt.flag());
            let seconds = begun.elapsed().as_secs_f64();
            if let Some(outcome) = &outcome {
                store.keep(job, outcome, seconds)?;
            }
            locked().end(job, outcome.as_ref(), seconds, left.len(), &progress);
            Ok::<_, Failure>(())
        })
    })?;
    progress.finish();
    // A comparison stopped before its first run came to an end has nothing to report.
    let done = state.into_inner().unwrap_or_else(PoisonError::into_inner).done;
    let verdict = if interrupt.pressed() {
        progress.say("interrupted; repeat the command to continue");
        Verdict::Interrupted
    } else {
        Verdict::Done
    };
    if done == 0 && before.is_empty() {
        return Ok(Answer::silent(verdict));
    }
    let tasks = Known::tasks();
    let digest = gather(&args.out, &Known::names(&tasks))?;
    digest.write(&args.out.join(report_files::DIGEST))?;
    let known = Known::of(&digest);
    let comparison = Comparison::new(&digest, &known);
    report_files::write(&comparison, &args.out)?;
    let (table, missing) = (super::report::table(comparison.groups()), super::report::missing(&comparison));
    let text = format!("{table}\n{missing}record: {}\n", super::report::contents(&args.out));
    let told = Told {
        record: &args.out,
        report: args.out.join(pages::PAGE),
        groups: comparison.groups(),
        missing: comparison.gaps(),
    };
    Answer::new(verdict, text, &Ran { told, runs: jobs.len(), done_before: before.len() })
}

/// Where the runs of a comparison are.
struct State {
    done: usize,
    pace: Pace,
    running: Vec<String>,
}

impl State {
    fn begin(&mut self, job: &Job, total: usize, progress: &Progress) {
        self.running.push(job.to_string());
        progress.runs(self.done, total, &self.pace.left().to_string(), &self.running);
    }

    /// Notes the end of `job`, which has no `outcome` if it was interrupted.
    fn end(&mut self, job: &Job, outcome: Option<&Outcome>, seconds: f64, total: usize, progress: &Progress) {
        self.running.retain(|name| *name != job.to_string());
        if let Some(outcome) = outcome {
            self.done += 1;
            self.pace.done(job, seconds);
            progress.say(&format!("[{}/{total}, {}] {job}: {}", self.done, self.pace.left(), came_to(outcome)));
        }
        progress.runs(self.done, total, &self.pace.left().to_string(), &self.running);
    }
}

/// A fraction of the sensors' scales.
fn noise(text: &str) -> Result<f64, &'static str> {
    text.parse()
        .ok()
        // Less could not be seen beside rounding, and would make long names.
        .filter(|value| *value == 0.0 || (1e-12..=1.0).contains(value))
        .ok_or("it must be 0, or a number between 1e-12 and 1, such as 0.01")
}

/// A name in a list.
fn name(text: &str) -> Result<String, &'static str> {
    if text.is_empty() { Err("a name in the list is empty") } else { Ok(text.to_owned()) }
}

/// Whether `method` can be used on `system`.
fn fits(method: Method, system: &dyn Problem) -> bool {
    method.fits(&system.spec().name) && (method != Method::Oracle || system.dynamics().is_some())
}

impl Args {
    /// The task that comes along as `task`, or that of a task file.
    fn system(task: &str, noise: f64) -> Result<Arc<dyn Problem>, Failure> {
        let path = Path::new(task);
        let source = match path.extension() {
            Some(end) if end == "toml" => Source::File(path.to_owned()),
            _ => Source::Named(task.to_owned()),
        };
        let (declared, simulator) = source.task()?;
        let spec = declared.spec();
        if matches!(source, Source::File(_)) && problem::names().contains(&spec.name.as_str()) {
            return Err(Failure::new(format!("{task} is named `{}`, like a built-in task", spec.name))
                .hint("give the task in the file another name"));
        }
        Ok(source.problem(simulator, noise)?)
    }

    fn jobs(&self, progress: &Progress) -> Result<Vec<Job>, Failure> {
        let mut jobs = Vec::new();
        let mut methods: Vec<Contender> =
            self.methods.iter().map(|name| Method::named(name).map(Contender::from)).collect::<Result<_, _>>()?;
        methods.extend(self.variants.iter().cloned().map(Contender::variant));
        let mut tasks = self.tasks.clone();
        unique(&mut methods);
        different_names(&methods)?;
        unique(&mut tasks);
        let mut noises = self.noise.clone();
        unique(&mut noises);
        let each = tasks.iter().flat_map(|task| noises.iter().map(move |noise| (task, *noise)));
        let systems =
            each.map(|(task, noise)| Ok((Self::system(task, noise)?, noise))).collect::<Result<Vec<_>, Failure>>()?;
        let (budget, whole_budget) = (self.budget.map(|steps| steps as usize), self.whole_budget);
        // Seed by seed: what is cut off has as many of every method, and soon tells how long the rest will take.
        for seed in self.seeds.iter() {
            for (system, noise) in &systems {
                let fitting = methods.iter().filter(|m| fits(m.method, &**system));
                let job = |contender: &Contender| Job {
                    system: system.clone(),
                    noise: *noise,
                    contender: contender.clone(),
                    seed,
                    budget,
                    whole_budget,
                };
                jobs.extend(fitting.map(job));
            }
        }
        for method in &methods {
            let not = systems.iter().filter(|(system, _)| !fits(method.method, &**system));
            let mut not: Vec<&str> = not.map(|(system, _)| system.spec().name.as_str()).collect();
            not.dedup();
            if !not.is_empty() {
                progress.say(&format!(
                    "note: {} does not apply to {} and is skipped there",
                    method.name(),
                    not.join(", ")
                ));
            }
        }
        let learners = jobs.iter().filter_map(|job| first_check(job.method(), job.system.spec()));
        if let (Some(budget), Some(least)) = (budget, learners.max())
            && budget < least
        {
            progress.say(&format!(
                "note: with {budget} real steps some methods cannot solve a task: their first evaluation is after {least}"
            ));
        }
        // What no variant can have is refused before the first file.
        jobs.iter().try_for_each(|job| job.settings().map(drop))?;
        if jobs.is_empty() {
            return Err(Failure::new("none of these methods applies to any of these tasks").hint(
                "`lqr` and `sindy-lqr` are for balancing tasks, `expert` for those with a controller written by hand",
            ));
        }
        Ok(jobs)
    }
}

/// Refuses two variants of one name.
fn different_names(contenders: &[Contender]) -> Result<(), Failure> {
    let names: Vec<String> = contenders.iter().map(Contender::name).collect();
    match names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        None => Ok(()),
        Some((_, name)) => {
            Err(Failure::new(format!("two variants are named `{name}`")).hint("give each a name of its own"))
        }
    }
}

/// Keeps the first of equal ones.
fn unique<T: PartialEq + Clone>(list: &mut Vec<T>) {
    let mut seen: Vec<T> = Vec::new();
    list.retain(|item| {
        !seen.contains(item) && {
            seen.push(item.clone());
            true
        }
    });
}

/// What runs depend on besides task, method and seed.
#[derive(Serialize)]
struct Settings {
    version: &'static str,
    commit: &'static str,
    isa: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    budget: Option<u64>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    whole_budget: bool,
}

fn settings(args: &Args) -> Result<String, Failure> {
    let settings = Settings {
        version: env!("CARGO_PKG_VERSION"),
        commit: sindyna_training::COMMIT,
        isa: Isa::widest().name(),
        budget: args.budget,
        whole_budget: args.whole_budget,
    };
    Ok(toml::to_string(&settings)?)
}

/// How one run came out.
fn came_to(outcome: &Outcome) -> String {
    match (&outcome.failure, outcome.solved_after) {
        (Some(failure), _) => format!("failed: {failure}"),
        // Real steps say nothing of who knows the answer beforehand.
        (None, Some(_)) if Method::of_run(&outcome.method).is_some_and(Method::is_reference) => "solved".into(),
        (None, Some(steps)) => format!("solved after {steps} real steps"),
        (None, None) => "not solved".into(),
    }
}
