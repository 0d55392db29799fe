//! `sindyna tasks`: what there is to train on.

use std::fmt::Write as _;

use sindyna_core::{Channel, Space};
use sindyna_envs::System;

use super::common::{Verdict, print};
use crate::cli::failure::Failure;
use crate::problem;
use sindyna_core::number::shortest;

/// Lists the systems there are to train on
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Show one task in full: channels, units, bounds, true equations
    #[arg(value_name = "TASK")]
    task: Option<String>,
}

pub(crate) fn run(args: &Args) -> Result<Verdict, Failure> {
    let text = match &args.task {
        None => overview(&sindyna_envs::systems()),
        Some(name) => details(&problem::system(name)?),
    };
    print(&text)?;
    Ok(Verdict::Done)
}

fn overview(systems: &[System]) -> String {
    let width = systems.iter().map(|s| s.name().len()).max().unwrap_or(0);
    let mut text = String::new();
    for system in systems {
        let _ = writeln!(text, "{:width$}  {}{}", system.name(), system.summary(), alias(system));
    }
    text.push_str("\nsindyna tasks TASK shows one in full; sindyna train TASK learns it.\n");
    text
}

/// Gymnasium's name in parentheses, where it has one.
fn alias(system: &System) -> String {
    system.gymnasium_id().map_or(String::new(), |id| format!(" ({id})"))
}

fn details(system: &System) -> String {
    let spec = system.spec();
    let mut text = format!("{}{}\n{}\n\n", system.name(), alias(system), system.summary());
    for (title, channels) in [("state", &spec.state), ("observation", &spec.observation), ("control", &spec.control)] {
        let _ = writeln!(text, "{title}");
        for channel in channels {
            let _ = writeln!(text, "  {}", describe(channel));
        }
    }
    match &spec.action_space {
        Space::Box { low, high } => {
            let list = |ends: &[f64]| ends.iter().copied().map(shortest).collect::<Vec<_>>().join(", ");
            let _ = writeln!(text, "actions: real, from {} to {}", list(low), list(high));
        }
        Space::Discrete { controls } => {
            let _ = writeln!(
                text,
                "actions: {} numbered, with controls {:?}",
                controls.nrows(),
                controls.column(0).to_vec()
            );
        }
    }
    let solved = spec.solved_at.map_or("not defined".into(), |s| format!("at a mean return of {s}"));
    let _ = writeln!(text, "step {} s, episodes of at most {} steps, solved {solved}", spec.dt, spec.max_steps);
    text.push_str("\ntrue equations\n");
    for equation in system.true_equations() {
        let _ = writeln!(text, "  {equation}");
    }
    text
}

fn describe(channel: &Channel) -> String {
    let unit = if channel.unit.is_empty() { String::new() } else { format!(" [{}]", channel.unit) };
    let bounds = match channel.bounds {
        (low, high) if low.is_finite() || high.is_finite() => format!(", {} to {}", shortest(low), shortest(high)),
        _ => String::new(),
    };
    format!("{}{unit}{bounds}", channel.name)
}
