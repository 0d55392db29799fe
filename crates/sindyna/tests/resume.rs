//! `sindyna train --resume`: the record of a run that was cut off becomes what it would have been.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use common::{command, parts, sindyna};

/// Begins a run with `options` in `directory` and lets it come to its end.
fn run(directory: &Path, options: &[&str]) -> i32 {
    let args = [&["train", "--max-updates", "250", "--episodes", "5", "--quiet", "--out", "whole"], options].concat();
    let (code, stdout, stderr) = parts(&sindyna(directory, &args));
    assert!(code < 2, "{options:?}: {stdout}{stderr}");
    code
}

/// Exit code and stderr of `--resume` in the folder `name` of `directory`.
fn resume(directory: &Path, name: &str) -> (i32, String) {
    let (code, _, stderr) = parts(&sindyna(directory, &["train", "--resume", name, "--quiet"]));
    (code, stderr)
}

/// Copies the files called `names` of the run `whole` into a new run called `cut`.
fn cut(directory: &Path, names: &[&str]) {
    let (whole, cut) = (directory.join("whole"), directory.join("cut"));
    drop(fs::remove_dir_all(&cut));
    fs::create_dir(&cut).unwrap();
    for name in names {
        fs::copy(whole.join(name), cut.join(name)).unwrap();
    }
}

fn same_record(directory: &Path, what: &str) {
    for name in [
        "config.toml",
        "rollout.csv",
        "model.json",
        "policy.safetensors",
        "events.jsonl",
        "summary.json",
        "identify.json",
        "prediction.csv",
        "episode.csv",
        "report.html",
    ] {
        // A model of what is observed has no episode beside it.
        let of = |run: &str| fs::read(directory.join(run).join(name)).ok();
        assert!(name == "episode.csv" || of("whole").is_some(), "{name} is missing: {what}");
        assert!(of("whole") == of("cut"), "{name} differs: {what}");
    }
}

#[test]
fn every_option_is_the_same_again_when_a_run_is_resumed() {
    for options in [
        &["pendulum", "--noise", "0.01", "--real-steps", "100"][..],
        &["cart-pole", "--noise", "0.001", "--imagined-rollouts", "100"],
        &["pendulum", "--explorer", "random", "--real-steps", "40", "--seed", "18446744073709551615"],
        &["mountain-car", "--isa", "portable", "--term", "sin(2*x)"],
        &["pendulum", "--library", "paper", "--solver", "stlsq", "--threshold", "0.01", "--batch-size", "64"],
    ] {
        let temp = tempfile::tempdir().unwrap();
        let code = run(temp.path(), options);
        // The last one is cut off before there are data, too.
        let lefts = [&["config.toml", "rollout.csv"][..], &["config.toml"]];
        for left in &lefts[..1 + usize::from(options.contains(&"stlsq"))] {
            cut(temp.path(), left);
            let (again, stderr) = resume(temp.path(), "cut");
            assert_eq!(again, code, "{options:?}, {left:?}: {stderr}");
            same_record(temp.path(), &format!("{options:?}, {left:?}"));
        }
    }
}

#[test]
fn a_configuration_no_run_can_have_is_refused_when_it_is_resumed() {
    let temp = tempfile::tempdir().unwrap();
    run(temp.path(), &["pendulum"]);
    let config = fs::read_to_string(temp.path().join("whole/config.toml")).unwrap();
    for (setting, says) in [
        ("evaluation_episodes = 0", "evaluation_episodes must be at least 1"),
        ("scattered_starts = 2.0", "scattered_starts must be between 0 and 1"),
        ("trial_episodes = 0", "trial_episodes must be at least 1"),
        ("systems = 0", "imagination.systems must be at least 1"),
        ("updates_per_turn = 0", "updates_per_turn must be at least 1"),
        ("batch_size = 1000000000000", "sac.batch_size must be at most 65536"),
        ("rollouts = 1000000000000", "at most 100000 over all rollouts"),
        ("noise = 2.0", "noise must be between 0 and 1"),
    ] {
        cut(temp.path(), &[]);
        let key = setting.split(" = ").next().unwrap();
        let changed: Vec<&str> =
            config.lines().map(|line| if line.starts_with(&format!("{key} = ")) { setting } else { line }).collect();
        fs::write(temp.path().join("cut/config.toml"), changed.join("\n")).unwrap();
        let (code, stderr) = resume(temp.path(), "cut");
        assert!(code == 2 && stderr.contains(says) && !stderr.contains("panicked"), "{setting}: {stderr}");
    }
}

