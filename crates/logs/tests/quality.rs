//! What spoils a log is said, with its times; what spoils nothing is not.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::TAU;

use sindyna_logs::{Finding, Log, LogOptions};

const DT: f64 = 0.005;
const ROWS: usize = 4000;

/// A number between −1 and 1 that looks like chance.
fn chance(i: usize, j: usize) -> f64 {
    let x = ((i + 1) as f64 * 12.9898 + j as f64 * 78.233).sin() * 43_758.547;
    2.0 * (x - x.floor()) - 1.0
}

/// A log of x, its rate v and an input u, which are functions of time and row.
fn text(row: impl Fn(f64, usize) -> [f64; 3]) -> String {
    let line = |i: usize| {
        let t = DT * i as f64;
        let [x, v, u] = row(t, i);
        format!("{t},{x},{v},{u}\n")
    };
    "t,x,v,u\n".to_owned() + &(0..ROWS).map(line).collect::<String>()
}

fn findings(text: String) -> Vec<Finding> {
    Log::parse("log.csv", text, &LogOptions::new(["x", "v"]).with_inputs(["u"])).unwrap().findings
}

/// A swing at 0.8 Hz under an input that moves by itself.
fn swing(t: f64, i: usize) -> [f64; 3] {
    let w = TAU * 0.8;
    [
        1.5 * (w * t).sin() + 1e-3 * chance(i, 0),
        1.5 * w * (w * t).cos() + 1e-3 * chance(i, 1),
        (2.1 * t).sin() + (3.7 * t).cos(),
    ]
}

#[test]
fn a_good_log_is_left_alone() {
    assert_eq!(findings(text(swing)), []);
    // A random input, one that switches, one that was stepped by hand, and rest at the end.
    assert_eq!(
        findings(text(|t, i| {
            let [x, v, _] = swing(t, i);
            [x, v, chance(i, 3)]
        })),
        []
    );
    assert_eq!(
        findings(text(|t, i| {
            let [x, v, _] = swing(t, i);
            [x, v, chance(i / 40, 3).signum()]
        })),
        []
    );
    assert_eq!(
        findings(text(|t, i| {
            let [x, v, _] = swing(t, i);
            [x, v, chance(i / 80, 3)]
        })),
        []
    );
    let resting = |t: f64, i: usize| {
        let q = 1.5e-3 * ((1.0 - (-t).exp()) / 1.5e-3).round();
        [q, (-t).exp() + 1e-3 * chance(i, 1), chance(i, 3)]
    };
    let found = findings(text(resting));
    assert!(!found.iter().any(|f| matches!(f, Finding::Clips { .. } | Finding::Spikes { .. })), "{found:?}");
}

#[test]
fn a_motor_against_its_rod_is_heard() {
    let found = findings(text(|t, i| {
        let ([x, v, u], fast) = (swing(t, i), TAU * 30.0);
        [x - 1.0 / fast * (fast * t).cos(), v + (fast * t).sin(), u]
    }));
    let [Finding::Oscillates { signal, frequency, rms, share }] = &found[..] else { panic!("{found:?}") };
    assert_eq!(signal, "v");
    assert!((frequency - 30.0).abs() < 1.0 && (rms - 0.5_f64.sqrt()).abs() < 0.03 && *share > 0.9, "{found:?}");
}

#[test]
fn peaks_where_an_input_is_switched_are_no_spikes() {
    // A body that warms and cools by turns, with little noise: its temperature has a corner at every switch.
    let warmth = |t: f64| {
        let (turn, at) = ((t / 2.0) as usize, t % 2.0);
        if turn.is_multiple_of(2) { 1.0 - (-at).exp() } else { (1.0 - (-2.0_f64).exp()) * (-at).exp() }
    };
    let found =
        findings(text(|t, i| [warmth(t) + 1e-4 * chance(i, 1), (TAU * t).sin(), f64::from(u8::from(t % 4.0 < 2.0))]));
    assert!(!found.iter().any(|f| matches!(f, Finding::Spikes { .. })), "{found:?}");
}

