//! Task files: any MuJoCo model as a task. MuJoCo comes from the `.venv` that `scripts/mujoco_install` makes, or from
//! the virtual environment `SINDYNA_MUJOCO_VENV`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{command, json, parts};

fn repository() -> PathBuf {
    std::path::absolute(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).unwrap()
}

/// Exit code, stdout and stderr of `sindyna` with `args`, on the MuJoCo of the tests.
fn sindyna(directory: &Path, args: &[&str]) -> (i32, String, String) {
    let venv = std::env::var_os("SINDYNA_MUJOCO_VENV").map_or_else(|| repository().join(".venv"), PathBuf::from);
    let mut command = command(directory, args);
    command.env("VIRTUAL_ENV", std::path::absolute(venv).unwrap()).env_remove("MUJOCO_LIB").env_remove("MUJOCO_DIR");
    parts(&command.output().expect("the binary was built"))
}

/// The example's task file with `from` replaced by `to`, next to its model in `directory`.
fn slider_with(directory: &Path, from: &str, to: &str) {
    let example = repository().join("examples/slider");
    let text = fs::read_to_string(example.join("slider.toml")).unwrap();
    assert!(text.contains(from), "the example has no `{from}`");
    fs::write(directory.join("task.toml"), text.replace(from, to)).unwrap();
    fs::copy(example.join("cart.xml"), directory.join("cart.xml")).unwrap();
}

#[test]
fn the_example_is_solved_and_its_record_stands_alone() {
    let temp = tempfile::tempdir().unwrap();
    slider_with(temp.path(), "max_steps = 100", "max_steps = 100");
    let args = ["train", "--task-file", "task.toml", "--max-updates", "4000", "--episodes", "20", "--quiet"];
    let (code, stdout, stderr) = sindyna(temp.path(), &args);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains(": solved (≥ −2)"), "{stdout}");
    assert!(
        stdout.starts_with("identified\n") && !stdout.contains("ground truth"),
        "nobody knows its true equations: {stdout}"
    );

    let run = temp.path().join("runs/cart-on-a-rail-seed0");
    let summary = json(&run.join("summary.json"));
    assert_eq!(summary["real_steps"], 10);
    // MuJoCo takes five semi-implicit steps with implicit damping: v' = q (v + h u), with h = 0.01 s and q = 1/(1 + 0.3 h), and x' = x + h v'. So
    // (v' − v)/h = ((q − 1)/h) v + q u.
    let stepping = &summary["identification"]["stepping"];
    assert_eq!((&stepping["scheme"], &stepping["substeps"]), (&"semi-implicit-euler".into(), &5.into()));
    let q = 1.0 / 1.003;
    for summand in summary["identification"]["coefficients"][1].as_array().unwrap() {
        let truth = if summand["term"] == "v" { (q - 1.0) / 0.01 } else { q };
        let found = summand["coefficient"].as_f64().unwrap();
        assert!((found / truth - 1.0).abs() < 1e-9, "{summand} is not {truth}");
    }
    assert_eq!(summary["identification"]["nonzero"], 2, "v and u");

    // The originals are not needed any more.
    fs::remove_file(temp.path().join("task.toml")).unwrap();
    fs::remove_file(temp.path().join("cart.xml")).unwrap();
    let (code, stdout, stderr) = sindyna(temp.path(), &["evaluate", run.to_str().unwrap(), "--returns"]);
    assert_eq!(code, 0, "{stderr}");
    let returns: Vec<f64> = stdout.lines().filter_map(|l| l.parse().ok()).collect();
    let recorded: Vec<f64> =
        summary["evaluation"]["returns"].as_array().unwrap().iter().map(|r| r.as_f64().unwrap()).collect();
    assert_eq!(returns, recorded);

    let config = run.join("config.toml");
    let args = ["train", "--config", config.to_str().unwrap(), "--out", "again", "--quiet"];
    assert_eq!(sindyna(temp.path(), &args).0, 0);
    for name in ["config.toml", "task.toml", "model.xml", "rollout.csv", "policy.safetensors", "summary.json"] {
        let bytes = |directory: &Path| fs::read(directory.join(name)).unwrap();
        assert_eq!(bytes(&run), bytes(&temp.path().join("again")), "{name}");
    }
}

