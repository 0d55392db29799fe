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
    let coefficient = |name: &str| {
        let term = terms.iter().find(|t| t["term"] == name).unwrap_or_else(|| panic!("no {name}: {stdout}"));
        term["coefficient"].as_f64().unwrap()
    };
    // Those of a Duffing oscillator alone, by an output-error fit to other rows with inputs that are smooth between them. Beside y³ there
    // are small terms here that bend like it (y²·u, ẏ²·y).
    for (name, fitted, within) in
        [("y", -1.842e5, 0.01), ("y_dot", -41.9, 0.1), ("y³", -7.34e5, 0.15), ("u", 1.866e5, 0.01)]
    {
        assert!((coefficient(name) / fitted - 1.0).abs() < within, "{name}: {}", coefficient(name));
    }
    let predictions = account["held_out"]["predictions"].as_array().unwrap();
    let free = predictions.iter().find(|p| p["horizon"].is_null()).unwrap();
    let error = free["rmse"][0][1].as_f64().unwrap();
    assert!(error < LARGEST, "{error} V");
}
