//! What every environment promises, checked on every system there is.

#![allow(clippy::float_cmp, reason = "exact numbers are compared on purpose")]

use sindyna_core::{
    Dynamics as _, Environment as _, Seed, Space, Spec, Task as _, VectorField as _, check_dynamics, check_environment,
};

/// A valid action that depends on the step number `t` only, up to half the control range.
fn action(space: &Space, t: usize) -> Vec<f64> {
    let wave = (0.7 * t as f64).sin() / 2.0;
    match space {
        Space::Box { low, high } => low.iter().zip(high).map(|(lo, hi)| (lo + hi + wave * (hi - lo)) / 2.0).collect(),
        Space::Discrete { controls } => vec![(t % controls.nrows()) as f64],
    }
}

#[test]
fn every_system_keeps_the_promises_of_an_environment() {
    let systems = sindyna_envs::systems();
    assert_eq!(systems.len(), 5);
    for system in systems.into_iter().chain(sindyna_envs::fields()) {
        let steps = 3 * system.protocol().max_steps.min(1_000);
        check_environment(|| system.environment(), system.protocol().max_steps, steps).expect("every promise is kept");
        let (mut rng, task) = (Seed::new(0).numpy(), system.task());
        let mut start = || {
            let mut x = vec![0.0; system.spec().state_dim()];
            task.initial(&mut rng, &mut x);
            x
        };
        let starts: Vec<Vec<f64>> = (0..10).map(|_| start()).collect();
        check_dynamics(&*system.dynamics(), system.spec(), &starts).expect("every promise is kept");
    }
}

#[test]
fn systems_are_found_by_either_name() {
    for system in sindyna_envs::systems() {
        assert_eq!(system.spec().name, system.name());
        for name in [Some(system.name()), system.gymnasium_id()].into_iter().flatten() {
            assert_eq!(sindyna_envs::find(name).map(|s| s.name()), Some(system.name()));
        }
        assert!(!system.summary().contains('\n'));
        assert!(!system.true_equations().is_empty());
    }
    assert!(sindyna_envs::find("CartPole").is_none());
}

#[test]
fn the_true_dynamics_draw_nothing_and_stay_where_states_are_declared() {
    for system in sindyna_envs::systems().into_iter().chain(sindyna_envs::fields()) {
        let (dynamics, task, spec) = (system.dynamics(), system.task(), system.spec());
        let mut rng = Seed::new(1).numpy();
        let mut x = vec![0.0; spec.state_dim()];
        let mut u = vec![0.0; spec.control_dim()];
        let mut next = x.clone();
        for _ in 0..20 {
            task.initial(&mut rng, &mut x);
            for t in 0..100 {
                assert!(spec.action_space.control_into(&action(&spec.action_space, t), &mut u));
                let before = rng.clone();
                dynamics.step(&x, &u, &mut rng, &mut next).expect("a true system stays finite");
                assert_eq!(rng, before, "{}: a true system is deterministic", system.name());
                x.copy_from_slice(&next);
                if task.terminated(&x) {
                    break;
                }
                for (value, channel) in x.iter().zip(&spec.state) {
                    assert!(
                        (channel.prior.bounds.0..=channel.prior.bounds.1).contains(value),
                        "{}: {}",
                        system.name(),
                        channel.name
                    );
                }
            }
        }
    }
}