#[test]
fn an_arm_goes_to_targets_that_are_drawn_and_sees_how_far_they_are() {
    let (temp, example) = (tempfile::tempdir().unwrap(), repository().join("examples/arm"));
    let task = example.join("arm.toml");
    let args = ["train", "--task-file", task.to_str().unwrap(), "--real-steps", "50", "--episodes", "20", "--quiet"];
    let (code, stdout, stderr) = sindyna(temp.path(), &args);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("all residuals are at the level of rounding"), "{stdout}");
    let run = temp.path().join("runs/arm-seed0");
    let summary = json(&run.join("summary.json"));
    assert_eq!(summary["real_steps"], 50);
    let returns = summary["evaluation"]["returns"].as_array().unwrap();
    let mean = returns.iter().map(|r| r.as_f64().unwrap()).sum::<f64>() / returns.len() as f64;
    // Zero torque earns less than −200.
    assert!(mean > -130.0, "{mean}");
    // What was drawn differs between episodes and never within one; the stop of the wrist is its bound.
    let rollout = fs::read_to_string(run.join("rollout.csv")).unwrap();
    let header: Vec<&str> = rollout.lines().next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let (episode, goal, wrist) = (column("trajectory"), column("goal"), column("b"));
    let mut goals: Vec<(String, String)> = Vec::new();
    for cells in rollout.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>()) {
        goals.push((cells[episode].into(), cells[goal].into()));
        assert!(cells[wrist].parse::<f64>().unwrap().abs() < 2.8);
    }
    goals.dedup();
    let episodes: Vec<&String> = goals.iter().map(|(episode, _)| episode).collect();
    assert!(goals.len() > 1 && episodes.windows(2).all(|pair| pair[0] != pair[1]), "{goals:?}");
    let (code, stdout, stderr) = sindyna(temp.path(), &["evaluate", run.to_str().unwrap()]);
    assert_eq!(code, 0, "{stdout}{stderr}");
}

#[test]
fn a_turning_joint_in_several_files_is_learned_from_cosine_and_sine() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(
        temp.path().join("rod.xml"),
        r#"<mujocoinclude><body><joint name="pivot" type="hinge" axis="0 1 0"/>
            <geom type="capsule" fromto="0 0 0 0 0 1" size="0.05" mass="1"/></body></mujocoinclude>"#,
    )
    .unwrap();
    fs::write(
        temp.path().join("pendulum.xml"),
        r#"<mujoco><option timestep="0.01"/><worldbody><include file="rod.xml"/></worldbody>
            <actuator><motor joint="pivot" gear="2"/></actuator></mujoco>"#,
    )
    .unwrap();
    fs::write(
        temp.path().join("swing.toml"),
        r#"
            name = "swing"
            model = "pendulum.xml"
            frame_skip = 5
            max_steps = 50
            [[state]]
            name = "θ"
            kind = "angle"
            start = [-3.14, 3.14]
            [[state]]
            name = "ω"
            scale = 8.0
            rate_of = "θ"
            [[control]]
            name = "u"
            low = -1.0
            high = 1.0
            [task]
            reward = "cos(next_θ) - 0.01*ω² - 0.001*u²"
            terminated = "next_ω > 50 or next_ω < -50"
        "#,
    )
    .unwrap();
    let args = ["train", "swing", "--task-file", "swing.toml", "--max-updates", "1000", "--episodes", "5", "--quiet"];
    let (code, stdout, stderr) = sindyna(temp.path(), &[&args[..], &["--out", "run"]].concat());
    assert_eq!(code, 0, "without solved_at no target is missed: {stdout}{stderr}");
    let header = fs::read_to_string(temp.path().join("run/rollout.csv")).unwrap();
    assert!(header.lines().next().unwrap().contains("cos θ"), "{header}");
    assert!(stdout.contains("sin θ"), "{stdout}");
    // The model needs rod.xml, which the record does not hold: it names the original.
    assert_eq!(sindyna(temp.path(), &["evaluate", "run"]).0, 0);
}

