//! Logs of positions alone: rates that were not measured are found with the equations.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fmt::Write as _;
use std::fs;

use common::{json, parts, sindyna};

/// Rows `t,q,u` of q' = v, v' = `rate`(q, v, u) every 0.05 s under steps of u, without v; `wrong` is added to each q.
fn positions(rate: impl Fn(f64, f64, f64) -> f64, count: usize, wrong: impl Fn(usize) -> f64) -> String {
    const PARTS: usize = 50;
    let (mut q, mut v) = (0.6_f64, 0.0_f64);
    let mut text = "t,q,u\n".to_owned();
    for i in 0..count {
        let u = ((i / 6 * 7919) % 17) as f64 / 8.0 - 1.0;
        writeln!(text, "{},{},{u}", 0.05 * i as f64, q + wrong(i)).unwrap();
        let h = 0.05 / PARTS as f64;
        for _ in 0..PARTS {
            let f = |q: f64, v: f64| (v, rate(q, v, u));
            let k1 = f(q, v);
            let k2 = f(q + 0.5 * h * k1.0, v + 0.5 * h * k1.1);
            let k3 = f(q + 0.5 * h * k2.0, v + 0.5 * h * k2.1);
            let k4 = f(q + h * k3.0, v + h * k3.1);
            q += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
            v += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
        }
    }
    text
}

fn pendulum(q: f64, v: f64, u: f64) -> f64 {
    -9.81 * q.sin() - 0.3 * v + 4.0 * u
}

/// Numbers between −1 and 1 that look like chance.
fn shaken(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.547;
    2.0 * (x - x.floor()) - 1.0
}

/// Expects the terms of `truth` in an equation of `identify.json` and no others, off by no more than `most` of (standard error, truth).
fn has_terms(equation: &serde_json::Value, truth: &[(&str, f64)], most: impl Fn(f64, f64) -> f64) {
    let terms = equation["terms"].as_array().unwrap();
    assert_eq!(terms.len(), truth.len(), "{equation}");
    for &(term, truth) in truth {
        let found = terms.iter().find(|t| t["term"] == term).unwrap_or_else(|| panic!("{term}: {equation}"));
        let error = found["standard_error"].as_f64().unwrap_or(0.0);
        let off = (found["coefficient"].as_f64().unwrap() - truth).abs();
        assert!(off < most(error, truth), "{term}: {equation}");
    }
}

#[test]
fn a_pendulum_is_found_in_its_angle_alone() {
    let temp = tempfile::tempdir().unwrap();
    for (wrong, within) in [(0.0, 1e-5), (0.005, 0.02)] {
        fs::write(temp.path().join("log.csv"), positions(pendulum, 400, |i| wrong * shaken(i))).unwrap();
        let out = format!("model-{wrong}");
        let (code, stdout, stderr) =
            parts(&sindyna(temp.path(), &["identify", "log.csv", "--strict", "--holdout", "0.2", "--out", &out]));
        assert_eq!(code, 0, "{stdout}{stderr}");
        assert!(stdout.contains("states: q, q_dot (rate of q, not measured); inputs: u"), "{stdout}");
        assert!(stdout.contains("--unmeasured none turns this off"), "{stdout}");
        let account = json(&temp.path().join(&out).join("identify.json"));
        has_terms(&account["equations"][1], &[("sin q", -9.81), ("q_dot", -0.3), ("u", 4.0)], |_, truth| {
            within * truth.abs()
        });
        // Of the rate there is nothing to compare a prediction with.
        let predictions = account["held_out"]["predictions"].as_array().unwrap();
        let free = predictions.last().unwrap()["fit_percent"].as_array().unwrap();
        assert!(free.len() == 1 && free[0][0] == "q" && free[0][1].as_f64().unwrap() > 95.0, "{free:?}");
        let data = fs::read_to_string(temp.path().join(&out).join("data.csv")).unwrap();
        assert!(data.lines().next().unwrap().contains("q_dot"), "{data}");
    }
}

