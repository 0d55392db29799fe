//! `sindyna tasks`: what there is to train on.

use std::fmt::Write as _;

use serde::Serialize;
use sindyna_core::number::shortest;
use sindyna_core::{Channel, Space};
use sindyna_envs::System;
use sindyna_training::problem;

use super::answer::{Answer, Verdict};
use crate::cli::failure::Failure;

/// List the built-in tasks
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Show one task in full: channels, units, bounds, true equations
    #[arg(value_name = "TASK")]
    task: Option<String>,
}

/// What `--json` says of one task in a list.
#[derive(Serialize)]
struct Listed<'a> {
    name: &'a str,
    gymnasium_id: Option<&'a str>,
    summary: &'a str,
}

/// What `--json` says of one task in full.
#[derive(Serialize)]
struct Detailed<'a> {
    #[serde(flatten)]
    listed: Listed<'a>,
    state: Vec<Declared<'a>>,
    observation: Vec<Declared<'a>>,
    control: Vec<Declared<'a>>,
    actions: Actions<'a>,
    dt: f64,
    max_steps: usize,
    threshold: Option<f64>,
    equations: Vec<String>,
}

/// A channel; `null` for no bound.
#[derive(Serialize)]
struct Declared<'a> {
    name: &'a str,
    unit: &'a str,
    low: f64,
    high: f64,
}

/// What an agent may do.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Actions<'a> {
    Box {
        low: &'a [f64],
        high: &'a [f64],
    },
    /// Each with the control that it puts on the system.
    Discrete {
        controls: Vec<Vec<f64>>,
    },
}

impl<'a> Actions<'a> {
    fn of(space: &'a Space) -> Self {
        match space {
            Space::Box { low, high } => Self::Box { low, high },
            Space::Discrete { controls } => {
                Self::Discrete { controls: controls.rows().into_iter().map(|row| row.to_vec()).collect() }
            }
        }
    }
}

impl<'a> Listed<'a> {
    fn of(system: &'a System) -> Self {
        Self { name: system.name(), gymnasium_id: system.gymnasium_id(), summary: system.summary() }
    }
}

impl<'a> Detailed<'a> {
    fn of(system: &'a System) -> Self {
        let (spec, protocol) = (system.spec(), system.protocol());
        let declared = |channels: &'a [Channel]| {
            let one = |c: &'a Channel| Declared {
                name: &c.name,
                unit: &c.unit,
                low: c.prior.bounds.0,
                high: c.prior.bounds.1,
            };
            channels.iter().map(one).collect()
        };
        Self {
            listed: Listed::of(system),
            state: declared(&spec.state),
            observation: declared(&spec.observation),
            control: declared(&spec.control),
            actions: Actions::of(&spec.action_space),
            dt: spec.dt,
            max_steps: protocol.max_steps,
            threshold: protocol.solved_at,
            equations: system.true_equations().iter().map(ToString::to_string).collect(),
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<Answer, Failure> {
    match &args.task {
        None => {
            let systems = sindyna_envs::systems();
            let list: Vec<Listed<'_>> = systems.iter().map(Listed::of).collect();
            Answer::new(Verdict::Done, overview(&systems), &serde_json::json!({"tasks": list}))
        }
        Some(name) => {
            let system = problem::system(name)?;
            Answer::new(Verdict::Done, details(&system), &Detailed::of(&system))
        }
    }
}
fn overview(systems: &[System]) -> String {
    let width = systems.iter().map(|s| s.name().len()).max().unwrap_or(0);
    let mut text = String::new();
    for system in systems {
        let _ = writeln!(text, "{:width$}  {}{}", system.name(), system.summary(), alias(system));
    }
    text.push_str("\nsindyna tasks TASK shows its details; sindyna train TASK trains a controller.\n");
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
    let sindyna_core::Protocol { max_steps, solved_at } = system.protocol();
    let solved = solved_at.map_or("not defined".into(), |s| format!("at a mean return of {s}"));
    let _ = writeln!(text, "step {} s, episodes of at most {max_steps} steps, solved {solved}", spec.dt);
    text.push_str("\ntrue equations\n");
    for equation in system.true_equations() {
        let _ = writeln!(text, "  {equation}");
    }
    text
}

fn describe(channel: &Channel) -> String {
    let unit = if channel.unit.is_empty() { String::new() } else { format!(" [{}]", channel.unit) };
    let bounds = match channel.prior.bounds {
        (low, high) if low.is_finite() || high.is_finite() => format!(", {} to {}", shortest(low), shortest(high)),
        _ => String::new(),
    };
    format!("{}{unit}{bounds}", channel.name)
}
