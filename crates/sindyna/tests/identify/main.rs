//! Equations from logs, and as programs, as the user sees it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod changed;
#[path = "../common/mod.rs"]
mod common;
mod derivatives;
mod machines;
mod ordinary;
mod other_logs;
mod reading;
mod rounded;
mod undefined;

use std::fmt::Write as _;
use std::fs;

use common::{COLUMNS, example, identify, json, parts, python, sindyna};
use rand::RngExt as _;
use sindyna_core::{Dynamics as _, Seed};
use sindyna_sindy::Model;

/// Rows `t,th,w,u` of a pendulum that swings about its lower rest, begun at the angle `start`.
fn rows(start: f64, count: usize, time: impl Fn(usize) -> f64) -> String {
    let (mut th, mut w) = (start, 0.0_f64);
    let mut text = String::new();
    for i in 0..count {
        let u = (0.7 * i as f64).sin() + (0.31 * i as f64).cos();
        writeln!(text, "{},{th},{w},{u}", time(i)).unwrap();
        w += 0.05 * (15.0 * th.sin() + 3.0 * u);
        th += 0.05 * w;
    }
    text
}

/// Rows of a pendulum, θ̈ = −15 sin θ − 0.5 θ̇ + 3 u, at milliseconds 1000 and on that jitter by three.
fn at_uneven_times(start: f64, count: usize) -> String {
    let (mut th, mut w, mut t) = (start, 0.0_f64, 1000);
    let mut text = String::new();
    for i in 0..count {
        let u = (0.7 * i as f64).sin() + (0.31 * i as f64).cos();
        writeln!(text, "{t},{th},{w},{u}").unwrap();
        let milliseconds = 20 + 3 * ((7 * i) % 5) as i32 / 4;
        for _ in 0..100 * milliseconds {
            // The midpoint rule, at steps of 10 µs.
            let (h, rate) = (1e-5, |th: f64, w: f64| -15.0 * th.sin() - 0.5 * w + 3.0 * u);
            let (half_th, half_w) = (th + 0.5 * h * w, w + 0.5 * h * rate(th, w));
            (th, w) = (th + h * half_w, w + h * rate(half_th, half_w));
        }
        t += milliseconds;
    }
    text
}

/// A swing of ẇ = −15 sin th − 0.5 w + 3 u in `text`, columns in another order and another format of the time.
fn reordered(text: &str) -> String {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let seconds = cells[0].parse::<f64>().map(|ms| format!("{}", ms / 1000.0)).unwrap_or_else(|_| "t".into());
        format!("{};{};{};{seconds}\n", cells[3], cells[2], cells[1])
    };
    text.lines().map(row).collect()
}

#[test]
fn a_pendulum_is_found_in_its_log_and_runs_as_python() {
    let temp = tempfile::tempdir().unwrap();
    let args = [&COLUMNS[..], &["--angles", "th", "--out", "model"]].concat();
    let (code, stdout, stderr) = identify(temp.path(), &example(), &args);
    assert_eq!(code, 0, "{stdout}{stderr}");
    for line in [
        "log: log.csv, 101 rows in 1 trajectory, sampling interval 0.05 s",
        "states: th [rad] (angle), w [rad/s] (rate of th); inputs: u [N·m]; precision float64",
        "note: w is used as the rate of th",
        "equations: stepped by semi-implicit Euler, 0.05 s",
        "  dth/dt = w\n",
        "  w\u{307} = 15 sin th + 3 u\n",
        "dth/dt   is w, not fitted",
        "standard error",
        "at the level of rounding",
        "steps used: 100",
    ] {
        assert!(stdout.contains(line), "{line:?} is missing in {stdout}");
    }
    let account = json(&temp.path().join("model/identify.json"));
    let equation = &account["equations"][1];
    assert_eq!(equation["reached_floor"], true);
    assert_eq!(account["rows"], 100);
    for (term, truth) in [("sin th", 15.0), ("u", 3.0)] {
        let found = equation["terms"].as_array().unwrap().iter().find(|t| t["term"] == term).unwrap();
        let error = found["standard_error"].as_f64().unwrap();
        assert!((found["coefficient"].as_f64().unwrap() - truth).abs() < 1e-12 && error > 0.0 && error < 1e-8);
    }
    assert!(fs::read_to_string(temp.path().join("model/config.toml")).unwrap().contains("rate_of = \"th\""));

    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["export", "model", "--to", "python"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("written: model/model.py"), "{stdout}");
    let model = Model::from_json(&fs::read_to_string(temp.path().join("model/model.json")).unwrap()).unwrap();
    let states: Vec<[f64; 3]> = (0..100).map(|i| [1.0, 1.7, 2.3].map(|k| 3.0 * (k * f64::from(i)).sin())).collect();
    let script = format!(
        "import json, model, numpy as np\ns = np.array({states:?})\nassert model.STATES == ('th', 'w')\n\
         assert model.DT == 0.05\nprint(json.dumps(model.step(s[:, :2], s[:, 2:]).tolist()))\n"
    );
    let next: Vec<Vec<f64>> = serde_json::from_str(&python(&temp.path().join("model"), &script)).unwrap();
    for (state, python) in states.iter().zip(&next) {
        let mut expected = [0.0; 2];
        model.step(&state[..2], &state[2..], &mut Seed::new(0).numpy(), &mut expected).unwrap();
        for (a, b) in python.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{python:?} is not {expected:?}");
        }
    }
}

