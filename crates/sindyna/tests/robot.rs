//! `sindyna identify --urdf` and `--mjcf`, as the user sees them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{json, parts, sindyna};
use sindyna_bodies::{Urdf, forces};

fn example(name: &str) -> String {
    fs::read_to_string(path(name)).unwrap()
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/robots").join(name)
}

/// A value of `parameters.json`.
fn value(results: &serde_json::Value, list: &str, key: &str, name: &str) -> f64 {
    let all = results[list].as_array().unwrap();
    let found = all.iter().find(|one| one[key].as_str().unwrap().starts_with(name));
    found.unwrap_or_else(|| panic!("no {name}"))["value"].as_f64().unwrap()
}

#[test]
fn the_example_arm_gets_its_true_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let (log, urdf) = (path("arm.csv"), path("arm.urdf"));
    let arguments = ["identify", log.to_str().unwrap(), "--urdf", urdf.to_str().unwrap(), "--out", "m"];
    let (code, stdout, stderr) = parts(&sindyna(folder.path(), &arguments));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("lift: lift_position, lift_velocity, lift_torque"), "{stdout}");
    let results = json(&folder.path().join("m/parameters.json"));
    // What scripts/robot_log.py simulated.
    let base = |name: &str| value(&results, "base_parameters", "combination", name);
    for (name, truth, tolerance) in [
        ("mx(beam) + 0.4 m(forearm)", 2.6 * 0.22 + 0.4 * 1.1, 2e-3),
        ("mx(forearm)", 1.1 * 0.14, 2e-3),
        ("damping(turn)", 0.5, 1e-2),
        ("damping(lift)", 0.8, 1e-2),
        ("damping(elbow)", 0.3, 1e-2),
    ] {
        assert!((base(name) / truth - 1.0).abs() < tolerance, "{name}: {} {truth}", base(name));
    }
    let (predicted, of_file) = (&results["prediction"]["rmse"], &results["prediction"]["rmse_of_file"]);
    for joint in 0..3 {
        assert!(predicted[joint].as_f64().unwrap() < 0.02 * of_file[joint].as_f64().unwrap(), "{results}");
    }
    // The file that was written holds the parameters that were told.
    let tree = Urdf::parse(&fs::read_to_string(folder.path().join("m/arm.urdf")).unwrap()).unwrap().tree;
    let told: Vec<f64> =
        results["parameters"].as_array().unwrap().iter().map(|p| p["value"].as_f64().unwrap()).collect();
    let state = (&[0.3, 0.2, 1.0][..], &[1.0, -2.0, 0.5][..], &[0.0; 3][..]);
    for (one, other) in forces(&tree, &told, state, true).iter().zip(forces(&tree, &tree.parameters(), state, true)) {
        assert!((one - other).abs() < 1e-6, "{one} {other}");
    }
}

#[test]
fn columns_that_fit_no_joint_are_told_with_what_helps() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("arm.urdf"), example("arm.urdf")).unwrap();
    let refused = |log: &str, expected: &[&str]| {
        fs::write(folder.path().join("log.csv"), log).unwrap();
        let (code, _, said) = parts(&sindyna(folder.path(), &["identify", "log.csv", "--urdf", "arm.urdf"]));
        assert_eq!(code, 2, "{said}");
        assert!(expected.iter().all(|part| said.contains(part)), "{said}");
    };
    let text = example("arm.csv");
    let without = |columns: &[usize]| -> String {
        let kept = |line: &str| {
            let cells = line.split(',').enumerate().filter(|(i, _)| !columns.contains(i)).map(|(_, cell)| cell);
            cells.collect::<Vec<_>>().join(",") + "\n"
        };
        text.lines().map(kept).collect()
    };
    refused(
        &without(&[3, 6]),
        &["the robot has 3 joints, the log 2 positions with a rate", "joints: turn, lift, elbow"],
    );
    let renamed = without(&[9]).replace("turn_torque", "tau1").replace("lift_torque", "tau2");
    refused(&renamed, &["2 inputs for 3 driven joints", "turn, lift, elbow"]);
    let short: String = text.lines().take(20).map(|line| line.to_owned() + "\n").collect();
    refused(&short, &["rows are too few for", "use a longer log"]);
}

#[test]
fn another_log_of_the_robot_is_predicted() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("arm.urdf"), example("arm.urdf")).unwrap();
    let text = example("arm.csv");
    let lines: Vec<&str> = text.lines().collect();
    let part = |rows: &[&str]| [&lines[..1], rows].concat().join("\n") + "\n";
    fs::write(folder.path().join("first.csv"), part(&lines[1..400])).unwrap();
    fs::write(folder.path().join("last.csv"), part(&lines[400..])).unwrap();
    let arguments = ["identify", "first.csv", "--urdf", "arm.urdf", "--holdout", "last.csv", "--out", "m"];
    let (code, stdout, stderr) = parts(&sindyna(folder.path(), &arguments));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("prediction of the logs held out"), "{stdout}");
    let results = json(&folder.path().join("m/parameters.json"));
    for joint in 0..3 {
        // The noise of the log is 0.002 of each spread.
        assert!(results["held_out"]["rmse"][joint].as_f64().unwrap() < 0.005, "{results}");
    }
    let arguments = ["identify", "first.csv", "--urdf", "arm.urdf", "--holdout", "0.2"];
    let (code, _, said) = parts(&sindyna(folder.path(), &arguments));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("the last 30 % are held out already"), "{said}");
}

#[test]
fn files_that_are_no_robot_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.csv"), example("arm.csv")).unwrap();
    let refused = |option: &str, text: &str, expected: &str| {
        fs::write(folder.path().join("robot.xml"), text).unwrap();
        let (code, _, said) = parts(&sindyna(folder.path(), &["identify", "log.csv", option, "robot.xml"]));
        assert_eq!(code, 2, "{said}");
        assert!(said.contains(expected), "{said}");
    };
    refused("--urdf", "<mujoco/>", "the outermost element is <mujoco>, not <robot>");
    refused("--mjcf", &example("arm.urdf"), "the outermost element is <robot>, not <mujoco>");
    refused("--urdf", "no XML at all", "the file is no XML");
    refused("--urdf", &example("arm.urdf").replace("continuous", "planar"), "hinges and slides are supported");
    let (code, _, said) = parts(&sindyna(folder.path(), &["identify", "log.csv", "--urdf", "none.urdf"]));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("none.urdf"), "{said}");
    let (code, _, said) =
        parts(&sindyna(folder.path(), &["identify", "log.csv", "--urdf", "robot.xml", "--library", "paper"]));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("cannot be used with"), "{said}");
}
