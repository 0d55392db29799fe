//! Our systems against rollouts recorded from Gymnasium, row by row and episode start by episode start.
//!
//! `SINDYNA_REFERENCE` names another folder of recordings. `--nocapture` prints the largest deviation of every file.

#![allow(clippy::print_stdout, reason = "the largest deviations are shown to whoever asks with --nocapture")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sindyna_core::{Environment as _, Precision, Rng, Seed};
use sindyna_envs::System;

/// A recording of `<Gymnasium id>-seed<seed>.csv`.
struct Recording {
    file: String,
    system: System,
    seed: u64,
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Recording {
    fn read(path: &Path) -> Self {
        let file = path.file_name().and_then(|f| f.to_str()).expect("file names are UTF-8").to_string();
        let (id, seed) = file.trim_end_matches(".csv").split_once("-seed").unwrap_or_else(|| {
            panic!("{file}: the name must be <Gymnasium id>-seed<number>.csv");
        });
        let system = sindyna_envs::find(id).unwrap_or_else(|| panic!("{file}: no system has the id {id}"));
        let seed = seed.parse().unwrap_or_else(|e| panic!("{file}: seed {seed}: {e}"));
        let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{file}: {e}"));
        let mut lines = text.lines();
        let header: Vec<String> = lines.next().expect("a header").split(',').map(str::to_string).collect();
        let rows = lines.enumerate().map(|(i, line)| {
            let parse = |v: &str| v.parse().unwrap_or_else(|e| panic!("{file}, row {i}: {v}: {e}"));
            line.split(',').map(parse).collect()
        });
        let rows = rows.collect();
        Self { file, system, seed, header, rows }
    }

    fn column(&self, name: &str) -> usize {
        let found = self.header.iter().position(|h| h == name);
        found.unwrap_or_else(|| panic!("{}: no column {name}", self.file))
    }

    /// The columns `prefix0`, `prefix1`, … of a row.
    fn group<'a>(&self, row: &'a [f64], prefix: &str, len: usize) -> &'a [f64] {
        let first = self.column(&format!("{prefix}0"));
        assert_eq!(self.column(&format!("{prefix}{}", len - 1)), first + len - 1, "{}: {prefix}*", self.file);
        &row[first..first + len]
    }
}

fn recordings() -> Vec<Recording> {
    let folder = std::env::var_os("SINDYNA_REFERENCE")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference"), PathBuf::from);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<_> = entries.map(|e| e.expect("a readable folder").path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "csv"));
    paths.sort();
    assert!(!paths.is_empty(), "{} holds no recordings", folder.display());
    paths.iter().map(|p| Recording::read(p)).collect()
}

/// Deviations of one file: the largest of every group of columns, and a line for each that is too large.
struct Verdict<'a> {
    file: &'a str,
    worst: BTreeMap<&'static str, f64>,
    complaints: Vec<String>,
}

impl<'a> Verdict<'a> {
    fn new(file: &'a str) -> Self {
        Self { file, worst: BTreeMap::new(), complaints: Vec::new() }
    }

    /// Compares values of `row`; each may deviate by `tolerance` of itself, or absolutely if it is smaller than 1.
    fn check(&mut self, group: &'static str, row: usize, got: &[f64], recorded: &[f64], tolerance: f64) {
        for (i, (&g, &r)) in got.iter().zip(recorded).enumerate() {
            let deviation = if g.to_bits() == r.to_bits() { 0.0 } else { (g - r).abs() / r.abs().max(1.0) };
            let worst = self.worst.entry(group).or_insert(0.0);
            *worst = worst.max(deviation);
            if deviation.is_nan() || deviation > tolerance {
                let file = self.file;
                self.complaints.push(format!("{file}, row {row}, {group} {i}: recorded {r:e}, got {g:e}"));
            }
        }
    }

    fn conclude(self) -> Vec<String> {
        let figures: Vec<_> = self.worst.iter().map(|(group, worst)| format!("{group} {worst:.1e}")).collect();
        println!("{}: {}", self.file, figures.join(", "));
        self.complaints
    }
}

