//! `sindyna train`: the main job.

mod checkpoint;
mod log;
mod recorder;

use std::path::{Path, PathBuf};
use std::time::Instant;

use checkpoint::Checkpoints;
use log::DataOptions;
use recorder::{Clock, Recorder};
use serde::Serialize;
use sindyna_core::number::plural;
use sindyna_core::{Certainty, Dataset, Event, FitError, Observer, Policy, Seed};
use sindyna_dyna::{Dyna, DynaError, Learned};
use sindyna_record::identification::Account;
use sindyna_record::json;
use sindyna_record::run::{EventLog, RunDir, Summary, Timing, rollout_csv};
use sindyna_training::Fitted;
use sindyna_training::problem::Problem;
use sindyna_training::settings::TrainConfig;
use sindyna_training::{Plan, Timed, agent_of, episode, in_model, predictions, summary, watched_evaluation};

use super::answer::{Answer, Verdict};
use super::common::Common;
use super::conclusion::Conclusion;
use super::console::Console;
use super::evaluate::verdict;
use super::pipe::PipeOptions;
use super::settings::Settings;
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::progress::{Evaluating, Progress};
use crate::cli::{machine, pages};

/// Identify a system from a few real steps and train a controller for it
///
/// A few steps are collected on the system. Its equations of motion are identified by sparse regression, soft actor-critic is trained
/// in them, its return is predicted as an interval, and the policy is evaluated on the system. Where the equations are not certain,
/// more steps are collected, and before the evaluation one episode is run and its return compared with the prediction. The run directory holds data,
/// equations, policy, results and report.html.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Args {
    /// Task to learn, such as `pendulum`; `sindyna tasks` lists them
    #[arg(value_name = "TASK", required_unless_present_any = ["config", "task_file", "resume"])]
    task: Option<String>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    pipe: PipeOptions,
    #[command(flatten)]
    data: DataOptions,
    /// Output directory, which must not exist [default: runs/TASK-seedN, numbered if it exists]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue the killed or stopped run in this directory from its last checkpoint. The record is then the same, byte for byte, as without the
    /// interruption. Checkpoints are written about every second, but not during a fit; the system must be deterministic
    #[arg(long, value_name = "RUN", conflicts_with_all = ["task", "out"])]
    resume: Option<PathBuf>,
    /// Do not write report.html
    #[arg(long)]
    no_report: bool,
    #[command(flatten)]
    common: Common,
}

/// What `--json` says of a run.
#[derive(Serialize)]
struct Told<'a> {
    record: &'a Path,
    report: Option<PathBuf>,
    summary: &'a Summary,
    /// None for a run that was finished before.
    timing: Option<&'a Timing>,
}

pub(crate) fn run(args: &Args, console: Console) -> Result<Answer, Failure> {
    let interrupt = Interrupt::listen()?;
    if let Some(path) = &args.resume {
        return resume(path, args, interrupt, console);
    }
    let pipe = args.pipe.source(&interrupt)?;
    let (progress, pool) = (Progress::new(console), args.common.pool()?);
    args.data.check(args.settings.has_log())?;
    let begun = Instant::now();
    let identified = |task: &Path, log: &Path, config: &TrainConfig| {
        pool.install(|| args.data.identified(task, log, config, (&interrupt, &progress)))
    };
    let (config, problem) = match args.settings.config(args.task.as_deref(), pipe.as_ref(), &identified) {
        Err(_) if interrupt.pressed() => {
            progress.say("interrupted: nothing was written");
            return Ok(Answer::silent(Verdict::Interrupted));
        }
        settled => settled?,
    };
    // Without a log this is next to nothing.
    let before = if args.settings.has_log() { begun.elapsed().as_secs_f64() } else { 0.0 };
    // Everything that can be refused is refused before the first file and the first real step.
    let plan = Plan::new(&config, &*problem, interrupt.flag())?;
    // With config.toml, which comes last, a run can be resumed.
    let mut files = problem.files()?;
    files.push(("config.toml", config.to_toml()?.into_bytes()));
    let run_dir = match &args.out {
        Some(path) => RunDir::create(path, &files)?,
        None => {
            let stem = Path::new("runs").join(format!("{}-seed{}", config.task, config.seed));
            RunDir::create_numbered(&stem, &files)?
        }
    };
    let page = !args.no_report;
    let run =
        Run { problem: &*problem, config: &config, run_dir: &run_dir, progress: &progress, interrupt, page, before };
    pool.install(|| run.go(plan))
}