#[test]
fn rates_that_are_not_wanted_are_not_looked_for_and_those_named_are() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), positions(pendulum, 300, |_| 0.0)).unwrap();
    let with = |more: &[&str]| parts(&sindyna(temp.path(), &[&["identify", "log.csv", "--no-report"], more].concat()));
    let (code, stdout, _) = with(&["--unmeasured", "none"]);
    assert_eq!(code, 0);
    assert!(stdout.contains("states: q; inputs: u") && stdout.contains("an approximation"), "{stdout}");
    let (code, stdout, _) = with(&["--unmeasured", "w=q"]);
    assert_eq!(code, 0);
    assert!(stdout.contains("w (rate of q, not measured)") && stdout.contains("4 u"), "{stdout}");
    for (given, says) in [
        ("u=q", "`u` is a column of the log"),
        ("w=z", "no state named `z`"),
        ("w=q,p=q", "`q` already has a rate"),
        ("w=q,a=w,j=a", "at most 3 states"),
        ("w", "--unmeasured takes RATE=OF"),
    ] {
        let (code, stdout, stderr) = with(&["--unmeasured", given]);
        assert!(code == 2 && stderr.contains(says), "{given}: {stdout}{stderr}");
    }
}

/// A law of the angle that is no candidate: with a rate it is still an approximation, and called one.
#[test]
fn what_a_rate_does_not_explain_is_still_an_approximation() {
    let temp = tempfile::tempdir().unwrap();
    let odd = |q: f64, v: f64, u: f64| -9.0 * (5.0 * q).tanh() * (1.0 + 0.5 * (7.0 * q).sin()) - 0.3 * v + 4.0 * u;
    fs::write(temp.path().join("log.csv"), positions(odd, 300, |_| 0.0)).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--strict", "--no-report"]));
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(stdout.contains("an approximation"), "{stdout}");
}

/// Inputs that act two and seven rows late, also under much noise, and one that is linear between rows.
#[test]
fn inputs_that_act_at_other_times_are_told_or_named() {
    let temp = tempfile::tempdir().unwrap();
    let log = |late: i64, smooth: bool, noise: f64| {
        let (mut q, mut v) = (0.6_f64, 0.0_f64);
        let at = |i: i64| match smooth {
            true => (0.1 * i as f64).sin() + (0.047 * i as f64).cos(),
            false => ((i.max(0) / 6 * 7919) % 17) as f64 / 8.0 - 1.0,
        };
        let mut text = "t,q,v,u\n".to_owned();
        for i in 0..260_i64 {
            let noisy = |x: f64, k: usize| x + noise * shaken(2 * i as usize + k);
            writeln!(text, "{},{},{},{}", 0.05 * i as f64, noisy(q, 0), noisy(v, 1), at(i)).unwrap();
            let h = 0.05 / 200.0;
            for part in 0..200 {
                let share = if smooth { f64::from(part) / 200.0 } else { 0.0 };
                let u = at(i - late) + share * (at(i - late + 1) - at(i - late));
                v += h * pendulum(q, v, u);
                q += h * v;
            }
        }
        text
    };
    for (late, smooth, noise, says, otherwise) in [
        (2, false, 0.004, "delay of the inputs: 2 rows (0.1 s)", "--delay 0 turns this off"),
        (7, false, 0.004, "delay of the inputs: 7 rows (0.35 s)", "--delay 0 turns this off"),
        (7, false, 0.02, "delay of the inputs: 7 rows (0.35 s)", "--delay 0 turns this off"),
        (0, true, 0.004, "inputs are linear between samples (first-order hold)", "--intersample zoh turns this off"),
    ] {
        fs::write(temp.path().join("log.csv"), log(late, smooth, noise)).unwrap();
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--no-report"]));
        assert_eq!(code, 0, "{stdout}{stderr}");
        assert!(stdout.contains(says) && stdout.contains(otherwise), "{says}: {stdout}");
        assert!(stdout.contains("sin q"), "{stdout}");
    }
    fs::write(temp.path().join("log.csv"), log(2, false, 0.004)).unwrap();
    let (code, stdout, _) =
        parts(&sindyna(temp.path(), &["identify", "log.csv", "--no-report", "--strict", "--delay", "2"]));
    assert!(code == 0 && stdout.contains("sin q"), "{stdout}");
    for delay in ["soon", "nan", "1001"] {
        let (code, _, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--delay", delay]));
        assert!(code == 2 && stderr.contains("a delay is"), "{stderr}");
    }
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--intersample", "cubic"]));
    assert!(code == 2 && stderr.contains("`zoh` (held), `foh` (linear) or `bl` (smooth)"), "{stderr}");
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--delay", "500"]));
    assert!(code == 2 && stderr.contains("no trajectory is longer"), "{stderr}");
}

/// A motor whose input acts some rows and a part of a row late; its lag is no rate that nobody measured.
#[test]
fn inputs_that_act_between_rows_are_told() {
    const PARTS: usize = 100;
    let temp = tempfile::tempdir().unwrap();
    for late in [0.4, 2.5] {
        let shift = (late * PARTS as f64) as i64;
        let at = |part: i64| ((part.max(0) / (15 * PARTS as i64) * 7919) % 17) as f64 / 8.0 - 1.0;
        let (mut w, mut text) = (0.0, "t,w,u\n".to_owned());
        for i in 0..800_i64 {
            let first = i * PARTS as i64;
            writeln!(text, "{},{},{}", 0.02 * i as f64, w + 0.004 * shaken(i as usize), at(first)).unwrap();
            for part in first..first + PARTS as i64 {
                w += 0.02 / PARTS as f64 * (2.6 * at(part - shift) - 1.3 * w);
            }
        }
        fs::write(temp.path().join("log.csv"), text).unwrap();
        let out = format!("model-{late}");
        let told = ["identify", "log.csv", "--states", "w", "--inputs", "u", "--strict", "--no-report", "--out", &out];
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &told));
        assert_eq!(code, 0, "{stdout}{stderr}");
        let account = json(&temp.path().join(&out).join("identify.json"));
        assert!((account["input_delay"].as_f64().unwrap() - late).abs() < 0.1, "{stdout}");
        has_terms(&account["equations"][0], &[("w", -1.3), ("u", 2.6)], |_, truth| 0.02 * truth.abs());
    }
}

