//! MuJoCo's inverted pendulum and the closed form of `sindyna-envs` are one system.
//!
//! `--nocapture` prints the largest deviations.

#![allow(clippy::unwrap_used, reason = "a test stops at what it cannot do")]
#![allow(clippy::print_stdout, reason = "the largest deviations are shown to whoever asks with --nocapture")]

mod common;

use sindyna_core::{Environment as _, Seed};
use sindyna_mujoco::{Library, inverted_pendulum};

/// Largest deviation of a state value, off the stops and at them. Values above 1 count relative to themselves.
struct Deviation {
    free: f64,
    stopped: f64,
    steps_at_stop: usize,
    widest: f64,
}

/// 1,000 steps of `policy` on both, each seeing itself only; an episode's end resets both.
fn compare(library: &Library, policy: impl Fn(&[f64], usize) -> f64) -> Deviation {
    let mut native = sindyna_envs::find("inverted-pendulum").unwrap().environment();
    let mut mujoco = inverted_pendulum(library).unwrap();
    let (mut rng, mut same) = (Seed::new(3).numpy(), Seed::new(3).numpy());
    native.reset(&mut rng).unwrap();
    mujoco.reset(&mut same).unwrap();
    let mut worst = Deviation { free: 0.0, stopped: 0.0, steps_at_stop: 0, widest: 0.0 };
    // What happened at a stop is remembered by the state until the episode's end.
    let mut stopped = false;
    for t in 0..1000 {
        let outcomes = [
            native.step(&[policy(native.observation(), t)], &mut rng).unwrap(),
            mujoco.step(&[policy(mujoco.observation(), t)], &mut same).unwrap(),
        ];
        assert_eq!(outcomes[0], outcomes[1]);
        worst.widest = worst.widest.max(native.state()[0].abs());
        let at_stop = native.state()[0].abs() > 0.99;
        stopped |= at_stop;
        worst.steps_at_stop += usize::from(at_stop);
        for (a, b) in native.state().iter().zip(mujoco.state()) {
            let deviation = (a - b).abs() / b.abs().max(1.0);
            let worst = if stopped { &mut worst.stopped } else { &mut worst.free };
            *worst = worst.max(deviation);
        }
        if outcomes[0].terminated || outcomes[0].truncated {
            native.reset(&mut rng).unwrap();
            mujoco.reset(&mut same).unwrap();
            stopped = false;
        }
    }
    let Deviation { free, stopped, steps_at_stop, widest } = worst;
    println!("off the stops {free:.1e}, at them {stopped:.1e} ({steps_at_stop} steps), cart within {widest:.2} m");
    worst
}

/// Balances the pole with the cart at `position`.
fn balance(o: &[f64], position: f64) -> f64 {
    0.5 * (o[0] - position) + 5.0 * (o[1] + 1.0 / 600.0) + 0.6 * o[2] + o[3]
}

#[test]
fn they_stay_together_off_the_stops() {
    let Some(library) = common::library() else { return };
    let deviation = compare(&library, |o, t| balance(o, 0.8 * (0.05 * t as f64).sin()));
    assert_eq!(deviation.steps_at_stop, 0);
    assert!(deviation.widest > 0.3, "the cart moved {} m only", deviation.widest);
    assert!(deviation.free < 1e-9, "{:e}", deviation.free);
}

#[test]
fn they_stay_together_at_the_stops() {
    let Some(library) = common::library() else { return };
    let deviation = compare(&library, |o, _| balance(o, 1.5));
    assert!(deviation.steps_at_stop > 20, "{} steps at a stop", deviation.steps_at_stop);
    assert!(deviation.free < 1e-9, "{:e}", deviation.free);
    assert!(deviation.stopped < 1e-6, "{:e}", deviation.stopped);
}