/// Does what is left of the run in `path`, from its last checkpoint on. All of a run follows from its configuration: what the record
/// holds has to come out again.
fn resume(path: &Path, args: &Args, interrupt: Interrupt, console: Console) -> Result<Answer, Failure> {
    if args.settings != Settings::default() || args.data != DataOptions::default() {
        return Err(Failure::new("--resume continues a run with its own settings")
            .hint("`--config RUN/config.toml` with other options starts a changed run"));
    }
    let run_dir = RunDir::reopen(path)?;
    let progress = Progress::new(console);
    let pipe = args.pipe.source(&interrupt)?;
    let (config, problem) = Settings::of_run(run_dir.path(), pipe.as_ref())?;
    let finished = run_dir.read("summary.json").and_then(|text| Summary::from_json(&text).ok());
    if let Some(summary) = finished.filter(|summary| !summary.interrupted) {
        // No file of a record is empty.
        let is_whole = |name: &str| path.join(name).metadata().is_ok_and(|file| file.is_file() && file.len() > 0);
        let missing = summary.files().into_iter().find(|name| !is_whole(name));
        let Some(missing) = missing else {
            checkpoint::remove(&run_dir);
            progress.say(&format!("{0} is finished; `sindyna evaluate {0}` runs its policy again", path.display()));
            let came_out = summary.evaluation.as_ref();
            let none = if problem.log().is_some() { Verdict::Done } else { Verdict::MissedTarget };
            let came_out = came_out.map_or(none, |evaluation| verdict(&*problem, evaluation));
            let page = Some(path.join(pages::PAGE)).filter(|page| page.is_file());
            let told = Told { record: path, report: page, summary: &summary, timing: None };
            return Answer::new(came_out, String::new(), &told);
        };
        progress.say(&format!("note: {missing} is missing, so the run is repeated from its start"));
    }
    if config.commit != sindyna_training::COMMIT {
        progress.say(&format!("note: it was started by another build ({}), whose numbers may differ", config.commit));
    }
    let (plan, pool) = (Plan::new(&config, &*problem, interrupt.flag())?, args.common.pool()?);
    let page = !args.no_report;
    let run = Run {
        problem: &*problem,
        config: &config,
        run_dir: &run_dir,
        progress: &progress,
        interrupt,
        page,
        before: 0.0,
    };
    pool.install(|| run.go(plan))
}

struct Run<'a> {
    problem: &'a dyn Problem,
    config: &'a TrainConfig,
    run_dir: &'a RunDir,
    progress: &'a Progress,
    interrupt: Interrupt,
    /// Whether a page is wanted.
    page: bool,
    /// Seconds in which equations were identified before the run began.
    before: f64,
}

