//! A real circuit that is a Duffing oscillator, of which the output alone is measured.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{json, parts, sindyna};

/// Published free-run errors: 7 to 14 mV of linear models, below 0.5 mV of the best nonlinear ones.
const LARGEST: f64 = 0.5e-3;

#[test]
fn the_silverbox_is_read_as_a_duffing_oscillator() {
    let temp = tempfile::tempdir().unwrap();
    let log = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/silverbox.csv");
    let args = ["identify", log, "--holdout", "0.2", "--no-report", "--out", "silverbox"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("note: inputs are smooth between samples"), "{stdout}");
    assert!(stdout.contains("note: y_dot, the rate of y, was not measured"), "{stdout}");

    let account = json(&temp.path().join("silverbox/identify.json"));
    assert_eq!(account["intersample"], "bl");
    assert_eq!(account["explained"], false, "terms that are missing are said to be");
    let terms = account["equations"][1]["terms"].as_array().unwrap();
    let coefficient =
        |name: &str| terms.iter().find(|t| t["term"] == name).map_or(0.0, |term| term["coefficient"].as_f64().unwrap());
    // A wave may stand for a part of the spring: sin 3y = 3 y − 4.5 y³ + …
    let waves = |power: i32| (1..4).map(|k| f64::from(k).powi(power) * coefficient(&sine(k))).sum::<f64>();
    let spring = [coefficient("y") + waves(1), coefficient("y³") - waves(3) / 6.0];
    // Those of a Duffing oscillator alone, by an output-error fit to other rows with inputs that are smooth between them. Beside y³ there
    // are small terms here that bend like it (y²·u, ẏ²·y).
    for (name, found, fitted, within) in [
        ("y", spring[0], -1.842e5, 0.01),
        ("y_dot", coefficient("y_dot"), -41.9, 0.1),
        ("y³", spring[1], -7.34e5, 0.15),
        ("u", coefficient("u"), 1.866e5, 0.01),
    ] {
        assert!((found / fitted - 1.0).abs() < within, "{name}: {found}, {stdout}");
    }
    let predictions = account["held_out"]["predictions"].as_array().unwrap();
    let free = predictions.iter().find(|p| p["horizon"].is_null()).unwrap();
    let error = free["rmse"][0][1].as_f64().unwrap();
    assert!(error < LARGEST, "{error} V");
}

/// The sine of k y by name.
fn sine(k: i32) -> String {
    if k == 1 { "sin y".into() } else { format!("sin {k}y") }
}
