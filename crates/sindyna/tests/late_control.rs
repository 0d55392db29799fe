//! Controllers for systems whose inputs act late, trained in equations of a log and judged on those of another.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::{json, parts, sindyna};

/// Numbers between −1 and 1 that look like chance.
fn shaken(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.547;
    2.0 * (x - x.floor()) - 1.0
}

/// Rows `t,x,v,F` of x″ = −10 x − 0.4 x′ + 2 a every 0.05 s, where a follows F so many `rows` late and with the time constant `tau` \[s\]; `first` is the first of its random numbers.
fn log((rows, tau): (f64, f64), first: usize) -> String {
    const PARTS: usize = 40;
    let at = |row: f64| if row < 0.0 { 0.0 } else { shaken(first + (row + 1e-9) as usize / 5) };
    let (mut x, mut text) = ([0.4, 0.0, 0.0], "t,x,v,F\n".to_owned());
    for i in 0..600 {
        let (q, v) = (x[0] + 5e-4 * shaken(first + 1000 + 2 * i), x[1] + 5e-4 * shaken(first + 1001 + 2 * i));
        writeln!(text, "{:.2},{q},{v},{}", 0.05 * i as f64, at(i as f64)).unwrap();
        for part in 0..PARTS {
            let (u, h) = (at(i as f64 + part as f64 / PARTS as f64 - rows), 0.05 / PARTS as f64);
            let f = |x: [f64; 3]| {
                let (a, follows) = if tau > 0.0 { (x[2], (u - x[2]) / tau) } else { (u, 0.0) };
                [x[1], -10.0 * x[0] - 0.4 * x[1] + 2.0 * a, follows]
            };
            let ahead = |by: f64, k: [f64; 3]| std::array::from_fn(|i| x[i] + by * h * k[i]);
            let k1 = f(x);
            let k2 = f(ahead(0.5, k1));
            let k3 = f(ahead(0.5, k2));
            let k4 = f(ahead(1.0, k3));
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
    }
    text
}

/// A directory with the task of the example.
fn workplace() -> tempfile::TempDir {
    let temp = tempfile::tempdir().unwrap();
    let task = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/spring/spring.toml");
    fs::copy(task, temp.path().join("task.toml")).unwrap();
    temp
}

/// What is printed by `sindyna` with `args`.
fn told(at: &Path, args: &[&str]) -> String {
    let (code, stdout, stderr) = parts(&sindyna(at, args));
    assert_eq!(code, 0, "{args:?}: {stdout}{stderr}");
    stdout
}

/// Leaves in `at` what is identified in the log called `name`.
fn identified(at: &Path, name: &str, text: String) {
    let file = format!("{name}.csv");
    fs::write(at.join(&file), text).unwrap();
    told(at, &["identify", &file, "--states", "x,v", "--inputs", "F", "--no-report", "--out", name]);
}

/// What is printed when a controller is trained in what was identified in the log called `of`.
fn trained(at: &Path, of: &str, run: &str, controller: &str) -> String {
    let args = ["train", "--task-file", "task.toml", "--model", of, "--controller", controller, "--no-report"];
    told(at, &[&args[..], &["--out", run]].concat())
}

/// Mean return of the `run` on the equations of the log called `twin`.
fn mean_return(at: &Path, run: &str, twin: &str) -> f64 {
    let text = told(at, &["evaluate", run, "--model", twin, "--episodes", "20", "--json"]);
    let document: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    document["result"]["evaluation"]["mean_return"].as_f64().unwrap_or_else(|| panic!("{text}"))
}

#[test]
fn a_policy_acts_on_the_state_in_which_its_action_will_act() {
    let temp = workplace();
    let at = temp.path();
    for (name, rows, first) in [
        ("now", 0.0, 0),
        ("late", 6.0, 5000),
        ("twin", 6.0, 9000),
        ("part", 2.6, 13_000),
        ("twin of part", 2.6, 17_000),
    ] {
        identified(at, name, log((rows, 0.0), first));
    }
    let trained = |of: &str, run: &str, controller: &str| trained(at, of, run, controller);
    trained("now", "unaware", "lqr");
    let best = mean_return(at, "unaware", "now");
    // Without a prediction the delay costs nearly as much as all else.
    assert!(mean_return(at, "unaware", "twin") < 1.8 * best, "{best}");
    for (of, twin, controller) in
        [("late", "twin", "lqr"), ("late", "twin", "ilqr"), ("part", "twin of part", "lqr"), ("late", "twin", "sac")]
    {
        let run = format!("{of} {controller}");
        let text = trained(of, &run, controller);
        assert!(text.contains("the policy acts on the state predicted for that time"), "{text}");
        let delay = json(&at.join(&run).join("summary.json"))["input_delay_seconds"].as_f64().unwrap();
        assert!((delay - if of == "late" { 0.3 } else { 0.13 }).abs() < 1e-3, "{delay}");
        // Of the delay itself nothing can be had back.
        let earned = mean_return(at, &run, twin);
        let most = if controller == "sac" { 1.6 } else { 1.4 };
        assert!(earned > most * best, "{run}: {earned} of {best}");
        // What is told of it after training is what it earns on the equations of another log.
        let told = json(&at.join(&run).join("summary.json"))["training"]["late"]["mean_return"].as_f64().unwrap();
        assert!((told / earned - 1.0).abs() < 0.3, "{run}: {told}, {earned}");
        assert!(text.contains("return in the model, with inputs that act so late: "), "{text}");
    }
    let program = told(at, &["export", "late sac", "--to", "c", "--out", "-"]);
    assert!(program.contains("Inputs act 0.3 s late"), "{program}");
}

#[test]
fn a_policy_knows_what_its_actuators_deliver() {
    let temp = workplace();
    let at = temp.path();
    for (name, late, first) in [
        ("now", (0.0, 0.0), 0),
        ("slow", (0.0, 0.3), 21_000),
        ("twin", (0.0, 0.3), 25_000),
        ("slow and late", (2.0, 0.2), 29_000),
        ("other twin", (2.0, 0.2), 33_000),
    ] {
        identified(at, name, log(late, first));
    }
    trained(at, "now", "unaware", "ilqr");
    let best = mean_return(at, "unaware", "now");
    for (of, twin, tau) in [("slow", "twin", 0.3), ("slow and late", "other twin", 0.2)] {
        let run = format!("{of} run");
        let text = trained(at, of, &run, "ilqr");
        // Of what the lag takes away some is had back.
        let (unaware, aware) = (mean_return(at, "unaware", twin), mean_return(at, &run, twin));
        assert!(unaware < 1.6 * best && aware > 0.8 * unaware, "{best}: {unaware}, {aware}");
        assert!(text.contains("dF_delivered/dt"), "{text}");
        let lag = json(&at.join(&run).join("summary.json"))["input_lag"].as_f64().unwrap();
        assert!((lag - tau).abs() < 1e-3, "{lag}");
    }
}