/// An angle that is seen as cosine and sine is one state of two columns.
#[test]
fn inputs_act_late_on_an_angle_seen_as_cosine_and_sine() {
    let temp = tempfile::tempdir().unwrap();
    let (mut q, mut v) = (0.6_f64, 0.0_f64);
    let at = |i: i64| ((i.max(0) / 6 * 7919) % 17) as f64 / 8.0 - 1.0;
    let mut text = "t,cos q,sin q,v,u\n".to_owned();
    for i in 0..400_i64 {
        let noisy = |x: f64, k: usize| x + 0.004 * shaken(3 * i as usize + k);
        let (c, s, w) = (noisy(q.cos(), 0), noisy(q.sin(), 1), noisy(v, 2));
        writeln!(text, "{},{c},{s},{w},{}", 0.05 * i as f64, at(i)).unwrap();
        for _ in 0..200 {
            v += 0.05 / 200.0 * pendulum(q, v, at(i - 2));
            q += 0.05 / 200.0 * v;
        }
    }
    fs::write(temp.path().join("log.csv"), text).unwrap();
    let told = ["identify", "log.csv", "--states", "cos q,sin q,v", "--inputs", "u", "--strict", "--no-report"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &told));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("delay of the inputs: 2 rows (0.1 s)"), "{stdout}");
    assert!(stdout.contains("cosine and sine of one angle"), "{stdout}");
}

/// The rows of `positions` with a column v: a difference quotient of q, as most logs have it.
fn with_quotients(text: &str, quotient: impl Fn(&[f64], usize) -> f64) -> String {
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let q: Vec<f64> = rows.iter().map(|row| row[1]).collect();
    let mut text = "t,q,v,u\n".to_owned();
    for (k, row) in rows.iter().enumerate() {
        writeln!(text, "{},{},{},{}", row[0], row[1], quotient(&q, k) / 0.05, row[2]).unwrap();
    }
    text
}

