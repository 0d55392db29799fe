//! Rewards of the task files in `examples/planning` beside those of the packages they come from, on recorded steps.

use std::path::Path;

use serde_json::Value;

use super::*;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Largest difference of rewards, and how many steps there are.
fn worst(name: &str) -> (f64, usize) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("../../examples/planning").join(format!("{name}.toml"));
    // Rewards need no simulator.
    let text = fs::read_to_string(&path).unwrap();
    let text: String = text
        .lines()
        .filter(|l| !l.starts_with("model") && !l.starts_with("frame_skip"))
        .flat_map(|l| [l, "\n"])
        .collect();
    let task = TaskFile::read(&path, text, Some(0.01)).unwrap().task();
    let golden = fs::read_to_string(root.join("tests/golden/planning_tasks.json")).unwrap();
    let golden: Value = serde_json::from_str(&golden).unwrap();
    let rows = golden[name].as_array().unwrap();
    let difference = |row: &Value| {
        let [x, u, next, reward] = [0, 1, 2, 3].map(|i| numbers(&row[i]));
        (task.reward(&x, &u, &u, &next) - reward[0]).abs()
    };
    (rows.iter().map(difference).fold(0.0, f64::max), rows.len())
}

#[test]
fn rewards_are_those_of_dm_control() {
    let names = [
        "acrobot_swingup",
        "pendulum_swingup",
        "cartpole_swingup",
        "cartpole_swingup_sparse",
        "reacher_easy",
        "reacher_hard",
        "cartpole_balance",
        "cartpole_two_poles",
        "cartpole_three_poles",
        "point_mass",
    ];
    for name in names {
        let (difference, steps) = worst(name);
        assert!(steps >= 40 && difference <= 1e-12, "{name}: {difference} in {steps} steps");
    }
}

#[test]
fn the_reward_of_the_double_pendulum_is_gymnasiums_but_for_where_it_sees_the_tip() {
    // Gymnasium reads the tip where the last stage of the Runge–Kutta step left it, not where the step ends.
    let (difference, steps) = worst("inverted_double_pendulum");
    assert!(steps > 30 && difference < 1e-4, "{difference} in {steps} steps");
}

#[test]
fn the_reward_of_the_reacher_is_gymnasiums_but_for_where_it_sees_the_finger() {
    // It is read where the last stage of the Runge–Kutta step left it, too.
    let (difference, steps) = worst("reacher_v5");
    assert!(steps == 40 && difference < 1e-5, "{difference} in {steps} steps");
}