#[test]
fn a_run_that_lacks_a_file_is_not_finished() {
    let temp = tempfile::tempdir().unwrap();
    let code = run(temp.path(), &["pendulum"]);
    let all = ["config.toml", "rollout.csv", "model.json", "policy.safetensors", "events.jsonl", "timing.json"];
    for lost in &all[1..] {
        let left: Vec<&str> = all.iter().copied().filter(|name| name != lost).chain(["summary.json"]).collect();
        cut(temp.path(), &left);
        let (again, _, stderr) = parts(&sindyna(temp.path(), &["train", "--resume", "cut"]));
        assert_eq!(again, code, "{lost}: {stderr}");
        assert!(stderr.contains(&format!("{lost} is missing")), "{stderr}");
        same_record(temp.path(), lost);
        assert!(temp.path().join("cut/timing.json").is_file());
    }
}

#[test]
fn a_command_killed_before_its_record_began_can_be_given_again() {
    let temp = tempfile::tempdir().unwrap();
    let at = |name: &str| temp.path().join(name);
    let log = at("log.csv");
    let rows: String = (0..60).map(|i| format!("{},{}\n", f64::from(i) * 0.1, (f64::from(i) * -0.05).exp())).collect();
    fs::write(&log, format!("t,x\n{rows}")).unwrap();
    for args in [
        &["train", "pendulum", "--max-updates", "250", "--episodes", "5", "--quiet"][..],
        &["identify", "log.csv", "--states", "x", "--quiet"],
    ] {
        fs::create_dir(at("out")).unwrap();
        fs::write(at("out/.unfinished-abc"), "half a").unwrap();
        let (code, _, stderr) = parts(&sindyna(temp.path(), &[args, &["--out", "out"]].concat()));
        assert!(code < 2 && !at("out/.unfinished-abc").exists(), "{args:?}: {stderr}");
        let (code, _, stderr) = parts(&sindyna(temp.path(), &[args, &["--out", "out"]].concat()));
        assert!(code == 2 && stderr.contains("out exists already"), "{stderr}");
        fs::remove_dir_all(at("out")).unwrap();
    }
}

#[test]
fn a_long_run_goes_on_from_its_checkpoint() {
    let temp = tempfile::tempdir().unwrap();
    let at = |name: &str| temp.path().join(name);
    let options = ["cart-pole-swing-up", "--set", "sac.hidden=[256,256]", "--max-updates", "1500"];
    let begin = |name| {
        let args = [&["train", "--episodes", "5", "--quiet", "--out", name][..], &options].concat();
        command(temp.path(), &args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let whole = begin("whole").wait().unwrap().code();
    let mut killed = begin("killed");
    // A checkpoint is written every second or so; however slow the machine, there is one before the end.
    while !at("killed/checkpoint.bin").exists() {
        assert!(killed.try_wait().unwrap().is_none(), "it has ended without a checkpoint");
        sleep(Duration::from_millis(5));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let files: Vec<_> = fs::read_dir(at("killed")).unwrap().map(|e| e.unwrap().file_name()).collect();
    let kept: Vec<&str> = files.iter().map(|name| name.to_str().unwrap()).collect();
    let saved = fs::read(at("killed/checkpoint.bin")).unwrap();
    let damaged = [&saved[..saved.len() / 2], &[!saved[saved.len() / 2]], &saved[saved.len() / 2 + 1..]].concat();
    let goes_on = |whole: Option<i32>, checkpoint: &[u8], told: &str| {
        fs::write(at("cut/checkpoint.bin"), checkpoint).unwrap();
        let (code, _, stderr) = parts(&sindyna(temp.path(), &["train", "--resume", "cut"]));
        assert!(Some(code) == whole && stderr.contains(told), "{code} {stderr}");
        same_record(temp.path(), told);
        assert!(!at("cut/checkpoint.bin").exists(), "the run is over");
    };
    fs::create_dir(at("cut")).unwrap();
    for name in &kept {
        fs::copy(at("killed").join(name), at("cut").join(name)).unwrap();
    }
    goes_on(whole, &saved, "continuing after ");
    // What cannot be gone on from is told, and the run begins anew: a short one is enough to see that.
    fs::remove_dir_all(at("whole")).unwrap();
    let whole = Some(run(temp.path(), &["pendulum"]));
    for (checkpoint, told) in
        [(&damaged, "checkpoint.bin is damaged, so the run restarts"), (&saved, "config.toml was changed since")]
    {
        cut(temp.path(), &["config.toml"]);
        goes_on(whole, checkpoint, told);
    }
}