#[test]
fn rates_that_were_computed_are_no_measurements() {
    let temp = tempfile::tempdir().unwrap();
    let back = |q: &[f64], k: usize| if k > 0 { q[k] - q[k - 1] } else { 0.0 };
    let central = |q: &[f64], k: usize| 0.5 * (q[(k + 1).min(q.len() - 1)] - q[k.saturating_sub(1)]);
    for name in ["backward", "central"] {
        let quotient = |q: &[f64], k: usize| if name == "backward" { back(q, k) } else { central(q, k) };
        for (wrong, within) in [(0.0, 1e-4), (0.004, 0.02)] {
            let log = with_quotients(&positions(pendulum, 400, |i| wrong * shaken(i)), quotient);
            fs::write(temp.path().join("log.csv"), log).unwrap();
            let out = format!("{name}-{wrong}");
            let args = ["identify", "log.csv", "--strict", "--holdout", "0.2", "--no-report", "--out", &out];
            let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
            assert_eq!(code, 0, "{name}: {stdout}{stderr}");
            assert!(stdout.contains(&format!("v is the {name} difference quotient of q")), "{stdout}");
            assert!(stdout.contains("v (rate of q, not measured)"), "{stdout}");
            let account = json(&temp.path().join(&out).join("identify.json"));
            has_terms(&account["equations"][1], &[("sin q", -9.81), ("v", -0.3), ("u", 4.0)], |_, truth| {
                within * truth.abs()
            });
            let predictions = account["held_out"]["predictions"].as_array().unwrap();
            let free = predictions.last().unwrap()["fit_percent"].as_array().unwrap();
            assert!(free.len() == 1 && free[0][0] == "q", "nothing is compared with quotients: {free:?}");
        }
    }
}

/// A simulator whose positions move by its rates has quotients for rates that are states, also where few decimals were written.
#[test]
fn rates_by_which_a_simulator_steps_are_states() {
    let temp = tempfile::tempdir().unwrap();
    for decimals in [4, 12] {
        let (mut q, mut v) = (0.6_f64, 0.0_f64);
        let mut text = "t,q,v,u\n".to_owned();
        for i in 0..400 {
            let u = ((i / 6 * 7919) % 17) as f64 / 8.0 - 1.0;
            writeln!(text, "{:.2},{q:.decimals$},{v:.decimals$},{u}", 0.02 * f64::from(i)).unwrap();
            v += 0.02 * pendulum(q, v, u);
            q += 0.02 * v;
        }
        fs::write(temp.path().join("log.csv"), text).unwrap();
        let out = format!("model-{decimals}");
        let args = ["identify", "log.csv", "--strict", "--no-report", "--out", &out];
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
        assert_eq!(code, 0, "{stdout}{stderr}");
        assert!(stdout.contains("semi-implicit Euler") && !stdout.contains("quotient"), "{stdout}");
    }
}

/// A linear system whose input stays for a while: its quotients follow a map exactly, but where the input changes.
#[test]
fn quotients_of_a_linear_system_are_not_those_of_a_simulator() {
    let temp = tempfile::tempdir().unwrap();
    let spring = |q: f64, v: f64, u: f64| -4.0 * q - 0.5 * v + 1.5 * u;
    let back = |q: &[f64], k: usize| q[k.max(1)] - q[k.max(1) - 1];
    for decay in [false, true] {
        let free = |q: f64, v: f64, u: f64| spring(q, v, if decay { 0.0 } else { u });
        fs::write(temp.path().join("log.csv"), with_quotients(&positions(free, 400, |_| 0.0), back)).unwrap();
        let out = format!("model-{decay}");
        let args = ["identify", "log.csv", "--states", "q,v", "--no-report", "--out", &out];
        let driven = if decay { &[][..] } else { &["--inputs", "u"][..] };
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &[&args[..], driven].concat()));
        assert_eq!(code, 0, "{stdout}{stderr}");
        let account = json(&temp.path().join(&out).join("identify.json"));
        let truth = &[("q", -4.0), ("v", -0.5), ("u", 1.5)][..if decay { 2 } else { 3 }];
        has_terms(&account["equations"][1], truth, |_, truth| 1e-4 * truth.abs());
    }
}

/// Laws that are no candidates, to rounding: a rate that was not measured is free to make up for what equations miss.
#[test]
fn equations_that_are_nearly_right_are_not_exact_where_rates_are_free() {
    let temp = tempfile::tempdir().unwrap();
    let odd = |q: f64, v: f64, u: f64| -4.0 * q - 0.5 * v + 1.5 * u * (-q * q).exp() - 0.2 * (6.0 * v).atan();
    let back = |q: &[f64], k: usize| if k > 0 { q[k] - q[k - 1] } else { 0.0 };
    fs::write(temp.path().join("log.csv"), with_quotients(&positions(odd, 800, |_| 0.0), back)).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--strict", "--no-report"]));
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(stdout.contains("an approximation"), "{stdout}");
}