#[test]
fn noise_goes_by_the_scales_of_the_channels_and_leaves_reward_and_end_alone() {
    for (name, scales) in [
        ("cart-pole", &[2.4, 2.0, 0.21, 2.0][..]),
        ("mountain-car", &[0.9, 0.07]),
        ("pendulum", &[1.0, 1.0, 8.0]),
        ("inverted-pendulum", &[1.0, 0.2, 1.0, 1.0]),
        ("cart-pole-swing-up", &[2.4, 5.0, 1.0, 1.0, 12.0]),
    ] {
        let clean = sindyna_envs::find(name).expect("a registered system");
        assert_eq!(clean.spec().observation.iter().map(|c| c.prior.scale).collect::<Vec<_>>(), scales, "{name}");
        let noisy = clean.clone().with_noise(0.1);
        assert_eq!(noisy.spec().noise, 0.1);
        assert_eq!(Spec { noise: 0.0, ..noisy.spec().clone() }, *clean.spec());

        // The same states behind both: start states are drawn before the first observation.
        let (mut exact, mut seen) = (clean.environment(), noisy.environment());
        let (mut rng, mut noise) = (Seed::new(2).numpy(), Seed::new(2).numpy());
        let (mut squares, mut n) = (vec![0.0; scales.len()], 0.0);
        exact.reset(&mut rng).expect("a simulation resets");
        seen.reset_to(exact.state(), &mut noise);
        for t in 0..2000 {
            let action = action(&clean.spec().action_space, t);
            let outcome = exact.step(&action, &mut rng).expect("a valid action");
            assert_eq!(seen.step(&action, &mut noise), Ok(outcome), "{name}");
            for ((square, scale), (o, e)) in
                squares.iter_mut().zip(scales).zip(seen.observation().iter().zip(exact.observation()))
            {
                *square += ((o - e) / scale).powi(2);
            }
            n += 1.0;
            if outcome.terminated || outcome.truncated {
                exact.reset(&mut rng).expect("a simulation resets");
                seen.reset_to(exact.state(), &mut noise);
            }
        }
        for (square, channel) in squares.iter().zip(&noisy.spec().observation) {
            // 2000 draws: a standard error of 0.0016.
            let deviation = (square / n).sqrt();
            assert!((deviation - 0.1).abs() < 0.01, "{name}: {} is off by {deviation} of its scale", channel.name);
        }
    }
}

#[test]
fn rates_are_what_the_dynamics_do_in_a_short_time_between_limits() {
    // How far x⁺ may be from x + dt ẋ: the cart-pole is stepped by exactly that; the others' steps differ from it in
    // the second order, 0.5 dt² ẍ and the like.
    for (name, x, tolerance) in [
        ("cart-pole", &[0.1, 0.2, 0.1, -0.2][..], 1e-15),
        ("mountain-car", &[-0.5, 0.01], 1e-7),
        ("pendulum", &[1.0, 0.3], 0.06),
        ("inverted-pendulum", &[0.1, 0.1, 0.2, -0.2], 0.05),
        ("cart-pole-swing-up", &[0.1, 0.2, 3.0, -0.2], 0.02),
    ] {
        let system = sindyna_envs::find(name).expect("a registered system");
        let (u, mut rng) = ([0.5], Seed::new(0).numpy());
        let (mut rates, mut next) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        system.rates().eval(x, &u, &mut rates);
        system.dynamics().step(x, &u, &mut rng, &mut next).expect("a true system stays finite");
        for i in 0..x.len() {
            let expected = x[i] + system.spec().dt * rates[i];
            assert!((next[i] - expected).abs() <= tolerance, "{name}, state {i}: {} is not {expected}", next[i]);
        }
    }
}

#[test]
fn rates_know_nothing_of_walls_stops_and_speed_limits() {
    let rates = |name: &str, x: &[f64], u: f64| {
        let mut rates = vec![0.0; x.len()];
        sindyna_envs::find(name).expect("a registered system").rates().eval(x, &[u], &mut rates);
        rates
    };
    assert_eq!(rates("pendulum", &[0.0, 8.0], 2.0), [8.0, 6.0]);
    assert!(rates("mountain-car", &[-1.2, -0.07], -1.0)[0] < -0.06, "on through the wall");
    // The rail ends at ±1 m: where the cart is makes no difference to its acceleration.
    assert_eq!(
        rates("inverted-pendulum", &[5.0, 0.1, 0.5, 0.1], 1.0)[2..],
        rates("inverted-pendulum", &[0.0, 0.1, 0.5, 0.1], 1.0)[2..]
    );
}
