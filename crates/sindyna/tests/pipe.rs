//! Programs as systems. They are shell scripts and the examples, which need python3 and a C compiler.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::{json, parts, sindyna};

fn examples() -> PathBuf {
    std::path::absolute(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/pipe")).unwrap()
}

/// Arguments of `train` on the example's task with `pipe` as the program and no more than a few updates, then `args`.
fn short<'a>(task: &'a str, pipe: &'a str, args: &[&'a str]) -> Vec<&'a str> {
    let train = ["train", "--task-file", task, "--pipe", pipe, "--out", "run", "--quiet"];
    [&train[..], &["--max-updates", "250", "--episodes", "2"], args].concat()
}

#[test]
fn programs_in_two_languages_are_the_same_system() {
    let temp = tempfile::tempdir().unwrap();
    let task = examples().join("pendulum.toml");
    let task = task.to_str().unwrap();
    let in_python = format!("python3 '{}'", examples().join("pendulum.py").display());
    let args = ["train", "--task-file", task, "--pipe", &in_python, "--out", "run", "--quiet"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("ω̇ = −0.1 ω + 9.81 sin θ + u") && stdout.contains(": solved (≥ −60)"), "{stdout}");

    // No record names the program: one from elsewhere must not start anything.
    let record = |name: &str| fs::read_to_string(temp.path().join("run").join(name)).unwrap();
    assert!(record("config.toml").contains("simulator = \"pipe\"") && !record("config.toml").contains("python3"));
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["evaluate", "run"]));
    assert!(code == 2 && stderr.contains("name it again with --pipe COMMAND"), "{stderr}");
    let recorded = json(&temp.path().join("run/summary.json"))["evaluation"]["returns"].clone();

    let (source, program) = (examples().join("pendulum.c"), temp.path().join("pendulum"));
    let built = Command::new("cc").arg("-O2").arg(source).arg("-o").arg(&program).arg("-lm").status();
    assert!(built.is_ok_and(|status| status.success()), "there is no C compiler");
    let in_c = program.to_str().unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["evaluate", "run", "--returns", "--pipe", in_c]));
    assert_eq!(code, 0, "{stderr}");
    let returns: Vec<f64> = stdout.lines().filter_map(|line| line.parse().ok()).collect();
    let recorded: Vec<f64> = recorded.as_array().unwrap().iter().map(|r| r.as_f64().unwrap()).collect();
    assert_eq!(returns.len(), recorded.len());
    for (here, there) in returns.iter().zip(&recorded) {
        assert!((here - there).abs() < 1e-6 * there.abs().max(1.0), "{here} is not {there}");
    }
}

/// A program for a system of one state `x` and one control `u`, whose answers are given by lines of shell.
fn script(directory: &Path, spec: &str, reset: &str, step: &str) -> String {
    let text = format!(
        "while read -r line; do\n  case $line in\n    *'\"spec\"'*) {spec};;\n    *'\"reset\"'*) {reset};;\n    *'\"step\"'*) {step};;\n    *'\"close\"'*) echo closed >closed; exit 0;;\n  esac\ndone\n"
    );
    fs::write(directory.join("program.sh"), text).unwrap();
    let task = r#"
        name = "point"
        dt = 0.1
        max_steps = 20
        [[state]]
        name = "x"
        start = [-1.0, 1.0]
        [[control]]
        name = "u"
        low = -1.0
        high = 1.0
        [task]
        reward = "-x^2"
    "#;
    fs::write(directory.join("task.toml"), task).unwrap();
    "sh program.sh".into()
}

const SPEC: &str = r#"echo '{"states": ["x"], "controls": ["u"], "dt": 0.1}'"#;
const AT_ZERO: &str = r#"echo '{"state": [0.0]}'"#;

