//! Whatever goes wrong gets a message that helps and the exit code that was promised; nothing is lost.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::process::Stdio;

use common::{command, json, parts, sindyna};

/// Runs `args` in a fresh directory and expects exit code 2, no stdout, and all of `words` on stderr.
fn refuses(args: &[&str], words: &[&str]) {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), args));
    assert_eq!((code, stdout.as_str()), (2, ""), "{args:?}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{args:?} should say {word:?}: {stderr}");
    }
    assert!(!stderr.contains("panicked"), "{stderr}");
}

#[test]
fn unknown_names_are_answered_with_the_known_ones() {
    refuses(&["train", "cartpole"], &["no task named `cartpole`", "`mountain-car`", "did you mean `cart-pole`?"]);
    refuses(&["train", "pendulum", "--library", "papr"], &["papr", "paper", "auto"]);
    refuses(&["train", "pendulum", "--solver", "lasso"], &["lasso", "best-subset", "stlsq"]);
    refuses(&["train", "pendulum", "--target", "x"], &["motion", "increment", "discrete", "continuous"]);
    refuses(&["train", "pendulum", "--isa", "sse9"], &["sse9", "portable", "avx512"]);
    refuses(&["train", "pendulum", "--explorer", "alternate"], &["'alternate'", "did you mean `alternating`?"]);
    refuses(&["train", "pendulum", "--term", "sin(phi)"], &["phi"]);
    refuses(&["tasks", "walker"], &["no task named `walker`"]);
    refuses(&["train", "--polcy"], &["--polcy"]);
}

#[test]
fn settings_out_of_range_are_named_with_their_bound() {
    refuses(&["train", "pendulum", "--real-steps", "0"], &["at least 1", "got 0"]);
    refuses(&["train", "pendulum", "--real-steps", "3"], &["3 real steps are too few", "at least 4", "--real-steps"]);
    refuses(&["train", "pendulum", "--real-steps", "99999999"], &["99999999", "100000"]);
    refuses(&["train", "pendulum", "--real-steps", "-4"], &["--real-steps"]);
    refuses(&["train", "pendulum", "--real-steps", "5", "--warmup-rollouts", "2"], &["5", "2 rollouts"]);
    refuses(&["train", "pendulum", "--imagined-rollouts", "0"], &["`inf`", "`0`"]);
    refuses(&["train", "pendulum", "--learning-rate", "NaN"], &["learning_rate", "NaN"]);
    refuses(&["train", "pendulum", "--discount", "1.5"], &["discount", "1.5"]);
    refuses(&["train", "pendulum", "--discount", "1"], &["discount", "below 1", "a horizon of a thousand steps"]);
    refuses(&["train", "pendulum", "--solver", "least-squares", "--ridge", "-1"], &["ridge", "-1"]);
    refuses(&["train", "pendulum", "--solver", "stlsq", "--threshold", "-1"], &["threshold", "-1"]);
    refuses(
        &["train", "pendulum", "--refit", "--imagined-rollouts", "inf"],
        &["--refit has no effect", "--imagined-rollouts"],
    );
    refuses(
        &["train", "pendulum", "--threshold", "0.1"],
        &["--threshold does not apply to the solver `best-subset`", "--solver stlsq"],
    );
    refuses(
        &["train", "pendulum", "--ridge", "0.1"],
        &["add `--solver stlsq` or `--solver least-squares`, or leave --ridge out"],
    );
    refuses(&["train", "pendulum", "--batch-size", "0"], &["--batch-size", "got 0"]);
    refuses(&["train", "pendulum", "--threads", "0"], &["--threads"]);
    refuses(
        &["train", "pendulum", "--set", "sac.hidden=[4096,4096]", "--batch-size", "65536"],
        &["a batch of 65536", "536870912 values", "--batch-size"],
    );
    for noise in ["-0.1", "1.5", "NaN"] {
        refuses(&["train", "pendulum", "--noise", noise], &["--noise", "between 0 and 1", noise, "hint:"]);
    }
    refuses(&["train", "pendulum", "--episodes", "0"], &["--episodes", "at least 1", "got 0"]);
    refuses(&["train", "pendulum", "--max-updates", "0"], &["--max-updates", "at least 1", "got 0"]);
}

