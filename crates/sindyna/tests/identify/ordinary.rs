//! Logs with ordinary names and nothing declared.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use rand::RngExt as _;
use sindyna_core::Seed;

use super::common::{json, parts, sindyna};

const DT: f64 = 0.01;

/// `x` after [`DT`] at the rates `of`, in 20 steps of Runge–Kutta.
fn moved<const N: usize>(mut x: [f64; N], of: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let h = DT / 20.0;
    for _ in 0..20 {
        let by = |part: f64, k: [f64; N]| std::array::from_fn(|j| x[j] + part * h * k[j]);
        let k1 = of(x);
        let k2 = of(by(0.5, k1));
        let k3 = of(by(0.5, k2));
        let k4 = of(by(1.0, k3));
        x = std::array::from_fn(|j| x[j] + h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]));
    }
    x
}

/// Rates of a rotary pendulum: of the arm, the pendulum, and their rates, under a torque.
fn furuta([_, th, v, w]: [f64; 4], torque: f64) -> [f64; 4] {
    const ARM: f64 = 0.008 + 0.13 * 0.2 * 0.2;
    const POLE: f64 = 0.0011 + 0.13 * 0.15 * 0.15;
    const BOTH: f64 = 0.13 * 0.2 * 0.15;
    let (sin, cos) = th.sin_cos();
    let (m11, m12) = (ARM + 0.13 * 0.15 * 0.15 * sin * sin, BOTH * cos);
    let first = torque - 0.004 * v - 2.0 * 0.13 * 0.15 * 0.15 * sin * cos * v * w + BOTH * sin * w * w;
    let second = 0.13 * 0.15 * 0.15 * sin * cos * v * v - 0.13 * 9.81 * 0.15 * sin - 0.0003 * w;
    let determinant = m11 * POLE - m12 * m12;
    [v, w, (POLE * first - m12 * second) / determinant, (m11 * second - m12 * first) / determinant]
}

/// The account of `identify` of `text`, what it printed, and whether it called the equations adequate.
fn identified(folder: &Path, text: &str) -> (serde_json::Value, String) {
    fs::write(folder.join("log.csv"), text).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(folder, &["identify", "log.csv", "--no-report"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    (json(&folder.join("models/log/identify.json")), stdout)
}

/// The coefficients of the equation of `state`, by term.
fn terms(account: &serde_json::Value, state: &str) -> Vec<(String, f64)> {
    let equations = account["equations"].as_array().unwrap();
    let found = equations.iter().find(|e| e["state"] == state).unwrap()["terms"].as_array().unwrap();
    let of = |t: &serde_json::Value| (t["term"].as_str().unwrap().to_owned(), t["coefficient"].as_f64().unwrap());
    found.iter().map(of).collect()
}

#[test]
fn angles_of_a_rotary_pendulum_are_known_by_their_names() {
    let mut rng = Seed::new(11).stream("torque", 0);
    let (mut text, mut x, mut torque) =
        ("t,phi,theta,phi_dot,theta_dot,torque\n".to_owned(), [0.2, 1.0, 0.0, 0.0], 0.0);
    for row in 0..500 {
        if row % 8 == 0 {
            torque = 0.12 * (rng.random::<f64>() - 0.5);
        }
        let [phi, th, v, w] = x;
        writeln!(text, "{},{phi:.9},{th:.9},{v:.9},{w:.9},{torque}", DT * f64::from(row)).unwrap();
        x = moved(x, |x| furuta(x, torque));
    }
    let temp = tempfile::tempdir().unwrap();
    let (account, stdout) = identified(temp.path(), &text);
    assert!(stdout.contains("theta is used as an angle"), "{stdout}");
    let found = terms(&account, "theta_dot");
    let gravity = found.iter().find(|(term, _)| term == "sin theta").unwrap_or_else(|| panic!("{found:?}")).1;
    let expected = -0.13 * 9.81 * 0.15 / (0.0011 + 0.13 * 0.15 * 0.15);
    assert!((gravity / expected - 1.0).abs() < 1e-4, "{gravity}, not {expected}: {stdout}");
}