#[test]
fn a_wrong_file_is_refused_with_what_is_wrong() {
    for (from, to, says) in [
        ("frame_skip", "fram_skip", &["unknown field `fram_skip`", "frame_skip", "line 4"][..]),
        ("frame_skip = 5", "frame_skip = 0", &["frame_skip must be between 1 and 100000, got 0"]),
        ("frame_skip = 5", "frame_skip = 9223372036854775807", &["frame_skip must be between 1 and 100000"]),
        ("max_steps = 100", "max_steps = 1000000000000", &["max_steps must be between 1 and 10000000"]),
        ("frame_skip = 5", "frame_skip = \"5\"", &["frame_skip", "invalid type"]),
        ("max_steps = 100", "", &["missing field `max_steps`"]),
        ("cart.xml", "wagon.xml", &["cannot read its model wagon.xml"]),
        ("cart.xml", "task.toml", &["MuJoCo cannot use task.toml"]),
        ("cart-on-a-rail", "../cart", &["name must be letters", "`../cart`"]),
        ("rate_of = \"x\"", "rate_of = \"y\"", &["state `v`", "no state named `y`", "known: x, v"]),
        ("start = [-0.5, 0.5]", "start = [0.5, -0.5]", &["state `x`", "[0.5, -0.5]"]),
        ("start = [-0.5, 0.5]", "start = [-1e308, 1e308]", &["state `x`: start must be at most 1e150", "1e308"]),
        ("start = [-0.5, 0.5]", "bounds = [-1e308, 1e308]", &["state `x`: bounds must be at most 1e150"]),
        ("unit = \"m\"", "scale = 1e308", &["state `x`: scale must be at most 1e150 in magnitude, got 1e308"]),
        ("low = -1.0", "low = -1e308", &["control `u`: low and high must be at most 1e150"]),
        ("unit = \"m\"", "rate_of = \"v\"", &["the rates of states form a circle at `v`"]),
        ("unit = \"m\"", "scale = 0.0", &["state `x`", "scale", "> 0"]),
        ("unit = \"m\"", "kind = \"corner\"", &["unknown variant `corner`", "`angle`"]),
        ("low = -1.0", "low = 2.0", &["control `u`", "low must be below high"]),
        ("name = \"u\"", "name = \"v\"", &["the name `v` is used twice"]),
        ("name = \"u\"", "name = \"2u\"", &["`2u` is not a valid name"]),
        ("0.001*u^2", "0.001*w^2", &["task.reward", "no variable named `w`", "x, v, u, next_x, next_v"]),
        ("0.001*u^2", "sqrt(x)", &["task.reward", "NaN", "x = -"]),
        ("next_x", "x", &["task.terminated", "no variable named `x`", "next_x, next_v"]),
        ("> 0.9", "", &["task.terminated", "0 comparisons"]),
        ("max_steps", "observation = [\"x\"]\nmax_steps", &["observation does not show state `v`"]),
        ("max_steps", "observation = [\"x\", \"cos y\"]\nmax_steps", &["no state named `y`"]),
        ("[[control]]", "[[state]]\nname = \"y\"\n[[control]]", &["1 positions and 1 velocities", "got 3"]),
        ("[task]", "[[control]]\nname = \"w\"\nlow = 0\nhigh = 1\n[task]", &["1 actuators", "got 2"]),
    ] {
        let temp = tempfile::tempdir().unwrap();
        slider_with(temp.path(), from, to);
        let (code, stdout, stderr) = sindyna(temp.path(), &["train", "--task-file", "task.toml"]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{to}: {stderr}");
        for part in says.iter().chain(&["error: task file task.toml: "]) {
            assert!(stderr.contains(part), "{to}: `{part}` is missing in\n{stderr}");
        }
        assert!(!temp.path().join("runs").exists(), "{to}: nothing is begun");
    }
}

#[test]
fn every_system_of_the_examples_can_be_begun_with() {
    let temp = tempfile::tempdir().unwrap();
    let mut systems = 0;
    for file in fs::read_dir(repository().join("examples/systems")).unwrap() {
        let file = file.unwrap().path();
        if file.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        systems += 1;
        let args = ["--max-updates", "250", "--episodes", "2", "--max-real-steps", "10", "--no-report", "--quiet"];
        let args = [&["train", "--task-file", file.to_str().unwrap()], &args[..]].concat();
        let (code, stdout, stderr) = sindyna(temp.path(), &args);
        assert!(code == 0 && stderr.is_empty(), "{}: {stdout}{stderr}", file.display());
    }
    assert_eq!(systems, 12);
}

#[test]
fn a_model_that_leaves_the_finite_rewards_is_no_fault_of_the_task() {
    let temp = tempfile::tempdir().unwrap();
    // The reward is a number up to x = 0.45: the policy stays below, rollouts in the model begin beyond.
    let text = "name = 'near'\ndt = 0.05\nmax_steps = 20\n[equations]\nv = 'u'\n[[state]]\nname = 'x'\nstart = [-0.2, 0.2]\n\
                [[state]]\nname = 'v'\nrate_of = 'x'\n[[control]]\nname = 'u'\nlow = -1.0\nhigh = 1.0\n\
                [task]\nreward = '-next_x^2 + 1e-9*log(0.45 - next_x)'\n";
    fs::write(temp.path().join("near.toml"), text).unwrap();
    let args = ["train", "--task-file", "near.toml", "--max-updates", "2000", "--episodes", "5", "--quiet"];
    let (code, stdout, stderr) = sindyna(temp.path(), &args);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let summary = json(&temp.path().join("runs/near-seed0/summary.json"));
    assert!(summary["training"]["diverged"].as_u64().unwrap() > 0, "{summary}");
}

#[test]
fn a_reward_that_is_no_number_later_is_told_with_where() {
    let temp = tempfile::tempdir().unwrap();
    // Fine wherever an episode starts, but not at a cart that has begun to move to the left.
    slider_with(temp.path(), "0.001*u^2", "log(1 + 1e6*v)");
    let (_, told, _) = sindyna(temp.path(), &["train", "--task-file", "task.toml", "--quiet", "--json"]);
    assert!(told.contains("\"kind\": \"system\"") || told.contains("\"kind\":\"system\""), "{told}");
    let (code, _, stderr) = sindyna(temp.path(), &["train", "--task-file", "task.toml", "--quiet"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("limit the formula"), "{stderr}");
    assert!(stderr.contains("the reward of `cart-on-a-rail`") && stderr.contains("is NaN at x = "), "{stderr}");
}

#[test]
fn options_that_do_not_go_with_a_task_file_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    slider_with(temp.path(), "max_steps", "max_steps");
    for (args, says) in [
        (&["train", "--task-file", "none.toml"][..], "cannot read none.toml"),
        (&["train", "pendulum", "--task-file", "task.toml"], "task.toml is for `cart-on-a-rail`, not for `pendulum`"),
        (&["train", "--task-file", "task.toml", "--simulator", "native"], "simulator must be `mujoco` for task.toml"),
        (&["train", "--task-file", "task.toml", "--set", "task=pendulum"], "`task` cannot be set"),
        (&["train", "--task-file", "task.toml", "--config", "config.toml"], "cannot be used with"),
    ] {
        let (code, _, stderr) = sindyna(temp.path(), args);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(says), "{args:?}: {stderr}");
    }
}

