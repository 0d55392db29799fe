//! What every environment promises, and that environments share nothing they can feel.

#![allow(clippy::unwrap_used, reason = "a test stops at what it cannot do")]

mod common;

use sindyna_core::{EnvError, Environment, Outcome, Seed};
use sindyna_mujoco::{Library, MujocoEnvironment, MujocoModel, inverted_pendulum};

const SEED: u64 = 5;

/// A push that balances for a while, as a function of what is seen and of the step number.
fn action(o: &[f64], t: usize) -> f64 {
    let push = if t % 90 > 80 { 2.0 } else { 0.1 * (t as f64).sin() };
    0.5 * o[0] + 5.0 * o[1] + 0.6 * o[2] + o[3] + push
}

/// Observations and outcomes of `steps` steps, resetting where an episode ends.
fn play(env: &mut dyn Environment, seed: u64, steps: usize) -> Vec<(Vec<u64>, Outcome)> {
    let mut rng = Seed::new(seed).numpy();
    env.reset(&mut rng).unwrap();
    let step = |t| {
        let outcome = env.step(&[action(env.observation(), t)], &mut rng).unwrap();
        let seen = common::bits(env.observation());
        if outcome.terminated || outcome.truncated {
            env.reset(&mut rng).unwrap();
        }
        (seen, outcome)
    };
    (0..steps).map(step).collect()
}

fn pendulum(library: &Library) -> MujocoEnvironment<std::sync::Arc<dyn sindyna_core::Task>> {
    inverted_pendulum(library).unwrap()
}

#[test]
fn a_step_needs_a_reset() {
    let Some(library) = common::library() else { return };
    let (mut env, mut rng) = (pendulum(&library), Seed::new(0).numpy());
    assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
    env.set_state(&[0.0; 4], &mut rng).unwrap();
    assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset), "to set a state begins no episode");
    env.reset(&mut rng).unwrap();
    while !env.step(&[3.0], &mut rng).unwrap().terminated {}
    assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
}

#[test]
fn one_seed_is_one_history() {
    let Some(library) = common::library() else { return };
    let mut env = pendulum(&library);
    let first = play(&mut env, SEED, 500);
    assert!(first.iter().any(|(_, outcome)| outcome.terminated));
    assert_eq!(first, play(&mut env, SEED, 500), "nothing is left of an earlier episode");
    assert_eq!(first, play(&mut pendulum(&library), SEED, 500));
    assert_ne!(first[0], play(&mut env, SEED + 1, 1)[0]);
}

#[test]
fn the_pole_terminates_and_the_clock_truncates() {
    let Some(library) = common::library() else { return };
    let (mut env, mut rng) = (pendulum(&library), Seed::new(0).numpy());
    env.reset_to(&[0.0, 0.19, 0.0, 1.0], &mut rng).unwrap();
    let end = env.step(&[0.0], &mut rng).unwrap();
    assert_eq!(end, Outcome { reward: 0.0, terminated: true, truncated: false });

    env.reset(&mut rng).unwrap();
    for t in 1..=1000 {
        let o = env.observation();
        let balance = 0.5 * o[0] + 5.0 * (o[1] + 1.0 / 600.0) + 0.6 * o[2] + o[3];
        let outcome = env.step(&[balance], &mut rng).unwrap();
        assert_eq!(outcome, Outcome { reward: 1.0, terminated: false, truncated: t == 1000 }, "step {t}");
    }
}

#[test]
fn the_control_is_the_clipped_action_and_the_observation_the_state() {
    let Some(library) = common::library() else { return };
    let (mut env, mut rng) = (pendulum(&library), Seed::new(0).numpy());
    env.reset(&mut rng).unwrap();
    assert_eq!(env.spec().name, "inverted-pendulum");
    env.step(&[7.0], &mut rng).unwrap();
    assert_eq!(env.control(), [3.0]);
    assert_eq!(env.observation(), env.state());
    env.reset(&mut rng).unwrap();
    assert_eq!(env.control(), [0.0]);
}

#[test]
fn a_state_that_was_set_is_stepped_from() {
    let Some(library) = common::library() else { return };
    let (mut env, mut other, mut rng) = (pendulum(&library), pendulum(&library), Seed::new(0).numpy());
    let x = [0.3, -0.05, 0.4, 0.2];
    env.reset(&mut rng).unwrap();
    env.step(&[1.0], &mut rng).unwrap();
    env.set_state(&x, &mut rng).unwrap();
    assert_eq!((env.state(), env.observation()), (&x[..], &x[..]));
    other.reset_to(&x, &mut rng).unwrap();
    env.step(&[0.5], &mut rng).unwrap();
    other.step(&[0.5], &mut rng).unwrap();
    assert_eq!(env.state(), other.state());
}

#[test]
fn environments_of_one_model_do_not_feel_each_other() {
    let Some(library) = common::library() else { return };
    let xml = r#"<mujoco><worldbody><geom type="plane" size="9 9 1"/>
        <body pos="0 0 0.3"><freejoint/><geom type="box" size="0.1 0.2 0.1"/>
        <body pos="0.2 0 0"><joint name="arm" axis="0 1 0"/><geom type="capsule" size="0.05 0.2"/></body></body>
        </worldbody><actuator><motor joint="arm" gear="3"/></actuator></mujoco>"#;
    let model = MujocoModel::from_xml(&library, xml).unwrap();
    let alone = |shift: f64| {
        let mut env = common::environment(&model, 2);
        let mut rng = Seed::new(0).numpy();
        env.reset(&mut rng).unwrap();
        let step = |t: usize| {
            env.step(&[(0.05 * t as f64 + shift).sin()], &mut rng).unwrap();
            common::bits(env.state())
        };
        (0..400).map(step).collect::<Vec<_>>()
    };
    let (a, b) = (alone(0.0), alone(1.0));
    assert_ne!(a, b);

    let mut rng = Seed::new(0).numpy();
    let (mut first, mut second) = (common::environment(&model, 2), common::environment(&model, 2));
    first.reset(&mut rng).unwrap();
    second.reset(&mut rng).unwrap();
    for t in 0..400 {
        first.step(&[(0.05 * t as f64).sin()], &mut rng).unwrap();
        assert_eq!(common::bits(first.state()), a[t]);
        second.step(&[(0.05 * t as f64 + 1.0).sin()], &mut rng).unwrap();
        assert_eq!(common::bits(second.state()), b[t]);
    }
}

#[test]
fn environments_move_between_threads() {
    let Some(library) = common::library() else { return };
    let expected = play(&mut pendulum(&library), SEED, 300);
    let mut env = pendulum(&library);
    let here = play(&mut env, SEED, 300);
    let handles: Vec<_> = [env, pendulum(&library), pendulum(&library), pendulum(&library)]
        .into_iter()
        .map(|mut env| std::thread::spawn(move || (play(&mut env, SEED, 300), env)))
        .collect();
    assert_eq!(here, expected);
    for handle in handles {
        let (there, mut env) = handle.join().unwrap();
        assert_eq!(there, expected);
        assert_eq!(play(&mut env, SEED, 300), expected);
    }
}
