//! What stops a run, and what does not.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![cfg(target_os = "linux")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::json;
use rand::RngExt as _;
use sindyna_core::Seed;

/// A run in `directory` that would train for hours, once it trains; started by `through`, which says what is ignored, with `options`.
fn training(directory: &Path, through: &[&str], options: &[&str]) -> Child {
    let mut command = Command::new(through[0]);
    command.current_dir(directory).args(&through[1..]).arg(env!("CARGO_BIN_EXE_sindyna"));
    command.args(["train", "mountain-car", "--max-updates", "100000000", "--out", "run"]).args(options);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let stderr = BufReader::new(child.stderr.as_mut().unwrap());
    assert!(stderr.lines().any(|line| line.unwrap().starts_with("training:")), "the run never came to a trial");
    child
}

fn send(child: &Child, signal: &str) {
    let killed = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
}

/// However the tests were started, nothing is ignored.
const PLAIN: [&str; 2] = ["env", "--default-signal"];

#[test]
fn ctrl_c_leaves_a_valid_record() {
    for signal in ["INT", "TERM", "HUP"] {
        let temp = tempfile::tempdir().unwrap();
        let mut child = training(temp.path(), &PLAIN, &[]);
        send(&child, signal);
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
        let run = temp.path().join("run");
        let summary = json(&run.join("summary.json"));
        assert_eq!(summary["interrupted"], true);
        assert_eq!(summary["evaluation"], serde_json::Value::Null);
        assert_eq!(summary["real_steps"], 10);
        for name in ["model.json", "policy.safetensors", "timing.json"] {
            assert!(run.join(name).exists(), "{name} is missing");
        }
    }
}

#[test]
fn a_signal_that_was_to_be_ignored_is() {
    let temp = tempfile::tempdir().unwrap();
    let mut child = training(temp.path(), &["env", "--default-signal", "--ignore-signal=HUP"], &[]);
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    assert_eq!(u64::from_str_radix(ignored.trim(), 16).unwrap() & 1, 1, "hanging up is still ignored");
    send(&child, "HUP");
    send(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130), "the first that counts is not taken for the second");
    assert!(json(&temp.path().join("run/summary.json"))["interrupted"].as_bool().unwrap());
}

/// A mass that is pushed by `u`, and by what nobody recorded.
fn pushed() -> String {
    let mut rng = Seed::new(1).stream("u", 0);
    let (mut text, mut x, mut v, mut u) = ("t,x,v,u\n".to_owned(), 0.0, 0.0, 0.0);
    for row in 0..40 {
        if row % 5 == 0 {
            u = 2.0 * rng.random::<f64>() - 1.0;
        }
        writeln!(text, "{},{x},{v},{u}", 0.05 * f64::from(row)).unwrap();
        for step in 0..10 {
            let t = 0.05 * f64::from(row) + 0.005 * f64::from(step);
            v += 0.005 * (u + 3.0 * (2.3 * t * t).sin());
            x += 0.005 * v;
        }
    }
    text
}

#[test]
fn a_search_that_is_stopped_while_a_log_is_read_otherwise_tells_what_it_found_before() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), pushed()).unwrap();
    let mut command = Command::new(PLAIN[0]);
    command.current_dir(temp.path()).args(&PLAIN[1..]).arg(env!("CARGO_BIN_EXE_sindyna"));
    command.args(["identify", "log.csv", "--no-report", "--out", "found"]);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(said.any(|line| line.starts_with("no term explains")), "other readings were never tried");
    send(&child, "INT");
    assert!(said.any(|line| line == "interrupted: the equations found before are reported"));
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let found = fs::read_to_string(temp.path().join("found/identify.json")).unwrap();
    assert!(found.contains("the search was interrupted"), "{found}");
}

#[test]
fn a_turn_of_a_million_updates_is_stopped_within_it() {
    let temp = tempfile::tempdir().unwrap();
    let mut child = training(temp.path(), &PLAIN, &["--set", "imagination.updates_per_turn=1000000"]);
    send(&child, "INT");
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(20) {
        sleep(Duration::from_millis(20));
    }
    let ended = child.try_wait().unwrap();
    child.kill().unwrap();
    assert_eq!(ended.and_then(|status| status.code()), Some(130), "after 20 s");
}

#[test]
fn looking_for_equations_is_ended_within_a_second() {
    let temp = tempfile::tempdir().unwrap();
    // Walks at random: no equations, and long looking for them.
    let mut rng = Seed::new(0).stream("walks", 0);
    let mut walks = [0.0; 5];
    let mut log = String::from("t,a,b,c,d,e\n");
    for row in 0..4000 {
        walks.iter_mut().for_each(|walk| *walk += rng.random::<f64>() - 0.5);
        let values: Vec<String> = walks.iter().map(f64::to_string).collect();
        writeln!(log, "{},{}", f64::from(row) * 0.01, values.join(",")).unwrap();
    }
    fs::write(temp.path().join("log.csv"), log).unwrap();
    let mut command = Command::new(PLAIN[0]);
    command.current_dir(temp.path()).args(&PLAIN[1..]).arg(env!("CARGO_BIN_EXE_sindyna"));
    command.args(["identify", "log.csv", "--states", "a,b,c,d,e", "--out", "model"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let stderr = BufReader::new(child.stderr.as_mut().unwrap());
    assert!(stderr.lines().any(|line| line.unwrap().starts_with("read: 4000 rows")));
    sleep(Duration::from_millis(500));
    let asked = Instant::now();
    send(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(asked.elapsed() < Duration::from_secs(10), "{:?}", asked.elapsed());
    assert!(!temp.path().join("model").exists(), "nothing is left half-written");
}

#[test]
fn a_planner_that_is_stopped_is_not_compared_with_the_data() {
    let temp = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/spring");
    fs::copy(example.join("spring.csv"), temp.path().join("spring.csv")).unwrap();
    let task = fs::read_to_string(example.join("spring.toml")).unwrap();
    fs::write(temp.path().join("task.toml"), task.replace("max_steps = 100", "max_steps = 400")).unwrap();
    let mut command = Command::new(PLAIN[0]);
    command.current_dir(temp.path()).args(&PLAIN[1..]).arg(env!("CARGO_BIN_EXE_sindyna")).arg("train");
    command.args(["--task-file", "task.toml", "--data", "spring.csv", "--controller", "mppi", "--verbose"]);
    let mut child = command.args(["--out", "run"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(said.any(|line| line.starts_with("comparing what the policy does")), "it was never compared");
    send(&child, "INT");
    let answer = child.wait_with_output().unwrap();
    assert_eq!(answer.status.code(), Some(130));
    let text = String::from_utf8(answer.stdout).unwrap();
    assert!(text.contains("comparison with the data; `sindyna train --resume run` continues"), "{text}");
    let summary = json(&temp.path().join("run/summary.json"));
    assert_eq!((&summary["interrupted"], &summary["from_log"]), (&true.into(), &true.into()));
    assert!(summary["training"]["coverage"].is_null() && !summary["training"]["prediction"].is_null(), "{summary}");
}
