//! `sindyna evaluate`: a trained policy on the system again.

use std::path::PathBuf;

use anyhow::Context as _;
use serde::Serialize;
use sindyna_core::number::{fixed, shortest};
use sindyna_core::{Policy, Seed, Space, Spec};
use sindyna_record::ModelRecord;
use sindyna_record::run::{Evaluation, Summary};
use sindyna_rl::SavedPolicy;
use sindyna_sindy::Model;
use sindyna_training::problem::{Late, Problem, Source, on_twin};
use sindyna_training::settings::{TrainConfig, check_episodes};
use sindyna_training::{Predicting, evaluation, planner};

use super::answer::{Answer, Verdict};
use super::common::Common;
use super::pipe::PipeOptions;
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;

/// Evaluate a trained policy on its system again
///
/// Without options the evaluation of the run is repeated: same start states, same returns.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Args {
    /// Output directory of `sindyna train`
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Evaluate on the equations of this output directory of `sindyna identify` instead, such as those of other logs of the same system; for runs on a log
    #[arg(long, value_name = "DIR")]
    model: Option<PathBuf>,
    /// Episodes [default: the run's own number]
    #[arg(long, value_name = "N")]
    episodes: Option<usize>,
    /// Seed of the start states [default: the run's own seed]
    #[arg(long)]
    seed: Option<u64>,
    /// Sensor noise, as a fraction of every observation channel's scale, 0 to 1 [default: the run's own]
    #[arg(long, value_name = "FRACTION")]
    noise: Option<f64>,
    /// Also print the return of every episode
    #[arg(long)]
    returns: bool,
    #[command(flatten)]
    pipe: PipeOptions,
    #[command(flatten)]
    common: Common,
}

/// What `--json` says of an evaluation.
#[derive(Serialize)]
struct Evaluated<'a> {
    task: &'a str,
    solved: Option<bool>,
    threshold: Option<f64>,
    /// The output directory of `sindyna identify` whose equations took the place of the system.
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<&'a str>,
    evaluation: &'a Evaluation,
}

pub(crate) fn run(args: &Args) -> Result<Answer, Failure> {
    let read = |name: &str| {
        let path = args.run.join(name);
        std::fs::read(&path).with_context(|| format!("cannot read {}", path.display())).map_err(|e| {
            Failure::from(e)
                .hint("RUN is an output directory of `sindyna train`, with config.toml and policy.safetensors")
        })
    };
    let config = match TrainConfig::parse(&String::from_utf8_lossy(&read("config.toml")?)) {
        Ok(config) => config,
        Err(_) if args.run.join("identify.json").exists() => {
            let run = args.run.display();
            return Err(Failure::new(format!(
                "{run} is an output directory of `sindyna identify` and holds no policy"
            ))
            .hint(format!("`sindyna train --model {run} --task-file FILE` trains one in its equations")));
        }
        Err(e) => {
            let path = args.run.join("config.toml");
            return Err(anyhow::Error::new(e)
                .context(format!("{} is not a run's configuration", path.display()))
                .into());
        }
    };
    // What is no program is stopped at once.
    let interrupt = if args.pipe.is_given() { Interrupt::listen()? } else { Interrupt::default() };
    let pipe = args.pipe.source(&interrupt)?;
    let source = Source::of(&config, &args.run, pipe.as_ref());
    let noise = args.noise.unwrap_or(config.noise);
    let problem = match &args.model {
        Some(directory) => on_twin(&source, directory, noise)?,
        None => source.problem(config.simulator, noise)?,
    };
    if !config.controller.trains() {
        return planned((args, &interrupt), &config, &*problem, &read);
    }
    if !args.run.join("policy.safetensors").exists() {
        let config = args.run.join("config.toml");
        return Err(Failure::new(format!("{} holds no policy: its training produced none", args.run.display()))
            .hint(format!("run it again with `sindyna train --config {}`", config.display())));
    }
    let policy = SavedPolicy::from_safetensors(&read("policy.safetensors")?)
        .with_context(|| format!("{} is not a policy", args.run.join("policy.safetensors").display()))?;
    if problem.log().is_some() {
        return Err(Failure::new(format!(
            "{} was trained in the equations of a log: there is no system to evaluate its policy on",
            args.run.display()
        ))
        .hint(format!(
            "--model DIR evaluates it on equations of other logs; `sindyna show {}` prints the predicted return",
            args.run.display()
        )));
    }
    fits(&policy, problem.spec())?;
    in_time((args, &interrupt), &config, (&*problem, &read), policy)
}

