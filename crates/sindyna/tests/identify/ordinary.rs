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

/// A planar quadrotor: place, pitch, and their rates, under two rotors.
struct Quadrotor;

impl VectorField for Quadrotor {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        const MASS: f64 = 0.5;
        let (sin, cos) = x[2].sin_cos();
        x_dot[..3].copy_from_slice(&x[3..]);
        x_dot[3] = -(u[0] + u[1]) * sin / MASS;
        x_dot[4] = (u[0] + u[1]) * cos / MASS - 9.81;
        x_dot[5] = 37.5 * (u[0] - u[1]);
    }
}

/// What regulates the quadrotor, with a random part.
fn thrusts(x: &[f64; 6], t: f64, random: [f64; 2]) -> [f64; 2] {
    let tilt = (0.75 * (x[0] - (0.7 * t).sin()) + 0.9 * x[3]).clamp(-0.8, 0.8);
    let force = 0.5 * (9.81 + 4.0 * ((0.9 * t).sin() - x[1]) - 3.0 * x[4]);
    let turn = 0.004 * (60.0 * (tilt - x[2]) - 12.0 * x[5]) / 0.15;
    [0.5 * (force + turn) + 0.3 * random[0], 0.5 * (force - turn) + 0.3 * random[1]]
}

#[test]
fn a_quadrotor_written_with_twelve_digits_is_exact() {
    let mut rng = Seed::new(5).stream("thrusts", 0);
    let plant = Held::new(Quadrotor, Scheme::Rk4 { substeps: 10 }, DT);
    let (mut text, mut x) = ("t,x,z,pitch,vx,vz,pitch_rate,f1,f2\n".to_owned(), [0.0; 6]);
    for row in 0..900 {
        let t = DT * f64::from(row);
        let written = |v: f64| format!("{v:.11e}");
        let u = thrusts(&x, t, [(); 2].map(|()| rng.random::<f64>() - 0.5));
        let cells: Vec<String> = x.iter().chain(&u).map(|v| written(*v)).collect();
        writeln!(text, "{t},{}", cells.join(",")).unwrap();
        let before = x;
        plant.step(&before, &u, &mut rng, &mut x).unwrap();
    }
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), text).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--no-report", "--strict"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("states were written with up to 12 digits"), "{stdout}");
    for equation in [
        "dvx/dt = \u{2212}2 f1\u{b7}sin pitch \u{2212} 2 f2\u{b7}sin pitch",
        "dvz/dt = \u{2212}9.81 + 2 f1\u{b7}cos pitch + 2 f2\u{b7}cos pitch",
        "dpitch_rate/dt = 37.5 f1 \u{2212} 37.5 f2",
    ] {
        assert!(stdout.contains(equation), "{equation} is missing: {stdout}");
    }
}

/// A unicycle.
struct Unicycle;

impl VectorField for Unicycle {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot.copy_from_slice(&[u[0] * x[2].cos(), u[0] * x[2].sin(), u[1]]);
    }
}

/// A log of a unicycle whose heading is called `heading`, with noise of so many times the standard deviation 0.01.
fn log_of_a_unicycle(heading: &str, noise: f64) -> String {
    let mut rng = Seed::new(3).stream("speeds", 0);
    let plant = Held::new(Unicycle, Scheme::Rk4 { substeps: 20 }, 0.05);
    let (mut text, mut x) = (format!("t,x,y,{heading},v,omega\n"), [0.0, 0.0, 0.2]);
    for row in 0..400 {
        let t = 0.05 * f64::from(row);
        let [a, b] = [(); 2].map(|()| rng.random::<f64>() - 0.5);
        let u = [1.0 + 0.5 * t.sin() + 0.3 * a, (1.7 * t).sin() + 0.5 * b];
        // Of twelve uniform numbers the sum has the variance one.
        let shown = x.map(|v| v + 0.01 * noise * (0..12).map(|_| rng.random::<f64>() - 0.5).sum::<f64>());
        writeln!(text, "{t},{:.9},{:.9},{:.9},{:.9},{:.9}", shown[0], shown[1], shown[2], u[0], u[1]).unwrap();
        let before = x;
        plant.step(&before, &u, &mut rng, &mut x).unwrap();
    }
    text
}

#[test]
fn the_heading_of_a_vehicle_is_an_angle_although_its_rate_is_an_input() {
    // Without a name that says so, the equations do; those of the position do not depend on it either.
    for (heading, noise) in [("theta", 0.0), ("h", 1.0)] {
        let temp = tempfile::tempdir().unwrap();
        fs::write(temp.path().join("log.csv"), log_of_a_unicycle(heading, noise)).unwrap();
        let states = format!("x,y,{heading}");
        let args = ["identify", "log.csv", "--inputs", "v,omega", "--states", &states, "--no-report", "--strict"];
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
        assert_eq!(code, 0, "{stdout}{stderr}");
        for part in [&format!("v\u{b7}cos {heading}"), &format!("v\u{b7}sin {heading}"), "omega"] {
            assert!(stdout.contains(part), "{part} is missing: {stdout}");
        }
        assert_eq!(stdout.matches("(angle)").count(), 1, "{stdout}");
    }
}