fn demand_none(complaints: &[String]) {
    let shown = complaints.len().min(20);
    assert!(complaints.is_empty(), "{} deviations:\n{}", complaints.len(), complaints[..shown].join("\n"));
}

/// How far a next state may be off, and what it is called.
fn next_state_tolerance(system: &System, x: &[f64], next: &[f64]) -> (&'static str, f64) {
    match system.name() {
        "mountain-car" => ("next state", 0.0),
        // MuJoCo solves for the stops' forces by iteration, to 1e-8 of its own cost.
        "inverted-pendulum" if x[0].abs().max(next[0].abs()) > 0.9 => ("next state at a stop", 1e-6),
        "inverted-pendulum" => ("next state", 1e-9),
        _ => ("next state", 1e-12),
    }
}

/// One float32 rounding step: a cosine may round the other way where two mathematics libraries differ in the last bit.
fn observation_tolerance(system: &System, state_tolerance: f64) -> f64 {
    match system.spec().precision {
        Precision::F64 => state_tolerance,
        Precision::F32 if system.name() == "mountain-car" => 0.0,
        Precision::F32 => f64::from(f32::EPSILON),
    }
}

#[test]
fn every_recorded_step_is_reproduced() {
    let mut complaints = Vec::new();
    for recording in recordings() {
        let system = &recording.system;
        let spec = system.spec();
        let (n, m, k) = (spec.state_dim(), spec.observation_dim(), spec.action_space.action_dim());
        let [episode, reward, terminated, truncated] =
            ["episode", "reward", "terminated", "truncated"].map(|c| recording.column(c));
        let mut env = system.environment();
        let mut rng = Seed::new(0).numpy();
        let mut verdict = Verdict::new(&recording.file);
        let mut steps = 0;
        for (i, row) in recording.rows.iter().enumerate() {
            let begins = i == 0 || recording.rows[i - 1][episode].to_bits() != row[episode].to_bits();
            steps = if begins { 1 } else { steps + 1 };
            let (x, next) = (recording.group(row, "s", n), recording.group(row, "s_next", n));
            let (what, tolerance) = next_state_tolerance(system, x, next);

            env.reset_to(x, &mut rng);
            let o_tolerance = observation_tolerance(system, 0.0);
            verdict.check("observation", i, env.observation(), recording.group(row, "o", m), o_tolerance);
            let outcome = env.step(recording.group(row, "a", k), &mut rng).expect("a recorded step can be made");
            verdict.check(what, i, env.state(), next, tolerance);
            let o_tolerance = observation_tolerance(system, tolerance);
            verdict.check("next observation", i, env.observation(), recording.group(row, "n", m), o_tolerance);
            verdict.check("reward", i, &[outcome.reward], &row[reward..=reward], 1e-12);
            let ends = [outcome.terminated, steps >= system.protocol().max_steps].map(|end| f64::from(u8::from(end)));
            verdict.check("terminated", i, &ends[..1], &row[terminated..=terminated], 0.0);
            verdict.check("truncated", i, &ends[1..], &row[truncated..=truncated], 0.0);
        }
        complaints.extend(verdict.conclude());
    }
    demand_none(&complaints);
}

#[test]
fn every_recorded_episode_begins_where_ours_does() {
    let mut complaints = Vec::new();
    for recording in recordings() {
        let n = recording.system.spec().state_dim();
        let episode = recording.column("episode");
        let task = recording.system.task();
        let mut rng: Rng = Seed::new(recording.seed).numpy();
        let mut x = vec![0.0; n];
        let mut verdict = Verdict::new(&recording.file);
        let mut previous = -1.0;
        for (i, row) in recording.rows.iter().enumerate() {
            if row[episode] <= previous {
                continue;
            }
            previous = row[episode];
            task.initial(&mut rng, &mut x);
            let recorded = recording.group(row, "s", n);
            // The recorder moved some episodes next to a limit after the reset; the reset was drawn all the same.
            if ![2.3, 0.97].contains(&recorded[0]) {
                verdict.check("start", i, &x, recorded, 0.0);
            }
        }
        complaints.extend(verdict.conclude());
    }
    demand_none(&complaints);
}