/// Reads a file of a run.
type ReadFile<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>, Failure>;

/// The planner of a run, in the equations that it found.
fn planned(
    (args, interrupt): (&Args, &Interrupt),
    config: &TrainConfig,
    problem: &dyn Problem,
    read: ReadFile<'_>,
) -> Result<Answer, Failure> {
    if problem.log().is_some() {
        return Err(Failure::new(format!(
            "{} planned in the equations of a log: there is no system to evaluate it on",
            args.run.display()
        ))
        .hint("--model DIR evaluates it on equations of other logs"));
    }
    let summary = Summary::from_json(&String::from_utf8_lossy(&read("summary.json")?))
        .context("summary.json is not that of a run")?;
    let name = &summary.training.algorithm;
    let identified = ModelRecord::read(&args.run)?;
    let noise = identified.map(|identified| identified.account.noise_of(&problem.spec().state));
    let Some(planner) = planner(problem, name, model(read)?, &noise.unwrap_or_default())? else {
        return Err(Failure::new(format!("{} has no planner: its algorithm is `{name}`", args.run.display()))
            .hint("run it again with `sindyna train --config RUN/config.toml`"));
    };
    in_time((args, interrupt), config, (problem, read), planner)
}

/// The evaluation of `policy`, with the prediction for controls that act late, as its run knows them.
fn in_time(
    watched: (&Args, &Interrupt),
    config: &TrainConfig,
    (problem, read): (&dyn Problem, ReadFile<'_>),
    policy: impl Policy,
) -> Result<Answer, Failure> {
    let late = config.data.as_ref().map(|data| Late::of((data.delay, data.lag), problem.spec().dt));
    match late.filter(|late| !late.is_now()) {
        None => evaluated(watched, config, problem, &policy),
        Some(late) => evaluated(watched, config, problem, &Predicting::new(policy, problem, model(read)?, late)?),
    }
}

/// The equations of a run.
fn model(read: ReadFile<'_>) -> Result<Model, Failure> {
    Ok(Model::from_json(&String::from_utf8_lossy(&read("model.json")?)).context("model.json is no model")?)
}

fn evaluated(
    (args, interrupt): (&Args, &Interrupt),
    config: &TrainConfig,
    problem: &dyn Problem,
    policy: &dyn Policy,
) -> Result<Answer, Failure> {
    let episodes = args.episodes.unwrap_or(config.evaluation_episodes);
    check_episodes(episodes)?;
    let seed = Seed::new(args.seed.unwrap_or(config.seed));
    let evaluation = match args.common.pool()?.install(|| evaluation(problem, policy, episodes, seed)) {
        Err(_) if interrupt.pressed() => return Ok(Answer::silent(Verdict::Interrupted)),
        evaluation => evaluation?,
    };
    let (name, threshold) = (&problem.spec().name, problem.protocol().solved_at);
    let solved = threshold.map(|mark| evaluation.mean_return >= mark);
    let model = args.model.as_ref().map(|model| model.display().to_string());
    let place = model.as_ref().map_or_else(|| "on the system".into(), |model| format!("in the equations of {model}"));
    let result = Evaluated { task: name, solved, threshold, model: model.as_deref(), evaluation: &evaluation };
    Answer::new(verdict(problem, &evaluation), report((threshold, &place), &evaluation, args.returns), &result)
}

/// Refuses a policy that was made for another task: what it observes and what it does must be what there is.
fn fits(policy: &SavedPolicy, spec: &Spec) -> Result<(), Failure> {
    let name = &spec.name;
    let refuse = |what: String| {
        Err(Failure::new(what).hint("policy.safetensors belongs to the run whose config.toml lies beside it"))
    };
    let (has, needs) = (policy.observation_dim(), spec.observation_dim());
    if has != needs {
        return refuse(format!("the policy observes {has} values, `{name}` shows {needs}"));
    }
    match (policy, &spec.action_space) {
        (SavedPolicy::Gaussian(policy), Space::Box { low, high }) => {
            let (has, takes) = (policy.action_dim(), low.len());
            if has != takes {
                return refuse(format!("the policy has {has} action values, `{name}` takes {takes}"));
            }
            let ends = |low: &[f64], high: &[f64]| low.iter().copied().zip(high.iter().copied()).collect::<Vec<_>>();
            let (acts, taken) = (ends(policy.action_low(), policy.action_high()), ends(low, high));
            let differ = acts.into_iter().zip(taken).enumerate().find(|(_, (acts, taken))| acts != taken);
            differ.map_or(Ok(()), |(i, ((low, high), (least, most)))| {
                refuse(format!("action {i} of the policy goes from {low:?} to {high:?}, that of `{name}` from {least:?} to {most:?}"))
            })
        }
        (SavedPolicy::Categorical(policy), Space::Discrete { controls }) => {
            let (has, takes) = (policy.n_actions(), controls.nrows());
            if has == takes { Ok(()) } else { refuse(format!("the policy has {has} actions, `{name}` takes {takes}")) }
        }
        (SavedPolicy::Gaussian(_), Space::Discrete { .. }) => {
            refuse(format!("the policy has real actions, `{name}` takes numbered ones"))
        }
        (SavedPolicy::Categorical(_), Space::Box { .. }) => {
            refuse(format!("the policy has numbered actions, `{name}` takes real ones"))
        }
    }
}

/// Whether the evaluation reached the task's threshold, in one line.
pub(crate) fn report((threshold, place): (Option<f64>, &str), evaluation: &Evaluation, each: bool) -> String {
    let Evaluation { episodes, mean_return, std_return, returns } = evaluation;
    let judgement = match threshold {
        Some(mark) if *mean_return >= mark => format!(": solved (≥ {})", shortest(mark)),
        Some(mark) => format!(": not solved (< {})", shortest(mark)),
        None => String::new(),
    };
    let (mean, deviation) = (fixed(*mean_return, 1), fixed(*std_return, 1));
    let mut text = format!("return {place}: {mean} ± {deviation} over {episodes} episodes{judgement}\n");
    if each {
        text.extend(returns.iter().map(|r| format!("{r}\n")));
    }
    text
}

/// [`Verdict::MissedTarget`] below the task's threshold.
pub(crate) fn verdict(problem: &dyn Problem, evaluation: &Evaluation) -> Verdict {
    match problem.protocol().solved_at {
        Some(mark) if evaluation.mean_return < mark => Verdict::MissedTarget,
        _ => Verdict::Done,
    }
}

#[cfg(test)]
mod tests {
    use sindyna_rl::Isa;

    use super::*;
    use sindyna_training::problem::named;
    use sindyna_training::settings::agent;

    /// A policy for the task called `name` if its actions were those of `space`.
    fn policy(name: &str, space: Space) -> SavedPolicy {
        let problem = named(name).unwrap();
        let spec = sindyna_core::Spec { action_space: space, ..problem.spec().clone() };
        let settings = TrainConfig::defaults(&*problem.task()).sac;
        let agent = agent(settings, &spec, Isa::Portable, &mut Seed::new(0).stream("any", 0)).unwrap();
        SavedPolicy::from_safetensors(&agent.policy().to_bytes()).unwrap()
    }

    #[test]
    fn only_a_policy_with_the_actions_of_the_task_fits() {
        let range = |low: &[f64], high: &[f64]| Space::Box { low: low.to_vec(), high: high.to_vec() };
        let numbered = |actions: usize| Space::Discrete { controls: ndarray::Array2::zeros((actions, 1)) };
        let of = |name: &str| named(name).unwrap().spec().action_space.clone();
        for (name, space, says) in [
            ("pendulum", range(&[-2.0; 2], &[2.0; 2]), "has 2 action values, `pendulum` takes 1"),
            ("pendulum", range(&[-1e6], &[1e6]), "from -1000000.0 to 1000000.0, that of `pendulum` from -2.0 to 2.0"),
            ("pendulum", numbered(2), "has numbered actions, `pendulum` takes real ones"),
            ("cart-pole", numbered(3), "has 3 actions, `cart-pole` takes 2"),
            ("cart-pole", range(&[-1.0], &[1.0]), "has real actions, `cart-pole` takes numbered ones"),
        ] {
            let refusal = fits(&policy(name, space), named(name).unwrap().spec()).unwrap_err().to_string();
            assert!(refusal.contains(says) && refusal.contains("hint:"), "{refusal}");
        }
        for name in ["pendulum", "cart-pole", "mountain-car"] {
            assert!(fits(&policy(name, of(name)), named(name).unwrap().spec()).is_ok());
        }
        let refusal = fits(&policy("pendulum", of("pendulum")), named("mountain-car").unwrap().spec()).unwrap_err();
        assert!(refusal.to_string().contains("observes 3 values, `mountain-car` shows 2"), "{refusal}");
    }
}
