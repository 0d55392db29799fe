//! Logs of real pendulums: equations from some, predictions of others.
//!
//! Runs `sindyna identify` on logs of a simple and of a double pendulum, with the columns named and no other option, and predicts logs that were not used. Writes results/hardware.json
//! and docs/hardware.md. The logs are those of the DFKI Underactuated Lab and are not in the repository. What was run before is taken from runs/hardware; delete that
//! folder after a change of the identifier.

mod identified;
mod intervals;
mod page;
mod rest;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::Parser;
use identified::{Machine, Run};
use page::Figures;
use sindyna_bench::study::{Result, Sindyna, kept, study};

/// The simple pendulum: each log is predicted by the equations of the two others.
const SIMPLE: Machine = Machine { folder: "simple-pendulum", columns: &[] };
const SIMPLE_LOGS: [&str; 3] = ["sac", "energy_shaping", "pd_system_identification"];

/// The double pendulum: its measured columns.
const DOUBLE: Machine = Machine {
    folder: "double-pendulum",
    columns: &["--states", "pos_meas1,pos_meas2,vel_meas1,vel_meas2", "--inputs", "tau_meas1,tau_meas2"],
};
const DOUBLE_LOGS: [&str; 4] = ["c1_143339", "c1_143524", "c1_143601", "c1_143704"];
const SWING_UPS: [&str; 4] = [
    "swing-ups/acrobot_ilqr_01",
    "swing-ups/acrobot_ilqr_02",
    "swing-ups/pendubot_ilqr_01",
    "swing-ups/pendubot_ilqr_02",
];

/// Part of a log that is enough \[s\].
const FEW: f64 = 2.0;

#[derive(Debug, Parser)]
struct Options {
    /// Folder with `simple-pendulum` and `double-pendulum`.
    #[arg(long)]
    data: Option<PathBuf>,
    /// Write the page from the results that are there, and run nothing.
    #[arg(long)]
    page_only: bool,
    /// Stem of the files in results and docs.
    #[arg(long, default_value = "hardware")]
    out: String,
}

fn main() -> Result {
    let options = Options::parse();
    let measured = || {
        let data = options.data.as_deref().ok_or_else(|| anyhow::anyhow!("--data DIR is missing"))?;
        measure(data)
    };
    study((&options.out, &format!("docs/{}.md", options.out)), options.page_only, measured, page::page)
}

fn measure(data: &Path) -> Result<Figures> {
    let sindyna = Sindyna::build()?;
    let run =
        |machine: &Machine, name: &str, (logs, seconds): (&[&str], Option<f64>), held_out: &[&str]| -> Result<Run> {
            let path = format!("hardware/{}-{name}.json", machine.folder);
            let run = kept(path, || identified::run(sindyna.path(), (data, machine), (logs, seconds), held_out))?;
            writeln!(io::stderr(), "{} {name}: {} rows, {:.1} s", machine.folder, run.rows, run.seconds)?;
            Ok(run)
        };
    let others = |all: &[&'static str], of: &[&str]| -> Vec<&'static str> {
        all.iter().copied().filter(|log| !of.contains(log)).collect()
    };
    let mut simple = Vec::new();
    for log in SIMPLE_LOGS {
        simple.push(run(&SIMPLE, &format!("for-{log}"), (&others(&SIMPLE_LOGS, &[log]), None), &[log])?);
    }
    let mut double = Vec::new();
    for pair in [[DOUBLE_LOGS[2], DOUBLE_LOGS[3]], [DOUBLE_LOGS[0], DOUBLE_LOGS[1]]] {
        double.push(run(&DOUBLE, &pair.join("-"), (&pair, None), &others(&DOUBLE_LOGS, &pair))?);
    }
    let alone = DOUBLE_LOGS[2];
    double.push(run(&DOUBLE, "two-seconds", (&[alone], Some(FEW)), &others(&DOUBLE_LOGS, &[alone]))?);
    let all = run(&DOUBLE, "all", (&DOUBLE_LOGS, None), &SWING_UPS)?;
    let of_one = |machine: &Machine, logs: &[&str]| -> Result<Vec<Run>> {
        logs.iter().map(|log| run(machine, &format!("only-{log}"), (&[log], None), &[])).collect()
    };
    let (simple_alone, double_alone) = (of_one(&SIMPLE, &SIMPLE_LOGS)?, of_one(&DOUBLE, &DOUBLE_LOGS)?);
    let from_rest = |run: &Run| -> Result<Vec<rest::FromRest>> {
        SWING_UPS.iter().map(|log| rest::from_rest(run, &DOUBLE.path(data, log))).collect()
    };
    let mut swing_ups = Vec::new();
    for run in double.iter().chain([&all]) {
        swing_ups.push((run.name(), from_rest(run)?));
    }
    Ok(Figures { simple, double, all, simple_alone, double_alone, swing_ups })
}
