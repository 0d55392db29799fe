//! States equal those of the same version of MuJoCo under Python, bit for bit.

#![allow(clippy::unwrap_used, reason = "a test stops at what it cannot do")]

mod common;

use common::{bits, floats};
use sindyna_core::{Environment as _, Outcome, Seed};
use sindyna_mujoco::{MujocoModel, inverted_pendulum};

const STEPS: usize = 1000;

/// Steps `name`, one of Gymnasium's models, here and in Python.
fn check(name: &str, frame_skip: usize) {
    let Some(library) = common::library() else { return };
    let lines = common::python("model_rollout.py", &[name, &frame_skip.to_string(), &STEPS.to_string()]);
    let (version, file) = lines[0].split_once(' ').expect("version and file");
    assert_eq!(library.version(), version, "Python and Rust must use one library");
    assert_eq!(lines.len(), STEPS + 2);

    let model = MujocoModel::from_file(&library, file).unwrap();
    let mut env = common::environment(&model, frame_skip);
    let mut rng = Seed::new(0).numpy();
    let start = floats(&lines[1]);
    assert_eq!(bits(&start[..model.position_dim()]), bits(&model.rest()[..model.position_dim()]));
    let control = |i: usize| (0..model.control_dim()).map(|j| (0.1 * i as f64 + j as f64).sin()).collect::<Vec<_>>();
    env.reset_to(&start, &mut rng).unwrap();
    for i in 0..50 {
        env.step(&control(i), &mut rng).unwrap();
    }
    env.reset_to(&start, &mut rng).unwrap();
    for i in 0..STEPS {
        env.step(&control(i), &mut rng).unwrap();
        assert_eq!(bits(env.state()), bits(&floats(&lines[i + 2])), "{name}, MuJoCo {version}, step {i}");
    }
}

#[test]
fn inverted_pendulum_moves_as_under_python() {
    check("inverted_pendulum", 2);
}

#[test]
fn half_cheetah_moves_as_under_python() {
    check("half_cheetah", 5);
}

#[test]
fn hopper_moves_as_under_python() {
    check("hopper", 4);
}

#[test]
fn our_inverted_pendulum_is_gymnasiums_start_states_rewards_and_ends_included() {
    let Some(library) = common::library() else { return };
    let lines = common::python("gymnasium_rollout.py", &["7", "1500"]);
    let mut env = inverted_pendulum(&library).unwrap();
    let mut rng = Seed::new(7).numpy();
    let flag = |v: f64| v > 0.5;
    let (mut resets, mut truncations) = (0, 0);
    for (i, line) in lines.iter().enumerate().skip(1) {
        let values = floats(line);
        let (step, observation) = values.split_at(values.len() - 4);
        match *step {
            [] => {
                env.reset(&mut rng).unwrap();
                resets += 1;
            }
            [action, reward, terminated, truncated] => {
                let outcome = env.step(&[action], &mut rng).unwrap();
                let recorded = Outcome { reward, terminated: flag(terminated), truncated: flag(truncated) };
                assert_eq!(outcome, recorded, "line {i}");
                truncations += usize::from(outcome.truncated);
            }
            _ => panic!("line {i} has {} values", values.len()),
        }
        assert_eq!(bits(env.observation()), bits(observation), "line {i}");
    }
    assert!(resets > 2, "{resets} resets, {truncations} truncations");
}