#[test]
fn what_is_no_answer_is_told() {
    let other_dt = SPEC.replace("0.1", "0.2");
    let silent = "sleep 30";
    for (spec, reset, step, says) in [
        ("echo hello", AT_ZERO, AT_ZERO, "it answered `spec` by `hello`"),
        (&other_dt, AT_ZERO, AT_ZERO, "its control interval is 0.2 s, that of the task file is 0.1 s"),
        (silent, AT_ZERO, AT_ZERO, "it did not answer `spec` within 1 s"),
        ("exit 3", AT_ZERO, AT_ZERO, "it ended (exit status: 3) before it answered `spec`"),
        (SPEC, r#"echo '{"error": "no rail"}'"#, AT_ZERO, "it rejects `reset`: no rail"),
        (SPEC, AT_ZERO, r#"echo '{"state": [0.0, 1.0]}'"#, "it gives 2 states where 1 are declared"),
        (SPEC, AT_ZERO, r#"echo '{"state": [NaN]}'"#, "it answered `step` by `{\"state\": [NaN]}`"),
        (SPEC, AT_ZERO, r#"echo '{"state": [1e999]}'"#, "it answered `step` by"),
        (SPEC, AT_ZERO, "echo a; echo b; sleep 1", "it answered `step` by `a`"),
        (SPEC, r#"echo '{"state": [0.0]}'; echo ready"#, AT_ZERO, "`ready`"), // unasked, or for the answer to `step`
        (SPEC, AT_ZERO, "kill -9 $$", "it ended (signal: 9 (SIGKILL)) before it answered `step`"),
        (SPEC, AT_ZERO, "exec >&-; sleep 1", "it closed its output before it answered `step`"),
        (SPEC, AT_ZERO, "head -c 2000000 /dev/zero; sleep 1", "it sent a line of more than 1048576 bytes"),
        (SPEC, AT_ZERO, silent, "it did not answer `step` within 1 s"),
    ] {
        let temp = tempfile::tempdir().unwrap();
        let pipe = script(temp.path(), spec, reset, step);
        let begun = Instant::now();
        let (code, _, stderr) =
            parts(&sindyna(temp.path(), &short("task.toml", &pipe, &["--pipe-timeout", "1", "--seed", "1"])));
        assert!(code == 2 && stderr.contains(says), "{says}: {code}, {stderr}");
        assert!(begun.elapsed() < Duration::from_secs(20), "{says}: {:?}", begun.elapsed());
    }
}

#[test]
fn a_command_that_cannot_be_is_refused() {
    let temp = tempfile::tempdir().unwrap();
    script(temp.path(), SPEC, AT_ZERO, AT_ZERO);
    for (pipe, args, says) in [
        ("no-such-program", &[][..], "it cannot be started"),
        ("", &[], "--pipe names no program"),
        ("sh 'program.sh", &[], "missing closing quote"),
        ("sh program.sh", &["--pipe-timeout", "0"], "--pipe-timeout must be above 0 s, got 0"),
        ("sh program.sh", &["--data", "log.csv"], "--pipe excludes --data and --model"),
    ] {
        let (code, _, stderr) = parts(&sindyna(temp.path(), &short("task.toml", pipe, args)));
        assert!(code == 2 && stderr.contains(says), "{says}: {code}, {stderr}");
    }
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["train", "pendulum", "--pipe", "sh program.sh"]));
    assert!(code == 2 && stderr.contains("--pipe needs a --task-file"), "{stderr}");
    let spring = examples().join("../spring/ground_truth.toml");
    let (code, _, stderr) = parts(&sindyna(temp.path(), &short(spring.to_str().unwrap(), "sh program.sh", &[])));
    assert!(code == 2 && stderr.contains("it has a simulator of its own"), "{stderr}");
    assert!(!temp.path().join("run").exists(), "refused before the first file");
}

/// x' = x + 0.1 u, computed by `awk`, for so many steps.
fn integrator(directory: &Path, steps: usize) -> String {
    let value = r#"sed 's/.*\[//; s/\].*//'"#;
    let reset = format!(r#"x=$(echo "$line" | {value}); echo "{{\"state\": [$x]}}""#);
    let step = format!(
        r#"n=$((n + 1)); [ $n -gt {steps} ] && exit 4; u=$(echo "$line" | {value}); x=$(awk "BEGIN {{printf \"%.17g\", $x + 0.1 * $u}}"); echo "{{\"state\": [$x]}}""#
    );
    script(directory, SPEC, &reset, &step)
}

#[test]
fn a_system_that_fails_in_the_evaluation_takes_no_policy_with_it() {
    let temp = tempfile::tempdir().unwrap();
    let pipe = integrator(temp.path(), 25);
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &short("task.toml", &pipe, &[])));
    assert!(code == 2 && stderr.contains("it ended (exit status: 4) before it answered `step`"), "{stderr}");
    assert!(stderr.contains("hint: `sindyna evaluate run` evaluates the policy again"), "{stderr}");
    assert!(stdout.contains(" = u\n") && stdout.contains("the policy was not evaluated"), "{stdout}");
    let pipe = integrator(temp.path(), 1_000);
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["evaluate", "run", "--pipe", &pipe]));
    assert!(code == 0 && stdout.contains("over 2 episodes"), "{stdout}{stderr}");
}

#[test]
fn steps_made_before_a_system_fails_are_kept() {
    let temp = tempfile::tempdir().unwrap();
    let pipe = integrator(temp.path(), 6);
    let (code, _, stderr) = parts(&sindyna(temp.path(), &short("task.toml", &pipe, &[])));
    assert!(code == 2 && stderr.contains("it ended (exit status: 4)"), "{stderr}");
    let kept = fs::read_to_string(temp.path().join("run/rollout.csv")).unwrap();
    assert_eq!(kept.lines().count(), 1 + 7, "a header, the start and six steps: {kept}");
}

/// However the tests were started, Ctrl-C is not ignored.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_ends_the_waiting_and_the_program_comes_to_rest() {
    let temp = tempfile::tempdir().unwrap();
    let pipe = script(temp.path(), SPEC, AT_ZERO, "echo stepped >stepped; read -r line; echo closed >closed; exit 0");
    let mut command = Command::new("env");
    command.arg("--default-signal").arg(env!("CARGO_BIN_EXE_sindyna")).args(short("task.toml", &pipe, &[]));
    let mut child = command.current_dir(temp.path()).stderr(Stdio::null()).spawn().unwrap();
    while !temp.path().join("stepped").exists() {
        assert!(child.try_wait().unwrap().is_none(), "it has ended before the first step");
        sleep(Duration::from_millis(10));
    }
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(asked.elapsed() < Duration::from_secs(5), "{:?}", asked.elapsed());
    assert!(temp.path().join("closed").exists(), "it was told to close");
    assert!(json(&temp.path().join("run/summary.json"))["interrupted"].as_bool().unwrap());
}