#[test]
fn the_same_log_gives_the_same_bytes_and_nothing_is_overwritten() {
    let temp = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        assert_eq!(identify(temp.path(), &example(), &COLUMNS).0, 0);
    }
    for file in ["model.json", "identify.json", "config.toml"] {
        let of = |dir: &str| fs::read(temp.path().join("models").join(dir).join(file)).unwrap();
        assert!(of("log") == of("log-2"), "{file} differs");
    }
    let (code, stdout, stderr) = identify(temp.path(), &example(), &[&COLUMNS[..], &["--out", "models/log"]].concat());
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(stderr.contains("models/log exists already"), "{stderr}");
}

#[test]
fn noise_that_is_given_and_digits_that_are_missing_are_taken_as_errors() {
    let temp = tempfile::tempdir().unwrap();
    let rounded = |line: &str, digits: usize| {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        format!("{},{:.digits$},{:.digits$},{}\n", cells[0], cells[1], cells[2], cells[3])
    };
    let header = "t,th,w,u\n".to_owned();
    let coarse = rows(2.0, 200, |i| 0.05 * i as f64).lines().map(|l| rounded(l, 3)).collect::<String>();
    let args = [&COLUMNS[..], &["--angles", "th"]].concat();
    let (code, stdout, stderr) = identify(temp.path(), &(header.clone() + &coarse), &args);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let equation = stdout.lines().find(|l| l.starts_with("  w\u{307} = ")).unwrap();
    assert!(
        equation.contains("sin th + ") && equation.ends_with(" u") && equation.split_whitespace().count() == 8,
        "{stdout}"
    );
    assert!(stdout.contains("note: th is recorded in steps of 0.001"), "{stdout}");
    // The same steps, unknown to the program, are estimated: a step of 0.001 is an error of 0.00029.
    let unknown = [&args[..], &["--precision", "f64", "--strict"]].concat();
    let (code, stdout, _) = identify(temp.path(), &(header.clone() + &coarse), &unknown);
    assert!(code == 0 && stdout.contains("15 sin th + 2.999"), "{stdout}");
    assert!(stdout.contains("noise, estimated: th 0.00029 rad (fit 100.0 %), w 0.00029 rad/s (fit"), "{stdout}");
    let given = [&args[..], &["--precision", "f64", "--noise", "th=0.0003,w=0.0003"]].concat();
    let (_, stdout, _) = identify(temp.path(), &(header + &coarse), &given);
    assert!(stdout.contains("white, consistent with noise"), "{stdout}");
}

#[test]
fn steps_that_end_at_a_given_limit_are_left_out() {
    let temp = tempfile::tempdir().unwrap();
    let mut log = String::from("t,x,v,u\n");
    let (mut x, mut v) = (0.0, 0.0_f64);
    for i in 0..80 {
        let u = (0.4 * f64::from(i)).sin();
        writeln!(log, "{},{x},{v},{u}", 0.1 * f64::from(i)).unwrap();
        x += 0.1 * v;
        v = (v + 0.1 * (2.0 * u - 0.5 * v)).clamp(-0.4, 0.4);
    }
    let args = ["--states", "x,v", "--inputs", "u", "--limits", "v=-0.4:0.4", "--out", "model"];
    let (code, stdout, stderr) = identify(temp.path(), &log, &args);
    assert!(code == 0 && stdout.contains("  v\u{307} = \u{2212}0.5 v + 2 u\n"), "{stdout}{stderr}");
    let account = json(&temp.path().join("model/identify.json"));
    assert!(account["rows"].as_u64().unwrap() < 79, "{}", account["rows"]);
}