/// The first row of a run's real data: trajectory, time, observation, ...
fn first_row(run: &Path) -> Vec<f64> {
    let text = fs::read_to_string(run.join("rollout.csv")).unwrap();
    text.lines().nth(1).unwrap().split(',').map(|v| v.parse().unwrap()).collect()
}

#[test]
fn sensors_in_mujoco_are_noisy_too() {
    let temp = tempfile::tempdir().unwrap();
    slider_with(temp.path(), "[-0.5, 0.5]", "[0.25, 0.25]");
    for (noise, out) in [("0", "clean"), ("0.1", "noisy")] {
        let args =
            ["train", "--task-file", "task.toml", "--noise", noise, "--max-updates", "1", "--out", out, "--quiet"];
        let (code, _, stderr) = sindyna(temp.path(), &args);
        assert_eq!(code, 1, "{stderr}");
    }
    assert_eq!(first_row(&temp.path().join("clean"))[2..4], [0.25, 0.0]);
    let noisy = &first_row(&temp.path().join("noisy"))[2..4];
    assert!(noisy[0] != 0.25 && noisy[1] != 0.0 && noisy[0].abs() < 1.0, "{noisy:?}");

    // Our own inverted pendulum and MuJoCo's begin in the same state and draw the same noise.
    for simulator in ["native", "mujoco"] {
        let args = ["train", "inverted-pendulum", "--noise", "0.1", "--simulator", simulator];
        let args = [&args[..], &["--max-updates", "1", "--out", simulator, "--quiet"]].concat();
        let (code, _, stderr) = sindyna(temp.path(), &args);
        assert_eq!(code, 1, "{stderr}");
    }
    let [ours, theirs] = ["native", "mujoco"].map(|run| first_row(&temp.path().join(run)));
    assert_eq!(ours[2..6], theirs[2..6]);
    // Start states lie within ±0.01, the noise on x is 0.1 m.
    assert!(ours[2].abs() > 0.01 || ours[4].abs() > 0.01, "{ours:?}");
}
