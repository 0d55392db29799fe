//! Logs of systems whose actuators follow their inputs slowly: the lag is found with the equations.

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

/// How an input acts.
struct Actuator {
    /// Time constant \[s\], 0 for none, and rows of a delay before it.
    tau: f64,
    rows: f64,
    /// Rows over which inputs are held.
    held: usize,
    /// What it delivers at first.
    first: f64,
}

/// Rows `t,q,v,u` of q' = v, v' = `rate`(q, v, a), a' = (u − a)/τ every 0.05 s under steps of u; noise of so much is added to q and v.
fn log(rate: impl Fn(f64, f64, f64) -> f64, actuator: &Actuator, count: usize, noise: f64) -> String {
    const PARTS: usize = 50;
    let Actuator { tau, rows, held, first } = *actuator;
    let (mut x, mut text) = ([0.3, 0.0, first], "t,q,v,u\n".to_owned());
    let at = |row: usize| ((row / held * 7919 + 3) % 23) as f64 / 11.0 - 1.0;
    for i in 0..count {
        let (q, v) = (x[0] + noise * shaken(2 * i), x[1] + noise * shaken(2 * i + 1));
        writeln!(text, "{},{q},{v},{}", 0.05 * i as f64, at(i)).unwrap();
        let h = 0.05 / PARTS as f64;
        let ahead = |by: f64, k: [f64; 3], x: [f64; 3]| std::array::from_fn(|i| x[i] + by * h * k[i]);
        for part in 0..PARTS {
            let row = i as f64 + part as f64 / PARTS as f64 - rows;
            let u = at((row + 1e-9).max(0.0) as usize);
            let f = |x: [f64; 3]| {
                let (a, follows) = if tau > 0.0 { (x[2], (u - x[2]) / tau) } else { (u, 0.0) };
                [x[1], rate(x[0], x[1], a), follows]
            };
            let k1 = f(x);
            let k2 = f(ahead(0.5, k1, x));
            let k3 = f(ahead(0.5, k2, x));
            let k4 = f(ahead(1.0, k3, x));
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
    }
    text
}

/// Rows `t,q,v,u` of the same without an actuator, whose input is a sum of sines, linear between rows that are read so many rows late.
fn log_of_waves(rate: impl Fn(f64, f64, f64) -> f64, rows: f64, count: usize, noise: f64) -> String {
    const PARTS: usize = 50;
    let wave = |row: f64| (0.31 * row).sin() + 0.7 * (0.83 * row + 1.0).sin() + 0.4 * (1.21 * row + 2.0).sin();
    let u = |t: f64| {
        let at = (t - rows).max(0.0);
        let share = at - at.floor();
        (1.0 - share) * wave(at.floor()) + share * wave(at.floor() + 1.0)
    };
    let (mut x, mut text) = ([0.3, 0.0], "t,q,v,u\n".to_owned());
    let h = 0.05 / PARTS as f64;
    for i in 0..count {
        let (q, v) = (x[0] + noise * shaken(2 * i), x[1] + noise * shaken(2 * i + 1));
        writeln!(text, "{},{q},{v},{}", 0.05 * i as f64, wave(i as f64)).unwrap();
        for part in 0..PARTS {
            let begin = i as f64 + part as f64 / PARTS as f64;
            let f = |x: [f64; 2], by: f64| [x[1], rate(x[0], x[1], u(begin + by / PARTS as f64))];
            let ahead = |by: f64, k: [f64; 2], x: [f64; 2]| std::array::from_fn(|i| x[i] + by * h * k[i]);
            let k1 = f(x, 0.0);
            let k2 = f(ahead(0.5, k1, x), 0.5);
            let k3 = f(ahead(0.5, k2, x), 0.5);
            let k4 = f(ahead(1.0, k3, x), 1.0);
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
    }
    text
}

fn spring(q: f64, v: f64, a: f64) -> f64 {
    -6.0 * q - 0.8 * v + 2.0 * a
}

fn pendulum(q: f64, v: f64, a: f64) -> f64 {
    -7.0 * q.sin() - 0.4 * v + 3.0 * a
}

/// Expects the terms of `truth` in an equation of `identify.json` and no others, off by no more than `most` of (standard error).
fn has_terms(equation: &serde_json::Value, truth: &[(&str, f64)], most: impl Fn(f64) -> f64) {
    let terms = equation["terms"].as_array().unwrap();
    assert_eq!(terms.len(), truth.len(), "{equation}");
    for &(term, truth) in truth {
        let found = terms.iter().find(|t| t["term"] == term).unwrap_or_else(|| panic!("{term}: {equation}"));
        let error = found["standard_error"].as_f64().unwrap_or(0.0);
        assert!((found["coefficient"].as_f64().unwrap() - truth).abs() < most(error), "{term}: {equation}");
    }
}

/// What `identify` finds in `text`, as (whether it says that it is adequate or ambiguous, `identify.json`, what it printed).
fn identified(at: &Path, name: &str, text: String, more: &[&str]) -> (bool, serde_json::Value, String) {
    let file = format!("{name}.csv");
    fs::write(at.join(&file), text).unwrap();
    let args = [&["identify", &file, "--strict", "--no-report", "--out", name], more].concat();
    let (code, stdout, stderr) = parts(&sindyna(at, &args));
    let stands = code == 0 || stdout.contains("equations: ambiguous");
    (stands, json(&at.join(name).join("identify.json")), format!("{stdout}{stderr}"))
}

#[test]
fn the_time_constant_is_found_with_the_equations() {
    let temp = tempfile::tempdir().unwrap();
    let rest = |tau: f64| Actuator { tau, rows: 0.0, held: 7, first: 0.0 };
    let of_spring = [("q", -6.0), ("v", -0.8), ("u", 2.0)];
    let of_pendulum = [("sin q", -7.0), ("v", -0.4), ("u", 3.0)];
    for (name, text, truth, tau, within) in [
        ("exact", log(spring, &rest(0.13), 400, 0.0), &of_spring, 0.13, 1e-7),
        ("noisy", log(spring, &rest(0.13), 400, 0.003), &of_spring, 0.13, 0.01),
        ("turning", log(pendulum, &rest(0.3), 500, 0.003), &of_pendulum, 0.3, 0.01),
    ] {
        let (stands, account, told) = identified(temp.path(), name, text, &[]);
        assert!(stands, "{told}");
        let found = account["input_lag"].as_f64().unwrap_or_else(|| panic!("{name}: {told}"));
        assert!((found - tau).abs() < within * tau, "{name}: {told}");
        assert!(told.contains("lag of the inputs: first order") && told.contains("--lag 0 turns this off"), "{told}");
        has_terms(&account["equations"][1], truth, |error| 4.0 * error + 1e-6);
    }
}

/// Weather, or what another machine does, changes smoothly between samples: straight lines miss its means by h² u″/12.
#[test]
fn smooth_inputs_are_no_straight_lines() {
    let temp = tempfile::tempdir().unwrap();
    let (dt, u) = (0.3, |t: f64| (0.9 * t).sin() + 0.5 * (0.37 * t + 1.0).cos());
    let mut text = "t,x,u\n".to_owned();
    let mut x = 0.4;
    for i in 0..600 {
        let t = dt * f64::from(i);
        writeln!(text, "{t},{},{}", x + 0.002 * shaken(i as usize), u(t)).unwrap();
        let h = dt / 300.0;
        for part in 0..300 {
            let now = u(t + h * (f64::from(part) + 0.5));
            let middle = x + 0.5 * h * (1.3 * now - 0.4 * x);
            x += h * (1.3 * now - 0.4 * middle);
        }
    }
    let (stands, account, told) = identified(temp.path(), "weather", text, &["--states", "x", "--inputs", "u"]);
    assert!(stands && told.contains("inputs are smooth between samples"), "{told}");
    assert_eq!(account["intersample"], "bl", "{told}");
    has_terms(&account["equations"][0], &[("x", -0.4), ("u", 1.3)], |error| 4.0 * error);
}

/// What was delivered before the log is not zero, nor what the first row says; a delay comes before the lag.
#[test]
fn a_log_may_begin_anywhere_and_inputs_be_delayed_too() {
    let temp = tempfile::tempdir().unwrap();
    let truth = [("q", -6.0), ("v", -0.8), ("u", 2.0)];
    for (name, actuator, noise) in [
        ("begun", Actuator { tau: 0.2, rows: 0.0, held: 7, first: 0.9 }, 0.0),
        ("late", Actuator { tau: 0.16, rows: 2.0, held: 7, first: 0.0 }, 0.003),
    ] {
        let (stands, account, told) = identified(temp.path(), name, log(spring, &actuator, 500, noise), &[]);
        assert!(stands, "{told}");
        let found = account["input_lag"].as_f64().unwrap_or_else(|| panic!("{name}: {told}"));
        assert!((found - actuator.tau).abs() < 0.02 * actuator.tau, "{name}: {told}");
        assert_eq!(account["input_delay"].as_f64().unwrap_or(0.0), actuator.rows, "{told}");
        has_terms(&account["equations"][1], &truth, |error| 4.0 * error + 1e-6);
    }
}

#[test]
fn a_lag_is_declared_for_other_logs_and_told_in_exports() {
    let temp = tempfile::tempdir().unwrap();
    let rest = Actuator { tau: 0.13, rows: 0.0, held: 7, first: 0.0 };
    let text = |count: usize| log(spring, &rest, count, 0.003);
    fs::write(temp.path().join("other.csv"), log(spring, &Actuator { first: 0.5, ..rest }, 300, 0.003)).unwrap();
    let more = ["--lag", "0.13", "--holdout", "other.csv"];
    let (stands, account, told) = identified(temp.path(), "given", text(400), &more);
    assert!(stands && account["input_lag"] == 0.13, "{told}");
    // The rows in which another start is forgotten are not predicted.
    let predictions = account["held_out"]["predictions"].as_array().unwrap();
    for fit in predictions.iter().flat_map(|of| of["fit_percent"].as_array().unwrap()) {
        assert!(fit[1].as_f64().unwrap() > 97.0, "{fit}{told}");
    }
    let args = ["export", "given", "--to", "python", "--out", "model.py"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stdout}{stderr}");
    let program = fs::read_to_string(temp.path().join("model.py")).unwrap();
    assert!(program.contains("Lag of the inputs: first order, time constant 0.13 s"), "{program}");
    let (off, account, told) = identified(temp.path(), "off", text(400), &["--lag", "0"]);
    assert!(account["input_lag"].is_null() && !told.contains("lag of the inputs: first"), "{off} {told}");
    for other in [["--intersample", "foh"], ["--delay", "0.5"]] {
        let args = [&["identify", "given.csv", "--lag", "0.13"][..], &other].concat();
        let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
        assert!(code != 0 && stderr.contains("a lag requires inputs that are held"), "{stderr}");
    }
    for lag in ["slow", "-1", "nan", "inf"] {
        let (code, _, stderr) = parts(&sindyna(temp.path(), &["identify", "given.csv", "--lag", lag]));
        assert!(code == 2 && stderr.contains("a lag is"), "{stderr}");
    }
}

/// Where inputs are held for long a delay shows after their switches alone: those steps are no outliers.
#[test]
fn delays_are_not_taken_for_outliers() {
    let temp = tempfile::tempdir().unwrap();
    let of_spring = [("q", -6.0), ("v", -0.8), ("u", 2.0)];
    let of_pendulum = [("sin q", -7.0), ("v", -0.4), ("u", 3.0)];
    let late = |rows: f64| Actuator { tau: 0.0, rows, held: 31, first: 0.0 };
    for (name, text, truth, rows) in [
        ("part", log(spring, &late(0.4), 600, 0.0), &of_spring, 0.4),
        ("whole", log(pendulum, &late(3.0), 600, 0.0), &of_pendulum, 3.0),
        ("noisy", log(pendulum, &late(1.6), 600, 1e-5), &of_pendulum, 1.6),
    ] {
        let (stands, account, told) = identified(temp.path(), name, text, &[]);
        assert!(stands, "{name}: {told}");
        let found = account["input_delay"].as_f64().unwrap_or_else(|| panic!("{name}: {told}"));
        assert!((found - rows).abs() < 1e-3, "{name}: {told}");
        has_terms(&account["equations"][1], truth, |error| 4.0 * error + 1e-6);
    }
}

/// A first-order system from rest behind an actuator is the same with the time constants exchanged: what is known is told, and no more.
#[test]
fn time_constants_that_may_be_exchanged_are_ambiguous() {
    let temp = tempfile::tempdir().unwrap();
    let (plant, tau): (f64, f64) = (0.5, 0.2);
    let (mut x, mut text) = ([0.0, 0.0], "t,T,u\n".to_owned());
    for i in 0..500 {
        let u = ((i / 7 * 7919 + 3) % 23) as f64 / 11.0 - 1.0;
        writeln!(text, "{:.2},{},{u}", 0.05 * i as f64, x[0] + 1e-3 * shaken(i)).unwrap();
        for _ in 0..500 {
            x = [x[0] + 1e-4 * (1.5 * x[1] - x[0]) / plant, x[1] + 1e-4 * (u - x[1]) / tau];
        }
    }
    let (stands, account, told) = identified(temp.path(), "exchanged", text, &["--states", "T", "--inputs", "u"]);
    let found = account["input_lag"].as_f64().unwrap_or_else(|| panic!("{told}"));
    assert!(stands && told.contains("equations: ambiguous ("), "{told}");
    let warning = told.lines().find(|line| line.contains("may be exchanged")).unwrap_or_else(|| panic!("{told}"));
    let other: f64 = warning.split(" of ").nth(2).unwrap().split(' ').next().unwrap().parse().unwrap();
    let (short, long) = (found.min(other), found.max(other));
    assert!((short - tau).abs() < 0.02 * tau && (long - plant).abs() < 0.02 * plant, "{found} {warning}");
    let error = account["input_lag_error"].as_f64().unwrap();
    assert!(error > 1e-5 && (found - tau).abs().min((found - plant).abs()) < 4.0 * error, "{found} {error}");
}

/// Where delays are not looked for the steps that they move are told.
#[test]
fn outliers_where_inputs_change_are_told() {
    let temp = tempfile::tempdir().unwrap();
    let late = Actuator { tau: 0.0, rows: 0.5, held: 31, first: 0.0 };
    let off = ["--delay", "0", "--lag", "0", "--intersample", "zoh"];
    let (_, account, told) = identified(temp.path(), "late", log(spring, &late, 600, 0.0), &off);
    assert!(
        account["rows_astray"].as_u64().unwrap() > 5 && told.contains("are those where an input changes"),
        "{told}"
    );
}

#[test]
fn inputs_that_are_linear_between_rows_may_be_late_too() {
    let temp = tempfile::tempdir().unwrap();
    let springs = [("q", -6.0), ("v", -0.8), ("u", 2.0)];
    let pendulums = [("sin q", -7.0), ("v", -0.4), ("u", 3.0)];
    for (rows, noise, is_spring) in [(1.0, 0.0, true), (2.0, 1e-4, true), (2.0, 1e-3, false)] {
        let text =
            if is_spring { log_of_waves(spring, rows, 500, noise) } else { log_of_waves(pendulum, rows, 500, noise) };
        let name = format!("late-{rows}-{noise}");
        let (stands, found, said) =
            identified(temp.path(), &name, text, &["--angles", "q"][..if is_spring { 0 } else { 2 }]);
        assert!(stands, "{said}");
        let truth = if is_spring { &springs } else { &pendulums };
        has_terms(&found["equations"][1], truth, |error| 4.5 * error + 1e-6);
        assert!(
            said.contains("first-order hold") && said.contains(&format!("delay of the inputs: {rows} row")),
            "{said}"
        );
    }
}
