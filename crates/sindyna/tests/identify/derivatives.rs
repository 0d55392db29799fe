//! Logs with accelerations.

use std::fmt::Write as _;
use std::fs;

use rand::RngExt as _;
use sindyna_core::Seed;
use sindyna_sindy::Model;

use super::common::{parts, sindyna};

const DT: f64 = 0.04;

/// Angle, rate and acceleration of a sum of three sines with `seed`.
fn motion(t: f64, seed: f64) -> [f64; 3] {
    (1..=3).map(|k| (f64::from(k) * 1.7 + seed, 0.9 / f64::from(k), 0.7 * seed + f64::from(k * k))).fold(
        [0.2 * seed, 0.0, 0.0],
        |[q, v, a], (w, size, phase)| {
            let (sin, cos) = (w * t + phase).sin_cos();
            [q + size * sin, v + size * w * cos, a - size * w * w * sin]
        },
    )
}

/// Torques of an arm with two links of 1.1 kg and 0.7 kg, friction in both joints: M(q) q̈ + C(q, q̇) q̇ + g(q) + d q̇.
fn torques([q, p]: [f64; 2], [v, w]: [f64; 2], [a, b]: [f64; 2]) -> [f64; 2] {
    let (alpha, beta, delta) = (0.9, 0.25, 0.3);
    let (sin, cos) = p.sin_cos();
    let one = (alpha + 2.0 * beta * cos) * a + (delta + beta * cos) * b - beta * sin * (2.0 * v * w + w * w);
    let other = (delta + beta * cos) * a + delta * b + beta * sin * v * v;
    let (near, far) = (9.81 * 1.2 * q.cos(), 9.81 * 0.5 * (q + p).cos());
    [one + near + far + 0.4 * v, other + far + 0.1 * w]
}

/// A log of the arm.
fn log(rows: usize) -> String {
    let mut text = "t,q1,q2,dq1,dq2,ddq1,ddq2,tau1,tau2\n".to_owned();
    for i in 0..rows {
        let t = DT * i as f64;
        let ([q, v, a], [p, w, b]) = (motion(t, 0.4), motion(t, 1.3));
        let [one, other] = torques([q, p], [v, w], [a, b]);
        writeln!(text, "{t},{q},{p},{v},{w},{a},{b},{one},{other}").unwrap();
    }
    text
}

#[test]
fn accelerations_give_exact_equations_from_samples_that_are_far_apart() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("arm.csv"), log(150)).unwrap();
    let (code, notes, stderr) = parts(&sindyna(folder.path(), &["identify", "arm.csv", "--strict", "--out", "m"]));
    assert_eq!(code, 0, "{notes}{stderr}");
    assert!(notes.contains("ddq1 is used as the measured derivative of dq1"), "{notes}");
    assert!(notes.contains("first-order hold"), "torques are not held: {notes}");
    let model = Model::from_json(&fs::read_to_string(folder.path().join("m/model.json")).unwrap()).unwrap();
    assert_eq!(model.dt(), DT);
    for i in 0..40 {
        // At other places than those of the log.
        let (q, v, a) = ([0.15 * f64::from(i) - 3.0, 0.3 - 0.1 * f64::from(i)], [2.0, -1.5], [0.1 * f64::from(i), 3.0]);
        let found = model.inverse_dynamics(&[q, v].concat(), &[v, a].concat()).unwrap();
        for (found, expected) in found.iter().zip(torques(q, v, a)) {
            assert!((found - expected).abs() < 1e-10, "{found} {expected}");
        }
    }
}

#[test]
fn accelerations_that_nothing_explains_are_told_and_not_used() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Seed::new(3).stream("log", 0);
    let mut text = "t,th,w,u,acc\n".to_owned();
    for line in super::rows(0.4, 40, |i| 0.05 * i as f64).lines() {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let acceleration = 15.0 * values[1].sin() + 3.0 * values[3] + 0.2 * (rng.random::<f64>() - 0.5);
        writeln!(text, "{line},{acceleration}").unwrap();
    }
    fs::write(folder.path().join("log.csv"), text).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(folder.path(), &["identify", "log.csv", "--strict", "--no-report"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("acc is used as the measured derivative of w"), "{stdout}");
    assert!(stdout.contains("the measured derivatives are not used"), "{stdout}");
    assert!(stdout.contains("15 sin th + 3 u") || stdout.contains("3 u + 15 sin th"), "{stdout}");
}

#[test]
fn derivatives_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("arm.csv"), log(30)).unwrap();
    let refused = |derivatives: &str, expected: &str| {
        let (code, _, said) = parts(&sindyna(folder.path(), &["identify", "arm.csv", "--derivatives", derivatives]));
        assert_eq!(code, 2, "{said}");
        assert!(said.contains(expected), "{said}");
    };
    refused("ddq1=dq1", "no column is the derivative of `dq2`");
    refused("ddq1=q1,ddq2=dq2", "`ddq1` cannot be the derivative of `q1`, whose rate is the state `dq1`");
    refused("ddq1=dq1,ddq2=dq1", "contradicts");
    refused("ddq9=dq1,ddq2=dq2", "ddq9");
    refused("ddq1", "COLUMN=STATE");
}
