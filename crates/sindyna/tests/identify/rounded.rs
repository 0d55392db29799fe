//! Logs whose columns were all written with four decimals.

use std::fmt::Write as _;
use std::fs;

use rand::RngExt as _;
use sindyna_core::{Dynamics as _, Held, Scheme, Seed, VectorField};

use super::common::{json, parts, sindyna};

const DT: f64 = 0.002;

/// A motor: current and speed under a voltage.
struct Motor;

impl VectorField for Motor {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot.copy_from_slice(&[-180.0 * x[0] - 9.0 * x[1] + 150.0 * u[0], 260.0 * x[0] - 1.1 * x[1]]);
    }
}

#[test]
fn a_motor_has_no_third_state_because_its_voltage_was_rounded() {
    let mut rng = Seed::new(31).stream("voltage", 0);
    let plant = Held::new(Motor, Scheme::Rk4 { substeps: 20 }, DT);
    let (mut text, mut x, mut voltage) = ("t,current,speed,voltage\n".to_owned(), [0.0, 0.0], 0.0);
    for row in 0..900 {
        if row % 37 == 0 {
            voltage = 24.0 * (rng.random::<f64>() - 0.5);
        }
        writeln!(text, "{:.4},{:.4},{:.4},{voltage:.4}", DT * f64::from(row), x[0], x[1]).unwrap();
        let before = x;
        plant.step(&before, &[voltage], &mut rng, &mut x).unwrap();
    }
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), text).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--no-report", "--strict"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("the input `voltage` is taken as rounded"), "{stdout}");
    assert!(!stdout.contains("deviate from both neighbours"), "{stdout}");
    let account = json(&temp.path().join("models/log/identify.json"));
    let equations = account["equations"].as_array().unwrap();
    let told = |i: usize| -> Vec<(&str, f64)> {
        let terms = equations[i]["terms"].as_array().unwrap();
        terms.iter().map(|t| (t["term"].as_str().unwrap(), t["coefficient"].as_f64().unwrap())).collect()
    };
    let truth =
        [&[("current", -180.0), ("speed", -9.0), ("voltage", 150.0)][..], &[("current", 260.0), ("speed", -1.1)]];
    assert_eq!(equations.len(), truth.len(), "{stdout}");
    for (i, truth) in truth.iter().enumerate() {
        let told = told(i);
        assert_eq!(told.len(), truth.len(), "{stdout}");
        for (term, value) in *truth {
            let found = told.iter().find(|(name, _)| name == term).unwrap_or_else(|| panic!("{stdout}")).1;
            assert!((found / value - 1.0).abs() < 1e-4, "{term}: {found}, not {value}");
        }
    }
}

/// Equations with parameters inside terms are told as they were fitted, also where these are hardly known and errors of inputs that were written with six digits would move them far: coefficients
/// were moved, and the parameters not.
#[test]
fn equations_follow_the_data_as_well_as_the_fit_did() {
    let temp = tempfile::tempdir().unwrap();
    let log = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/electrode.csv");
    let args = ["identify", log, "--states", "eta", "--inputs", "i", "--no-report", "--out", "electrode"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stdout}{stderr}");
    let account = json(&temp.path().join("electrode/identify.json"));
    assert!(!account["equations"][0]["terms"].as_array().unwrap().is_empty(), "{stdout}");
    // After the header of the table: RMSE over one step.
    let row = stdout.split("prediction of").nth(1).unwrap().lines().nth(1).unwrap();
    let step: f64 = row.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!(step < 2.0 * 0.00078, "one step: {step}: {stdout}");
}