#[test]
fn a_map_without_seconds_is_found() {
    let temp = tempfile::tempdir().unwrap();
    let mut log = String::from("x\n");
    let mut x = 0.3_f64;
    for _ in 0..40 {
        writeln!(log, "{x}").unwrap();
        x *= 3.7 * (1.0 - x);
    }
    let (code, stdout, stderr) = identify(temp.path(), &log, &["--states", "x", "--dt", "1", "--target", "discrete"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("x⁺ = 3.7 x − 3.7 x²"), "{stdout}");
    assert_eq!(parts(&sindyna(temp.path(), &["export", "models/log", "--to", "python"])).0, 0);
    let script = "import model; print(model.step([0.5])[0], hasattr(model, 'rhs'))";
    let printed = python(&temp.path().join("models/log"), script);
    let (next, has_rhs) = printed.trim().split_once(' ').unwrap();
    assert!((next.parse::<f64>().unwrap() - 0.925).abs() < 1e-9 && has_rhs == "False", "{printed}");
}

#[test]
fn what_is_known_of_equations_is_told_and_kept() {
    let temp = tempfile::tempdir().unwrap();
    let known = ["--angles", "th", "--known", "dw/dt: 15*sin(th)", "--sign", "dw/dt: u > 0", "--forbid", "dw/dt: w"];
    let args = [&COLUMNS[..], &known, &["--out", "model"]].concat();
    let (code, stdout, stderr) = identify(temp.path(), &example(), &args);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("15 sin th") && stdout.contains("3 u"), "{stdout}");
    assert!(stdout.lines().any(|line| line.contains("sin th") && line.contains("as given")), "{stdout}");
    let account = json(&temp.path().join("model/identify.json"));
    assert_eq!(account["identification"]["known"][0], "dw/dt: 15*sin(th)");
    assert_eq!(account["equations"][1]["terms"][1]["known"], true);

    for (option, text, complaint) in [
        ("--known", "dw/dt 9.81", "takes `dSTATE/dt: ...`"),
        ("--known", "dv/dt: 9.81", "no state named `v`"),
        ("--require", "dth/dt: u", "the rate of `th` is the state `w`"),
        ("--require", "dw/dt: 2*u", "is not a single term"),
        ("--forbid", "dw/dt: foo", "no variable named `foo`"),
        ("--sign", "dw/dt: u = 0", "takes `dSTATE/dt: TERM < 0`"),
    ] {
        let args = [&COLUMNS[..], &[option, text, "--out", "refused"]].concat();
        let (code, _, stderr) = identify(temp.path(), &example(), &args);
        assert!(code == 2 && stderr.contains(complaint), "{option} {text}: {stderr}");
        assert!(!temp.path().join("refused").exists());
    }
    let other = [&COLUMNS[..], &["--known", "dw/dt: u", "--target", "increment", "--out", "refused"]].concat();
    let (code, _, stderr) = identify(temp.path(), &example(), &other);
    assert!(code == 2 && stderr.contains("target `motion`"), "{stderr}");
}

#[test]
fn where_no_noise_is_allowed_noisy_equations_are_an_approximation() {
    let temp = tempfile::tempdir().unwrap();
    let mut rng = Seed::new(1).stream("noise", 0);
    let mut log = String::from("t,th,w,u\n");
    for line in rows(2.0, 200, |i| 0.05 * i as f64).lines() {
        let v: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let mut noise = || 0.01 * (rng.random::<f64>() - 0.5);
        writeln!(log, "{},{},{},{}", v[0], v[1] + noise(), v[2] + noise(), v[3]).unwrap();
    }
    for (noise, out, adequate) in [("auto", "auto", true), ("none", "none", false)] {
        let args = [&COLUMNS[..], &["--angles", "th", "--noise", noise, "--strict", "--out", out]].concat();
        let (code, stdout, stderr) = identify(temp.path(), &log, &args);
        assert_eq!(code, i32::from(!adequate), "{stdout}{stderr}");
        assert_eq!(stdout.contains("an approximation"), !adequate, "{stdout}");
    }
}