impl Run<'_> {
    fn go(self, plan: Plan) -> Result<Answer, Failure> {
        let start = Instant::now();
        let (problem, config, spec) = (self.problem, self.config, self.problem.spec());
        let mut recorder = Recorder {
            spec,
            run_dir: self.run_dir,
            progress: self.progress,
            kept: self.run_dir.read("rollout.csv").unwrap_or_default(),
            log: EventLog::default(),
            clock: Clock::default(),
            start,
        };
        let made_by = (plan.agent.name(), plan.isa);
        self.progress.detail(|| {
            let threads = plural(rayon::current_num_threads(), "thread");
            format!(
                "{} with {} instructions on {threads}; record: {}",
                made_by.0,
                made_by.1,
                self.run_dir.path().display()
            )
        });
        let learned = self.learn(plan, &mut recorder);
        self.progress.finish();
        let mut learned = learned?;
        let (trained, until_trained) = (Instant::now(), recorder.elapsed());

        let (mut evaluated, mut first_episode, mut unevaluated) = (None, None, Ok(()));
        let policy = learned.policy.clone();
        let timed = policy.as_ref().map(|policy| Timed::new(&**policy));
        if let (Some(timed), None, false) = (&timed, problem.log(), learned.interrupted) {
            let (episodes, told) = (config.evaluation_episodes, Evaluating::new(self.progress, "evaluation"));
            let begun = |number: usize| told.begun(number, episodes);
            let result = watched_evaluation(problem, timed, (episodes, &begun), Seed::new(config.seed));
            self.progress.finish();
            let stopped = self.interrupt.pressed() && (!config.controller.trains() || result.is_err());
            match result {
                // A planner that was stopped no longer plans: its returns tell nothing.
                _ if stopped => learned.interrupted = true,
                Ok((result, episode)) => {
                    first_episode = Some(episode);
                    recorder.on(&Event::Evaluated { returns: &result.returns })?;
                    evaluated = Some(result);
                }
                // The system failed, but what was learned is not lost.
                Err(error) => {
                    let hint =
                        format!("`sindyna evaluate {}` evaluates the policy again", self.run_dir.path().display());
                    unevaluated = Err(Failure::from(error).or_hint(hint));
                }
            }
        }
        let acting = timed.as_ref().map(|timed| timed as &dyn Policy);
        let told = Evaluating::new(self.progress, "comparison with the data");
        if problem.log().is_some() {
            self.progress.detail(|| "comparing what the policy does in the model with the data".into());
        }
        let begun = |number: usize, episodes: usize| told.begun(number, episodes);
        let in_model = in_model(problem, &learned, acting, (&begun, &|| self.interrupt.pressed()));
        self.progress.finish();
        learned.interrupted |= in_model.is_none();
        let told = timed.filter(|_| !learned.interrupted);
        let (act_seconds, slowest_act_seconds) = told.map_or((None, None), Timed::seconds);
        let summary = summary(config, made_by, problem, &learned, evaluated.clone(), in_model);
        let clock = recorder.clock;
        let timing = Timing {
            format: 1,
            identify_seconds: self.before + clock.identified,
            train_seconds: until_trained - clock.identified,
            evaluate_seconds: trained.elapsed().as_secs_f64(),
            act_seconds,
            slowest_act_seconds,
            wall_seconds: self.before + until_trained + trained.elapsed().as_secs_f64(),
            machine: machine::describe(),
            threads: rayon::current_num_threads(),
        };
        let (log, kept) = (recorder.log, recorder.kept);
        if !learned.interrupted && !rollout_csv(spec, &learned.data).starts_with(&kept) {
            return Err(Failure::new("rollout.csv has more rows than this run collects").hint(format!(
                "look at the end of {}; it is left as it was",
                self.run_dir.path().join("rollout.csv").display()
            )));
        }
        // What was found is told even if it cannot be written down.
        let recorded = self.record(&learned, first_episode.as_ref(), &summary, &timing, &log);
        let account = learned.model.as_ref().map(|fitted| Account::new(&fitted.0, spec));
        let model = learned.model.as_ref().map(|fitted| &fitted.0.model);
        let truth = pages::truth(config.system().as_ref(), model, problem.true_equations());
        let conclusion = Conclusion {
            summary: &summary,
            timing: Some(&timing),
            account: account.as_ref(),
            truth: &truth,
            unconfirmed: learned.model.as_ref().is_some_and(|fitted| fitted.0.certainty() < Certainty::Exact),
            record: self.run_dir.path(),
            page: self.page && !learned.interrupted,
        };
        let text = conclusion.text();
        if recorded.is_ok() && !learned.interrupted {
            checkpoint::remove(self.run_dir);
        }
        let came_out = match &evaluated {
            _ if learned.interrupted => Verdict::Interrupted,
            Some(evaluation) => verdict(problem, evaluation),
            None if problem.log().is_some() && learned.policy.is_some() => Verdict::Done,
            None => Verdict::MissedTarget,
        };
        let record = self.run_dir.path();
        let report = conclusion.page.then(|| record.join(pages::PAGE));
        let told = Told { record, report, summary: &summary, timing: Some(&timing) };
        let diverged = match (learned.failure, &evaluated) {
            (Some(failure), None) => {
                Err(Failure::from(failure).hint("a smaller --learning-rate helps against divergence"))
            }
            _ => Ok(()),
        };
        Ok(Answer::new(came_out, text, &told)?.and(recorded).and(diverged).and(unevaluated))
    }

    fn learn(&self, plan: Plan, recorder: &mut Recorder<'_>) -> Result<Learned<Fitted>, Failure> {
        let (spec, seed) = (self.problem.spec(), Seed::new(self.config.seed));
        let Plan { learner, schedule, agent, isa, mut explorer } = plan;
        // How noisy the sensors are is not told: it is estimated.
        let (task, sensors) = (self.problem.task(), self.problem.sensors().with_noise(&[]));
        let dyna = Dyna { task: &*task, sensors: &sensors, learner: &learner, schedule: &schedule, seed };
        let mut env = self.problem.environment()?;
        let stop = || self.interrupt.pressed() || self.problem.check().is_err();
        let mut checkpoints = Checkpoints::new(self.run_dir, self.progress, isa.name());
        let mut begun = None;
        if let Some(saved) = checkpoints.read() {
            let again = agent_of(self.config, self.problem, self.interrupt.flag())?;
            match dyna.resume(again, &mut *explorer, &saved.run) {
                Ok(resumed) => {
                    (recorder.log, recorder.clock) = (saved.log, saved.clock);
                    self.progress.say(&format!("continuing after {:.1} s", recorder.clock.before));
                    begun = Some(resumed);
                }
                Err(DynaError::Checkpoint(error)) => {
                    self.progress.say(&format!("note: {error}; the run restarts"));
                    explorer = self.config.warmup.explorer.explorer(spec);
                }
                // Who is stopped here has done nothing new: the checkpoint stays.
                Err(DynaError::Fit(FitError::Interrupted)) => {}
                Err(error) => return Err(explain(error)),
            }
        }
        let mut begun = match begun {
            Some(begun) => begun,
            None => dyna.begin(agent)?,
        };
        while !begun.has_ended() {
            let advanced = begun.advance(&mut env, &mut *explorer, recorder, &stop);
            self.problem.check()?;
            // What was cut short by a stop is no failure.
            if stop() {
                break;
            }
            advanced.map_err(explain)?;
            checkpoints.offer(&recorder.log, &recorder.clock, recorder.elapsed(), || begun.save(&*explorer));
        }
        Ok(begun.finish())
    }

    fn record(
        &self,
        learned: &Learned<Fitted>,
        first_episode: Option<&Dataset>,
        summary: &Summary,
        timing: &Timing,
        log: &EventLog,
    ) -> Result<(), Failure> {
        let dir = self.run_dir;
        // A planner is made of the model again.
        let policy = learned.policy.as_ref().filter(|_| learned.planned.is_empty()).map(|policy| policy.to_bytes());
        let (summary, timing) = (json(summary)?, json(timing)?);
        let [account, predicted, episode] = self.pictured(learned, first_episode)?;
        let mut files = vec![
            ("model.json", learned.model.as_ref().map(|fitted| fitted.0.model.to_json().into_bytes())),
            ("events.jsonl", Some(log.as_bytes().to_vec())),
            ("timing.json", Some(timing)),
            ("policy.safetensors", policy),
            ("identify.json", account),
            ("prediction.csv", predicted),
            ("episode.csv", episode),
            ("summary.json", Some(summary)),
        ];
        let page = if self.page && !learned.interrupted { pages::of_files(Some(dir.path()), &files) } else { None };
        // Where the summary is, the run is whole: it comes after all others, or not at all.
        let whole = files.pop();
        files.push((pages::PAGE, page));
        // Where one file finds no room, the next may be smaller: every one is tried, the first failure told.
        let mut written = Ok(());
        for (name, contents) in files {
            if let Some(contents) = contents {
                written = written.and(dir.write(name, &contents));
            }
        }
        let last = || whole.map_or(Ok(()), |(name, contents)| dir.write(name, &contents.unwrap_or_default()));
        written.and_then(|()| last()).map_err(|e| {
            let path = dir.path().display();
            Failure::from(e).hint(format!("free some room, then `sindyna train --resume {path}` continues the run"))
        })
    }

    /// Account of the model, what it predicts for the data, and the `first` episode of the evaluation, as files.
    fn pictured(&self, learned: &Learned<Fitted>, first: Option<&Dataset>) -> Result<[Option<Vec<u8>>; 3], Failure> {
        let Some(fitted) = &learned.model else { return Ok([None, None, None]) };
        let (spec, model) = (self.problem.spec(), &fitted.0.model);
        let identifier = self.config.identifier(spec)?;
        let predicted = predictions(&identifier, model, (&learned.data, None), spec);
        let acted = learned.policy.as_ref().zip(first);
        let acted = acted.and_then(|(policy, data)| episode(self.problem, &identifier, model, &**policy, data));
        Ok([
            Some(json(&Account::new(&fitted.0, spec).with_predictions(predicted.as_ref()))?),
            predicted.map(|table| table.to_csv()).transpose()?,
            acted.map(|table| table.to_csv()).transpose()?,
        ])
    }
}

/// What can be done about a run that could not go on.
fn explain(error: DynaError) -> Failure {
    let hint = match &error {
        DynaError::Fit(_) => Some("collect more real data with --real-steps or --warmup-rollouts"),
        _ => None,
    };
    let failure = Failure::from(error);
    match hint {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}
