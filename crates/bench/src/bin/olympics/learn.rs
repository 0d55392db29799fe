//! Two seconds of noisy data, and the equations that the command finds in them.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, bail};
use rand::RngExt as _;
use sindyna_bench::study::Result;
use sindyna_core::{Diverged, Dynamics as _, Seed};
use sindyna_sindy::Model;

use super::plant::{DT, Plant, Robot, deviate, stepped};

/// Samples of a log, and steps of the simulator from one to the next.
const SAMPLES: usize = 100;
const PER_SAMPLE: usize = 10;

/// Standard deviations of the rig: angles \[rad\] and rates \[rad/s\].
const ANGLES: f64 = 0.001;
const RATES: f64 = 0.1;

/// Largest torque of the excitation \[N m\], and samples for which each is held.
const PUSH: f64 = 5.0;
const HELD: std::ops::RangeInclusive<usize> = 6..=8;

/// What was learned.
pub(crate) struct Learned {
    pub(crate) model: Model,
    /// Wall time of the identification \[s\].
    pub(crate) seconds: f64,
    /// Whether every equation is called adequate.
    pub(crate) adequate: bool,
}

/// A log of `robot` from rest, hanging, its driven joint pushed to one side and the other.
fn log(robot: Robot, seed: u64) -> std::result::Result<String, Diverged> {
    let (simulator, mut rng) = (stepped(Plant::NOMINAL), Seed::new(seed).stream("log", 0));
    let mut text = String::from("t,q1,q2,dq1,dq2,tau\n");
    let (mut x, mut push, mut left, mut side) = ([0.0; 4], 0.0, 0, 1.0);
    for sample in 0..=SAMPLES {
        if left == 0 {
            (left, side) = (rng.random_range(HELD), -side);
            push = side * PUSH * rng.random_range(0.3..1.0);
        }
        left -= 1;
        let seen: [f64; 4] = std::array::from_fn(|i| x[i] + deviate(if i < 2 { ANGLES } else { RATES }, &mut rng));
        let t = sample as f64 * PER_SAMPLE as f64 * DT;
        let _ = writeln!(text, "{t},{},{},{},{},{push}", seen[0], seen[1], seen[2], seen[3]);
        let mut torque = [0.0; 2];
        torque[robot.joint()] = push;
        for _ in 0..PER_SAMPLE {
            let before = x;
            simulator.step(&before, &torque, &mut rng, &mut x)?;
        }
    }
    Ok(text)
}

/// Runs `sindyna identify` on a log of `robot`.
pub(crate) fn learn(program: &Path, robot: Robot, seed: u64) -> Result<Learned> {
    let folder = tempfile::tempdir()?;
    let (file, out) = (folder.path().join("log.csv"), folder.path().join("model"));
    fs::write(&file, log(robot, seed)?)?;
    let start = Instant::now();
    let done = Command::new(program)
        .args([
            "identify",
            "--no-report",
            "--quiet",
            "--strict",
            "--angles",
            "q1,q2",
            "--delay",
            "0",
            "--lag",
            "0",
            "--out",
        ])
        .args([&out, &file])
        .stdin(Stdio::null())
        .output()?;
    let seconds = start.elapsed().as_secs_f64();
    if !matches!(done.status.code(), Some(0 | 1)) {
        bail!("{} {seed}: {}", robot.name(), String::from_utf8_lossy(&done.stderr));
    }
    let text = fs::read_to_string(out.join("model.json")).context("no model")?;
    let adequate = done.status.code() == Some(0);
    Ok(Learned { model: Model::from_json(&text)?, seconds, adequate })
}
