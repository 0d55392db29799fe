//! `sindyna evaluate`: a trained policy on the real system again.

use std::path::PathBuf;

use anyhow::Context as _;
use sindyna_core::{Policy, Seed, Space};
use sindyna_dyna::evaluate;
use sindyna_rl::SavedPolicy;

use super::{Common, Verdict, print};
use crate::config::{TrainConfig, check_episodes};
use crate::failure::Failure;
use crate::problem::Problem;
use crate::real::Real;
use crate::record::Evaluation;

/// Runs a trained policy on the real system again
///
/// Without options this repeats the evaluation of the run itself: same start states, same returns.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct Args {
    /// Directory a run left
    #[arg(value_name = "RUN")]
    run: PathBuf,
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
    common: Common,
}

pub(crate) fn run(args: &Args) -> Result<Verdict, Failure> {
    let read = |name: &str| {
        let path = args.run.join(name);
        std::fs::read(&path).with_context(|| format!("cannot read {}", path.display())).map_err(|e| {
            Failure::from(e)
                .hint("RUN is a directory that `sindyna train` left, with config.toml and policy.safetensors")
        })
    };
    let config = TrainConfig::parse(&String::from_utf8_lossy(&read("config.toml")?))
        .with_context(|| format!("{} is not a run's configuration", args.run.join("config.toml").display()))?;
    if !args.run.join("policy.safetensors").exists() {
        let config = args.run.join("config.toml");
        return Err(Failure::new(format!("{} holds no policy: its training left none", args.run.display()))
            .hint(format!("run it again with `sindyna train --config {}`", config.display())));
    }
    let policy = SavedPolicy::from_safetensors(&read("policy.safetensors")?)
        .with_context(|| format!("{} is not a policy", args.run.join("policy.safetensors").display()))?;
    let problem = Problem::of(&config, &args.run)?.with_noise(args.noise.unwrap_or(config.noise))?;
    let episodes = args.episodes.unwrap_or(config.evaluation_episodes);
    check_episodes(episodes)?;
    let seed = Seed::new(args.seed.unwrap_or(config.seed));
    let real = Real::new(&problem, &config.simulator)?;
    fits(&policy, &problem)?;
    let evaluation = args.common.pool()?.install(|| on_real_system(&real, &policy, episodes, seed))?;
    print(&report(&problem, &evaluation, args.returns))?;
    Ok(verdict(&problem, &evaluation))
}

/// Refuses a policy that was made for another task.
fn fits(policy: &SavedPolicy, problem: &Problem) -> Result<(), Failure> {
    let spec = problem.spec();
    let (has, needs) = (policy.observation_dim(), spec.observation_dim());
    let numbered = matches!(spec.action_space, Space::Discrete { .. });
    let name = problem.name();
    if has != needs {
        return Err(Failure::new(format!("the policy observes {has} values, `{name}` shows {needs}")));
    }
    if numbered != matches!(policy, SavedPolicy::Categorical(_)) {
        let (acts, takes) = if numbered { ("real", "numbered") } else { ("numbered", "real") };
        return Err(Failure::new(format!("the policy has {acts} actions, `{name}` takes {takes} ones")));
    }
    Ok(())
}

/// The returns of `policy` (its best actions) on the real system, from start states fixed by `seed`.
pub(crate) fn on_real_system(
    real: &Real,
    policy: &dyn Policy,
    episodes: usize,
    seed: Seed,
) -> Result<Evaluation, Failure> {
    let mut envs = (0..episodes).map(|_| real.environment()).collect::<Result<Vec<_>, _>>()?;
    let returns = evaluate(&mut envs, policy, episodes, seed, "evaluation")?;
    real.check()?;
    Ok(Evaluation::of(returns))
}

/// Whether the evaluation reached the task's threshold, in one line.
pub(crate) fn report(problem: &Problem, evaluation: &Evaluation, each: bool) -> String {
    let Evaluation { episodes, mean_return, std_return, returns } = evaluation;
    let judgement = match problem.spec().solved_at {
        Some(mark) if *mean_return >= mark => format!(": solved (≥ {mark})"),
        Some(mark) => format!(": not solved (< {mark})"),
        None => String::new(),
    };
    let mut text =
        format!("return on the real system: {mean_return:.1} ± {std_return:.1} over {episodes} episodes{judgement}\n");
    if each {
        text.extend(returns.iter().map(|r| format!("{r}\n")));
    }
    text
}

/// [`Verdict::MissedTarget`] below the task's threshold.
pub(crate) fn verdict(problem: &Problem, evaluation: &Evaluation) -> Verdict {
    match problem.spec().solved_at {
        Some(mark) if evaluation.mean_return < mark => Verdict::MissedTarget,
        _ => Verdict::Done,
    }
}
