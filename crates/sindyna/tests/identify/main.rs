//! Equations from logs, and as programs, as the user sees it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

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

#[test]
fn a_pendulum_is_found_in_its_log_and_runs_as_python() {
    let temp = tempfile::tempdir().unwrap();
    let args = [&COLUMNS[..], &["--angles", "th", "--out", "model"]].concat();
    let (code, stdout, stderr) = identify(temp.path(), &example(), &args);
    assert_eq!(code, 0, "{stdout}{stderr}");
    for line in [
        "log: log.csv, 101 rows in 1 trajectory, sampling interval 0.05 s",
        "states: th [rad] (angle), w [rad/s] (rate of th); inputs: u [N·m]; precision float64",
        "note: w is taken as the rate of th",
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
fn without_options_names_tell_what_columns_are_or_the_call_is_shown() {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, _) = identify(temp.path(), &example(), &[]);
    let told = "note: told by the names of columns: states th, w; inputs u; --states and --inputs say otherwise";
    assert!(code == 0 && stdout.contains(told) && stdout.contains("15 sin th + 3 u"), "{stdout}");
    let (code, stdout, stderr) = identify(temp.path(), "cos θ,v,reward\n1,2,3\n", &[]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(
        stderr.contains("which of the columns `cos θ`, `v`, `reward` are states, and which are inputs?"),
        "{stderr}"
    );
    assert!(stderr.contains("--states 'cos θ,v' --dt SECONDS"), "{stderr}");
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

#[test]
fn samples_are_taken_at_their_own_times_from_several_logs() {
    let temp = tempfile::tempdir().unwrap();
    for (name, start) in [("a.csv", 2.0), ("b.csv", -1.0)] {
        fs::write(temp.path().join(name), "time,th,w,u\n".to_owned() + &at_uneven_times(start, 150)).unwrap();
    }
    let args = ["identify", "a.csv", "b.csv", "--angles", "th", "--holdout", "0.2", "--out", "model"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stderr}");
    for says in [
        "log: a.csv, b.csv, 300 rows in 2 trajectories, sampling interval about 0.02",
        "note: time is taken as the time in milliseconds: in these one state is the rate of another; --time-column and --units",
        "note: samples are 0.02 to 0.023 s apart",
    ] {
        assert!(stdout.contains(says), "{says:?} is missing in {stdout}");
    }
    let account = json(&temp.path().join("model/identify.json"));
    let terms = account["equations"][1]["terms"].as_array().unwrap();
    assert_eq!(terms.len(), 3, "{stdout}");
    for (term, truth) in [("sin th", -15.0), ("w", -0.5), ("u", 3.0)] {
        let found = terms.iter().find(|t| t["term"] == term).unwrap_or_else(|| panic!("{stdout}"));
        assert!((found["coefficient"].as_f64().unwrap() - truth).abs() < 1e-3, "{term}: {stdout}");
    }
    let ahead = account["held_out"]["predictions"][4]["fit_percent"][0][1].as_f64().unwrap();
    assert!(ahead > 99.9, "{ahead}");
    let data = fs::read_to_string(temp.path().join("model/data.csv")).unwrap();
    let second: Vec<&str> = data.lines().nth(2).unwrap().split(',').collect();
    assert_eq!(second[..2], ["0", "0.02"], "as stamped, since the first sample");
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
fn rates_are_recognised_declared_or_left_alone() {
    let temp = tempfile::tempdir().unwrap();
    for (option, says) in [
        (&[][..], "w [rad/s] (rate of th); inputs"),
        (&["--rates", "w=th"], "w [rad/s] (rate of th); inputs"),
        (&["--rates", "none"], "th [rad], w [rad/s]; inputs"),
    ] {
        let (code, stdout, stderr) = identify(temp.path(), &example(), &[&COLUMNS[..], option].concat());
        assert_eq!(code, 0, "{stderr}");
        assert!(stdout.contains(says), "{stdout}");
        assert_eq!(stdout.contains("note: w is taken"), option.is_empty());
    }
}

#[test]
fn an_angle_given_as_cosine_and_sine_is_recognised() {
    let temp = tempfile::tempdir().unwrap();
    let turned = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let th: f64 = cells[1].parse().unwrap();
        format!("{},{},{},{},{}\n", cells[0], th.sin(), th.cos(), cells[2], cells[3])
    };
    let log = rows(2.0, 100, |i| 0.05 * i as f64).lines().map(turned).collect::<String>();
    let log = format!("t,sin_th,cos_th,w,u\n{log}");
    let (code, stdout, stderr) = identify(temp.path(), &log, &["--states", "sin_th,cos_th,w", "--inputs", "u"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    for line in [
        "note: cos_th and sin_th are taken as cosine and sine of one angle, th",
        "note: w is taken as the rate of th",
        "  w\u{307} = 15 sin th + 3 u\n",
    ] {
        assert!(stdout.contains(line), "{line:?} is missing in {stdout}");
    }
    let raw = ["--states", "sin_th,cos_th,w", "--inputs", "u", "--circles", "none"];
    let (code, stdout, _) = identify(temp.path(), &log, &raw);
    assert!(code == 0 && stdout.contains("dcos_th/dt ="), "{stdout}");
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
    assert!(stdout.contains("note: th is written in steps of 0.001"), "{stdout}");
    // The same steps, unknown to the program, are estimated: a step of 0.001 is an error of 0.00029.
    let unknown = [&args[..], &["--precision", "f64", "--strict"]].concat();
    let (code, stdout, _) = identify(temp.path(), &(header.clone() + &coarse), &unknown);
    assert!(code == 0 && stdout.contains("15 sin th + 2.999"), "{stdout}");
    assert!(stdout.contains("noise, estimated: th 0.00029 rad (fit 100.0 %), w 0.00029 rad/s (fit"), "{stdout}");
    let given = [&args[..], &["--precision", "f64", "--noise", "th=0.0003,w=0.0003"]].concat();
    let (_, stdout, _) = identify(temp.path(), &(header + &coarse), &given);
    assert!(stdout.contains("white, as noise is"), "{stdout}");
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
fn a_rate_that_is_none_is_doubted() {
    let temp = tempfile::tempdir().unwrap();
    let args = [&COLUMNS[..], &["--rates", "th=w"]].concat();
    let (code, stdout, stderr) = identify(temp.path(), &example(), &args);
    assert!(code == 0 && stdout.contains("as declared; w changes otherwise"), "{stdout}{stderr}");
}

#[test]
fn rollouts_folded_angles_and_uneven_stamps_are_put_right() {
    let temp = tempfile::tempdir().unwrap();
    let header = "t,th,w,u\n";
    let found = |log: &str, args: &[&str], says: &[&str]| {
        let (code, stdout, stderr) = identify(temp.path(), log, &[&COLUMNS[..], args].concat());
        assert_eq!(code, 0, "{stderr}");
        says.iter().for_each(|s| assert!(stdout.contains(s), "{s:?} is missing in {stdout}"));
    };
    let exact = "w\u{307} = 15 sin th + 3 u";
    // Two rollouts, the last input of each missing, an unused column of words.
    let mut log = String::from("trajectory,t,th,w,u,remark\n");
    for (label, start) in [("a", 3.0), ("b", 2.0)] {
        let rows = rows(start, 30, |i| i as f64 * 0.05);
        let last = rows.trim_end().rfind(',').unwrap();
        log.extend(format!("{},", &rows[..last]).lines().map(|row| format!("{label},{row},fine\n")));
    }
    found(&log, &[], &["in 2 trajectories", "steps used: 58", "`remark` is not used", exact]);
    // No stamps, but an interval.
    let bare: String = rows(3.0, 40, |_| 0.0).lines().map(|r| r.trim_start_matches("0,").to_owned() + "\n").collect();
    found(&("th,w,u\n".to_owned() + &bare), &["--dt", "0.05"], &["sampling interval 0.05 s", exact]);
    // An angle that goes over the top, folded into one turn.
    let folded: String = rows(0.3, 60, |i| i as f64 * 0.05)
        .lines()
        .map(|row| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            let th: f64 = cells[1].parse().unwrap();
            cells[1] = (th - TAU * (th / TAU).round()).to_string();
            cells.join(",") + "\n"
        })
        .collect();
    found(&(header.to_owned() + &folded), &["--angles", "th"], &["joined where it jumps by a whole turn", exact]);
    // Stamps that jitter, taken as even or resampled.
    let jittery = header.to_owned() + &rows(3.0, 60, |i| i as f64 * 0.05 + 0.004 * (i % 3) as f64);
    found(&jittery, &["--dt", "0.05"], &["time stamps say the same but for jitter", exact]);
    found(&jittery, &["--resample", "0.05"], &["resampled every 0.05 s"]);
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
        ("--known", "dv/dt: 9.81", "there is no state `v`"),
        ("--require", "dth/dt: u", "the rate of `th` is the state `w`"),
        ("--require", "dw/dt: 2*u", "is not one term"),
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

#[test]
fn a_log_may_come_from_standard_input_with_other_cells_and_time() {
    use std::io::Write as _;
    let temp = tempfile::tempdir().unwrap();
    let log = example().replace(',', ";").replacen("t [s];", "seconds [s];", 1).replacen("t;", "seconds;", 1);
    assert!(log.starts_with("seconds"), "{}", &log[..40]);
    let args = [&["identify", "-"], &COLUMNS[..], &["--angles", "th", "--delimiter", ";", "--time-column", "seconds"]];
    let mut process = common::command(temp.path(), &args.concat())
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    process.stdin.take().unwrap().write_all(log.as_bytes()).unwrap();
    let (code, stdout, stderr) = parts(&process.wait_with_output().unwrap());
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stdout.contains("log: standard input, 101 rows") && stdout.contains("w\u{307} = 15 sin th + 3 u"),
        "{stdout}"
    );
    assert!(temp.path().join("models/log/model.json").is_file());
}

#[test]
fn a_log_is_inspected_before_anything_is_identified() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), "time,th,w,u\n".to_owned() + &at_uneven_times(2.0, 150)).unwrap();
    let args = ["inspect", "log.csv", "--angles", "th", "--report", "log.html", "--json"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stderr}");
    let told: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let told = &told["result"];
    assert_eq!(told["rows"], 150);
    for (step, truth) in [("shortest", 0.02), ("longest", 0.023)] {
        assert!((told["step"][step].as_f64().unwrap() - truth).abs() < 1e-9, "{told}");
    }
    let response = &told["responses"][0];
    assert!(
        response["state"] == "w"
            && response["delay"].as_f64() == Some(0.0)
            && response["correlation"].as_f64().unwrap() > 0.95,
        "{told}"
    );
    assert!(fs::read_to_string(temp.path().join("log.html")).unwrap().contains("th [rad] against time"));
    let (code, stdout, _) = parts(&sindyna(temp.path(), &args));
    assert!(code == 2 && stdout.contains("log.html exists already"), "{stdout}");
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
fn another_log_is_held_out_and_predicted_in_windows() {
    let temp = tempfile::tempdir().unwrap();
    let header = "time,th,w,u\n".to_owned();
    fs::write(temp.path().join("a.csv"), header.clone() + &at_uneven_times(2.0, 150)).unwrap();
    fs::write(temp.path().join("b.csv"), reordered(&(header.clone() + &at_uneven_times(-1.0, 150)))).unwrap();
    let args = ["identify", "a.csv", "--angles", "th", "--out"];
    let alone = parts(&sindyna(temp.path(), &[&args[..], &["alone"]].concat()));
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &[&args[..], &["model", "--holdout", "b.csv"]].concat()));
    assert_eq!((code, alone.0), (0, 0), "{stderr}");
    let bytes = |dir: &str| fs::read(temp.path().join(dir).join("model.json")).unwrap();
    assert_eq!(bytes("model"), bytes("alone"), "what is held out changes nothing");
    assert!(stdout.contains("held out: 149 steps of b.csv"), "{stdout}");
    let held_out = &json(&temp.path().join("model/identify.json"))["held_out"];
    assert_eq!(held_out["logs"][0], "b.csv");
    let predictions = held_out["predictions"].as_array().unwrap();
    let seconds: Vec<Option<f64>> = predictions.iter().map(|p| p["seconds"].as_f64()).collect();
    assert_eq!(seconds, [None, None, Some(0.5), Some(1.0), None]);
    for ahead in predictions {
        assert_eq!(ahead["diverged"], 0);
        for i in [0, 1] {
            let fit = ahead["fit_percent"][i][1].as_f64().unwrap();
            let (rmse, median) = (ahead["rmse"][i][1].as_f64().unwrap(), ahead["median_rmse"][i][1].as_f64().unwrap());
            assert!(fit > 99.9 && rmse < 1e-3 && median < 1e-3, "{ahead}");
        }
    }
    // One step: a window for each.
    assert_eq!((&predictions[0]["windows"], &predictions[4]["windows"]), (&149.into(), &1.into()));
    let missing = header.replace("w,u", "v,u") + &at_uneven_times(0.3, 20);
    fs::write(temp.path().join("c.csv"), missing).unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &[&args[..], &["none", "--holdout", "c.csv"]].concat()));
    assert!(code == 2 && stderr.contains("c.csv has no column named `w`"), "{stderr}");
    let (code, _, stderr) =
        parts(&sindyna(temp.path(), &[&args[..], &["none", "--holdout", "b.csv", "--holdout", "0.2"]].concat()));
    assert!(code == 2 && stderr.contains("one share or other logs"), "{stderr}");
}