#[test]
fn settings_no_machine_can_hold_are_refused_before_they_are_tried() {
    for (setting, words) in [
        ("imagination.systems=100000000", ["imagination.systems", "10000"]),
        ("sac.hidden=[100000,100000]", ["sac.hidden", "4096"]),
        ("sac.hidden=[8,8,8,8,8,8,8,8,8]", ["sac.hidden", "8"]),
        ("sac.hidden=[4096,4096,4096]", ["sac.hidden", "33554432 weights"]),
        ("evaluation_episodes=10000000000", ["evaluation_episodes", "10000"]),
        ("optimality.trial_episodes=10000000000", ["trial_episodes", "10000"]),
        ("imagination.replay_capacity=1000000000000", ["replay_capacity", "10000000"]),
        ("imagination.rollout_len=100000000000", ["rollout_len", "1000000"]),
        ("sac.batch_size=100000000000", ["--batch-size", "65536"]),
        ("optimality.tolerance=nan", ["optimality.tolerance", "NaN"]),
        ("optimality.tolerance=-0.5", ["optimality.tolerance", "-0.5"]),
        ("optimality.max_updates=0", ["--max-updates", "got 0"]),
    ] {
        refuses(&["train", "pendulum", "--set", setting], &words);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_told_without_options_there_are_not() {
    let temp = tempfile::tempdir().unwrap();
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = command(temp.path(), &["tasks"]).stdout(full).stderr(Stdio::piped()).output().unwrap();
    let (code, _, stderr) = parts(&output);
    assert_eq!(code, 2);
    assert!(stderr.contains("cannot write to stdout") && !stderr.contains("--out"), "{stderr}");
}

#[test]
fn bounds_are_shown_as_they_were_declared() {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, _) = parts(&sindyna(temp.path(), &["tasks", "mountain-car"]));
    assert_eq!(code, 0);
    assert!(stdout.contains("−1.2 to 0.6") && !stdout.contains("000000"), "{stdout}");
}

#[test]
fn files_that_are_not_what_they_should_be_are_named() {
    refuses(&["evaluate", "nowhere"], &["cannot read nowhere/config.toml", "hint: RUN is an output directory"]);
    refuses(&["train", "--config", "missing.toml"], &["cannot read missing.toml"]);

    let temp = tempfile::tempdir().unwrap();
    let args = ["train", "pendulum", "--max-updates", "250", "--out", "run", "--quiet"];
    assert_eq!(parts(&sindyna(temp.path(), &args)).0, 1);
    let run = temp.path().join("run");
    let policy = fs::read(run.join("policy.safetensors")).unwrap();
    for damaged in [&policy[..policy.len() / 2], &policy[..3], b"", b"not a policy at all"] {
        fs::write(run.join("policy.safetensors"), damaged).unwrap();
        let (code, _, stderr) = parts(&sindyna(temp.path(), &["evaluate", "run"]));
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains("policy.safetensors") && !stderr.contains("panicked"), "{stderr}");
    }
    fs::remove_file(run.join("policy.safetensors")).unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["evaluate", "run"]));
    assert!(code == 2 && stderr.contains("run holds no policy") && stderr.contains("hint:"), "{stderr}");
    let config = fs::read_to_string(run.join("config.toml")).unwrap();
    fs::write(run.join("config.toml"), config.replace("seed =", "sead =")).unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["train", "--config", "run/config.toml"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("sead"), "{stderr}");
}