#[test]
fn bends_after_a_fast_motor_is_switched_are_no_spikes() {
    // Two lags one after the other, of 4 and 20 samples: computed, with six decimals; one sample is off.
    let level = |i: usize| chance(i / 37, 3);
    let mut states = vec![[0.0, 0.0]];
    for i in 0..ROWS {
        let [x, v] = states[i];
        states.push([level(i) + (x - level(i)) * (-0.25_f64).exp(), x + (v - x) * (-0.05_f64).exp()]);
    }
    let rounded = |v: f64| (v * 1e6).round() * 1e-6;
    let log = |off: f64| {
        text(|_, i| [rounded(states[i][0] + if i == 1020 { off } else { 0.0 }), rounded(states[i][1]), level(i)])
    };
    let spikes = |found: Vec<Finding>| -> Vec<Finding> {
        found.into_iter().filter(|f| matches!(f, Finding::Spikes { .. })).collect()
    };
    assert_eq!(spikes(findings(log(0.0))), []);
    let found = spikes(findings(log(0.1)));
    let [Finding::Spikes { signal, at, .. }] = &found[..] else { panic!("{found:?}") };
    assert!(signal == "x" && at.len() == 1 && (at[0].seconds - 1020.0 * DT).abs() < 1e-9, "{found:?}");
}

#[test]
fn an_overflow_and_spikes_are_told_with_their_times() {
    // Over the brim for a quarter of every turn, from 1/8 turn on.
    let brim = 1.5 * 0.5_f64.sqrt();
    let found = findings(text(|t, i| {
        let [x, v, u] = swing(t, i);
        [x.min(brim), v, if [1000, 2500].contains(&i) { 9.0 } else { u }]
    }));
    let [Finding::Clips { signal, limit, share, at }, Finding::Spikes { signal: spiky, largest, at: spikes }] =
        &found[..]
    else {
        panic!("{found:?}")
    };
    assert_eq!((signal.as_str(), *limit, spiky.as_str()), ("x", brim, "u"));
    assert!((share - 0.25).abs() < 0.01 && (at[0].seconds - 0.125 / 0.8).abs() < 0.01, "{found:?}");
    assert!((at[1].seconds - at[0].seconds - 1.25).abs() < 0.02, "{found:?}");
    assert!(*largest > 6.0 && spikes.iter().map(|at| at.seconds).eq([5.0, 12.5]), "{found:?}");
    let told = found[1].to_string();
    assert!(
        told.contains("u has 2 samples that deviate from both neighbours") && told.contains("at 5 s, 12.5 s"),
        "{told}"
    );
}

#[test]
fn an_input_that_a_controller_made_is_told_from_one_that_moves() {
    let found = findings(text(|t, i| {
        let [x, v, u] = swing(t, i);
        [x, v, -3.0 * x - 0.5 * v + 0.05 * u]
    }));
    let [Finding::Feedback { signal, share }] = &found[..] else { panic!("{found:?}") };
    assert!(signal == "u" && *share > 0.99, "{found:?}");
    let found = findings(text(|t, i| [swing(t, i)[0], swing(t, i)[1], 0.5]));
    assert_eq!(found, [Finding::Constant { signal: "u".into() }]);
}

#[test]
fn gaps_are_told_with_their_file_and_time() {
    let folder = tempfile::tempdir().unwrap();
    let whole = text(swing);
    let paths = ["a.csv", "b.csv"].map(|name| folder.path().join(name));
    std::fs::write(&paths[0], &whole).unwrap();
    // Rows 200 to 299 are not there.
    let torn: Vec<&str> = whole.lines().enumerate().filter(|(i, _)| !(201..301).contains(i)).map(|(_, l)| l).collect();
    std::fs::write(&paths[1], torn.join("\n") + "\n").unwrap();
    let log = Log::read_all(&paths, &LogOptions::default()).unwrap();
    let [Finding::Gaps { longest, at }] = &log.findings[..] else { panic!("{:?}", log.findings) };
    assert!((longest - 0.505).abs() < 1e-9 && (at[0].seconds - 0.995).abs() < 1e-9, "{at:?}");
    assert_eq!(at[0].file.as_ref(), Some(&paths[1]));
    let note = log.notes.iter().find(|n| n.to_string().contains("longer than")).unwrap().to_string();
    assert!(note.contains(&format!("before line 202 of {}", paths[1].display())), "{note}");
}

#[test]
fn an_encoder_too_coarse_for_its_rows_is_told() {
    let coarse = findings(text(|t, i| {
        let [x, v, u] = swing(0.05 * t, i);
        [0.02 * (x / 0.02).round(), v, u]
    }));
    assert!(coarse.iter().any(|f| matches!(f, Finding::Coarse { signal, .. } if signal == "x")), "{coarse:?}");
    // One step on the one side of zero, another on the other.
    let two = findings(text(|t, i| {
        let [x, v, u] = swing(t, i);
        let step = if v > 0.0 { 0.1 } else { 0.1 * 2.0_f64.sqrt() };
        [x, step * (v / step).round(), u]
    }));
    assert!(two.iter().any(|f| matches!(f, Finding::FewValues { signal, .. } if signal == "v")), "{two:?}");
}