#[test]
fn a_model_that_diverges_on_another_log_is_said_to() {
    let temp = tempfile::tempdir().unwrap();
    // ẋ = x² from −2 on comes to rest; from 2 on it is gone in half a second.
    let row = |x: f64, i: usize| format!("{},{x}\n", 0.02 * i as f64);
    let falling: String = (0..100).map(|i| row(-1.0 / (0.5 + 0.02 * i as f64), i)).collect();
    let standing: String = (0..100).map(|i| row(2.0, i)).collect();
    fs::write(temp.path().join("a.csv"), "t,x\n".to_owned() + &falling).unwrap();
    fs::write(temp.path().join("b.csv"), "t,x\n".to_owned() + &standing).unwrap();
    let args = ["identify", "a.csv", "--holdout", "b.csv", "--out", "model"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("the model diverges in") && stdout.contains("first in that from 0 s on"), "{stdout}");
    let held_out = &json(&temp.path().join("model/identify.json"))["held_out"]["predictions"];
    let second = held_out.as_array().unwrap().iter().find(|p| p["seconds"] == 1.0).unwrap();
    assert_eq!(second["diverged"], second["windows"]);
    assert!(second["rmse"][0][1].is_null() && second["median_rmse"][0][1].is_null(), "{second}");
    assert_eq!(held_out[0]["diverged"], 0);
}

#[test]
fn logs_of_several_formats_are_one() {
    let temp = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../logs/tests/data");
    for name in ["energy_shaping.csv", "formats/log.npz", "formats/struct.mat", "formats/record.npy"] {
        let path = data.join(name);
        fs::copy(&path, temp.path().join(path.file_name().unwrap())).unwrap();
    }
    let args = ["inspect", "energy_shaping.csv", "log.npz", "struct.mat", "record.npy"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert!(code == 0 && stdout.contains("240 rows in 4 trajectories"), "{stdout}{stderr}");
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["inspect", "log.npz", "--states", "position,speed"]));
    assert!(code == 2 && stderr.contains("log.npz has no column named `speed`"), "{stderr}");
}