#[test]
fn nothing_in_a_file_speaks_to_the_terminal() {
    let temp = tempfile::tempdir().unwrap();
    let log = |header: &str, cell: &str| {
        let rows: String =
            (0..40).map(|i| format!("{},{},1\n", 0.1 * f64::from(i), (-0.05 * f64::from(i)).exp())).collect();
        fs::write(temp.path().join("log.csv"), format!("t,{header},z\n{rows}{cell}")).unwrap();
    };
    let escape = "x\u{1b}]0;mine\u{7}";
    log(&format!("{escape} [m\u{1b}c]"), "");
    let args = ["identify", "log.csv", "--states", escape, "--out", "model"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert!(code == 0 && stdout.contains("x\\u{1b}]0;mine\\u{7}"), "{stdout}{stderr}");
    let (_, exported, _) = parts(&sindyna(temp.path(), &["export", "model", "--to", "python"]));
    log("x", &format!("4,\u{1b}[31m{},1\n", "9".repeat(3_000_000)));
    let (code, _, long) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--states", "x"]));
    assert!(code == 2 && long.contains("line 42") && long.len() < 3_000, "{} bytes", long.len());
    let (_, _, unknown) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--states", "\u{1b}[2J"]));
    for told in [stdout, stderr, exported, long, unknown] {
        assert!(!told.contains(['\u{1b}', '\u{7}']), "{told:?}");
    }
}

#[test]
fn an_existing_run_is_never_overwritten() {
    let temp = tempfile::tempdir().unwrap();
    fs::create_dir(temp.path().join("mine")).unwrap();
    fs::write(temp.path().join("mine/notes"), "mine").unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["train", "pendulum", "--out", "mine"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("mine exists already") && stderr.contains("hint:"), "{stderr}");
    assert_eq!(fs::read_dir(temp.path().join("mine")).unwrap().count(), 1);
}

#[test]
fn a_model_that_diverges_in_imagination_is_counted() {
    let temp = tempfile::tempdir().unwrap();
    // Fifteen steps against 41 polynomial features, and no ridge to hold them: the model blows up away from the data.
    let args = ["train", "inverted-pendulum", "--library", "paper", "--solver", "least-squares", "--ridge", "0"];
    let args = [&args[..], &["--target", "continuous", "--real-steps", "15", "--seed", "1"]].concat();
    let args =
        [&args[..], &["--imagined-rollouts", "inf", "--max-updates", "1000", "--out", "wild", "--quiet"]].concat();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert!(code == 0 || code == 1, "{stdout}{stderr}");
    let training = &json(&temp.path().join("wild/summary.json"))["training"];
    let ended_early = training["diverged"].as_u64().unwrap() + training["left_region"].as_u64().unwrap();
    assert!(ended_early > 0, "{training}");
}

#[test]
fn training_that_diverges_loses_nothing_that_was_learned_before() {
    let temp = tempfile::tempdir().unwrap();
    let args = ["train", "pendulum", "--learning-rate", "0.5", "--out", "run", "--quiet"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 2, "{stdout}{stderr}");
    assert!(stderr.contains("training diverged") && stderr.contains("--learning-rate"), "{stderr}");
    assert!(stdout.contains("15 sin θ + 3 u") && stdout.contains("training ended early"), "{stdout}");
    let run = temp.path().join("run");
    assert!(run.join("model.json").exists());
    assert!(json(&run.join("summary.json"))["training"]["failure"].as_str().unwrap().contains("diverged"));
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_reported_and_the_real_data_are_kept() {
    let temp = tempfile::tempdir().unwrap();
    // No file may grow beyond 8 KiB: the data and the equations fit, the policy does not.
    let script = format!(
        "ulimit -f 8; trap '' XFSZ; exec {} train pendulum --max-updates 1000 --out run --quiet",
        env!("CARGO_BIN_EXE_sindyna")
    );
    let output = std::process::Command::new("bash").current_dir(temp.path()).args(["-c", &script]).output().unwrap();
    let (code, stdout, stderr) = parts(&output);
    assert_eq!(code, 2, "{stdout}{stderr}");
    assert!(stderr.contains("cannot write") && stderr.contains("policy.safetensors"), "{stderr}");
    assert!(stdout.contains("identified"), "what was found is still told: {stdout}");
    let run = temp.path().join("run");
    for name in ["rollout.csv", "model.json", "events.jsonl", "timing.json"] {
        assert!(run.join(name).exists(), "{name} fits and is there");
    }
    for name in ["policy.safetensors", "summary.json"] {
        assert!(!run.join(name).exists(), "a run whose policy found no room is not whole: {name}");
    }
    // With them configuration, account and predictions; neither episode nor page.
    assert_eq!(fs::read_dir(&run).unwrap().count(), 7, "no half-written file");
    // With room for it, it is done again and then as any other.
    assert!(stderr.contains("sindyna train --resume run"), "{stderr}");
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["train", "--resume", "run", "--quiet"]));
    assert!(code < 2 && run.join("summary.json").exists(), "{stdout}{stderr}");
    assert!(parts(&sindyna(temp.path(), &["evaluate", "run"])).0 < 2);
}
