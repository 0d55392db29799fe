//! Logs with ordinary names and nothing declared.

use std::fmt::Write as _;
use std::fs;

use rand::RngExt as _;
use sindyna_core::{Dynamics as _, Held, Scheme, Seed, VectorField};

use super::common::{json, parts, sindyna};

const DT: f64 = 0.01;

/// Moment of inertia of the pendulum about its joint.
const POLE: f64 = 0.0011 + 0.13 * 0.15 * 0.15;

/// A rotary pendulum: arm, pendulum, and their rates, under a torque.
struct Furuta;

impl VectorField for Furuta {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        const ARM: f64 = 0.008 + 0.13 * 0.2 * 0.2;
        const BOTH: f64 = 0.13 * 0.2 * 0.15;
        let ((sin, cos), v, w) = (x[1].sin_cos(), x[2], x[3]);
        let swing = 0.13 * 0.15 * 0.15 * sin * cos;
        let (m11, m12) = (ARM + 0.13 * 0.15 * 0.15 * sin * sin, BOTH * cos);
        let first = u[0] - 0.004 * v - 2.0 * swing * v * w + BOTH * sin * w * w;
        let second = swing * v * v - 0.13 * 9.81 * 0.15 * sin - 0.0003 * w;
        let determinant = m11 * POLE - m12 * m12;
        x_dot[..2].copy_from_slice(&[v, w]);
        x_dot[2] = (POLE * first - m12 * second) / determinant;
        x_dot[3] = (m11 * second - m12 * first) / determinant;
    }
}

#[test]
fn angles_of_a_rotary_pendulum_are_known_by_their_names() {
    let mut rng = Seed::new(11).stream("torque", 0);
    let plant = Held::new(Furuta, Scheme::Rk4 { substeps: 20 }, DT);
    let (mut text, mut x, mut torque) =
        ("t,phi,theta,phi_dot,theta_dot,torque\n".to_owned(), [0.2, 1.0, 0.0, 0.0], 0.0);
    for row in 0..500 {
        if row % 8 == 0 {
            torque = 0.12 * (rng.random::<f64>() - 0.5);
        }
        let [phi, th, v, w] = x;
        writeln!(text, "{},{phi:.9},{th:.9},{v:.9},{w:.9},{torque}", DT * f64::from(row)).unwrap();
        let before = x;
        plant.step(&before, &[torque], &mut rng, &mut x).unwrap();
    }
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), text).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--no-report"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("theta is used as an angle"), "{stdout}");
    let account = json(&temp.path().join("models/log/identify.json"));
    let equations = account["equations"].as_array().unwrap();
    let own = equations.iter().find(|e| e["state"] == "theta_dot").unwrap()["terms"].as_array().unwrap();
    let gravity = own.iter().find(|t| t["term"] == "sin theta").unwrap_or_else(|| panic!("{own:?}"));
    let (found, expected) = (gravity["coefficient"].as_f64().unwrap(), -0.13 * 9.81 * 0.15 / POLE);
    assert!((found / expected - 1.0).abs() < 1e-4, "{found}, not {expected}: {stdout}");
}