/// An input that acts between rows, without noise and with: the delay is found to the digits that the samples have, and the step is made in two parts.
#[test]
fn parts_of_rows_are_found_to_many_digits() {
    const PARTS: usize = 100;
    let temp = tempfile::tempdir().unwrap();
    for (noise, within) in [(0.0, 1e-6), (0.002, 0.01)] {
        let (mut q, mut v, mut text) = (0.4_f64, 0.0_f64, "t,q,v,u\n".to_owned());
        let at = |row: i64| ((row.max(0) * 7919) % 17) as f64 / 8.0 - 1.0;
        for i in 0..300_i64 {
            let noisy = |x: f64, k: usize| x + noise * shaken(2 * i as usize + k);
            writeln!(text, "{},{},{},{}", 0.05 * i as f64, noisy(q, 0), noisy(v, 1), at(i)).unwrap();
            for part in 0..PARTS as i64 {
                // 0.6 rows late.
                let u = at(if part < 60 { i - 1 } else { i });
                let h = 0.05 / PARTS as f64;
                let f = |q: f64, v: f64| (v, -4.0 * q - 0.5 * v + 1.5 * u);
                let k1 = f(q, v);
                let k2 = f(q + 0.5 * h * k1.0, v + 0.5 * h * k1.1);
                let k3 = f(q + 0.5 * h * k2.0, v + 0.5 * h * k2.1);
                let k4 = f(q + h * k3.0, v + h * k3.1);
                q += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
                v += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
            }
        }
        fs::write(temp.path().join("log.csv"), text).unwrap();
        let out = format!("model-{noise}");
        let (code, stdout, stderr) =
            parts(&sindyna(temp.path(), &["identify", "log.csv", "--strict", "--no-report", "--out", &out]));
        // With noise a sine may do as well for so small a motion.
        assert!(code == 0 || noise > 0.0 && stdout.contains("equations: ambiguous"), "{stdout}{stderr}");
        let account = json(&temp.path().join(&out).join("identify.json"));
        assert!((account["input_delay"].as_f64().unwrap() - 0.6).abs() < within, "{stdout}");
        has_terms(&account["equations"][1], &[("q", -4.0), ("v", -0.5), ("u", 1.5)], |error, _| 4.0 * error + 1e-6);
    }
}

/// A crane whose sway is measured under accelerations of its trolley, and a spring that hardens: with the products that an angle has, the first has fewer terms; the other has more with any.
#[test]
fn a_position_that_turns_is_an_angle_whatever_it_is_called() {
    let temp = tempfile::tempdir().unwrap();
    let crane = |q: f64, v: f64, u: f64| -9.0 * q.sin() - 4.0 * u * q.cos() - 0.15 * v;
    let spring = |q: f64, v: f64, u: f64| -9.0 * q - 3.0 * q.powi(3) - 0.15 * v + 4.0 * u;
    let crane_terms: &[(&str, f64)] = &[("sin q", -9.0), ("u\u{b7}cos q", -4.0), ("q_dot", -0.15)];
    let spring_terms: &[(&str, f64)] = &[("q", -9.0), ("q\u{b3}", -3.0), ("q_dot", -0.15), ("u", 4.0)];
    for (rows, turns, truth) in [
        (positions(crane, 600, |i| 0.003 * shaken(i)), true, crane_terms),
        (positions(spring, 600, |i| 0.003 * shaken(i)), false, spring_terms),
    ] {
        fs::write(temp.path().join("log.csv"), rows).unwrap();
        let out = format!("turns-{turns}");
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--strict", "--out", &out]));
        assert_eq!(code, 0, "{stdout}{stderr}");
        assert_eq!(stdout.contains("note: q is used as an angle"), turns, "{stdout}");
        let account = json(&temp.path().join(&out).join("identify.json"));
        has_terms(&account["equations"][1], truth, |error, truth| 4.0 * error + 1e-3 * truth.abs());
    }
}
