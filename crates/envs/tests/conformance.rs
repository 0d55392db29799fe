//! What every environment promises, checked on every system there is.

#![allow(clippy::float_cmp, reason = "exact numbers are compared on purpose")]

use sindyna_core::{
    Channel, Dynamics as _, EnvError, Environment, Kind, Outcome, Precision, Seed, Space, Spec, Task as _,
    VectorField as _,
};

/// A valid action that depends on the step number `t` only, up to half the control range.
fn action(space: &Space, t: usize) -> Vec<f64> {
    let wave = (0.7 * t as f64).sin() / 2.0;
    match space {
        Space::Box { low, high } => low.iter().zip(high).map(|(lo, hi)| (lo + hi + wave * (hi - lo)) / 2.0).collect(),
        Space::Discrete { controls } => vec![(t % controls.nrows()) as f64],
    }
}

/// Observations, rewards and ends of `steps` steps, resetting where an episode ends.
fn play(env: &mut dyn Environment, seed: u64, steps: usize) -> Vec<(Vec<f64>, Outcome)> {
    let mut rng = Seed::new(seed).numpy();
    env.reset(&mut rng).expect("a simulation resets");
    let step = |t| {
        let action = action(&env.spec().action_space, t);
        let outcome = env.step(&action, &mut rng).expect("a valid action after a reset");
        let seen = env.observation().to_vec();
        if outcome.terminated || outcome.truncated {
            env.reset(&mut rng).expect("a simulation resets");
        }
        (seen, outcome)
    };
    (0..steps).map(step).collect()
}

/// `make` gives a new environment; everything an environment promises must hold of it.
fn check_environment<E: Environment>(make: impl Fn() -> E) {
    let spec = make().spec().clone();
    check_spec(&spec);
    let name = &spec.name;
    let mut rng = Seed::new(0).numpy();

    let mut env = make();
    assert_eq!(env.step(&action(&spec.action_space, 0), &mut rng), Err(EnvError::NeedsReset), "{name}: before a reset");

    let steps = 3 * spec.max_steps;
    let (first, second) = (play(&mut env, 5, steps), play(&mut make(), 5, steps));
    assert_eq!(first, second, "{name}: one seed, one history");
    assert_ne!(first[0], play(&mut env, 6, 1)[0], "{name}: another seed, another start");

    let mut length = 0;
    for (seen, outcome) in &first {
        length += 1;
        assert_eq!(seen.len(), spec.observation_dim(), "{name}");
        assert_eq!(outcome.truncated, length == spec.max_steps, "{name}: truncated by the clock alone");
        assert!(outcome.reward.is_finite(), "{name}");
        for (value, channel) in seen.iter().zip(&spec.observation) {
            let (low, high) = channel.bounds;
            assert!((low..=high).contains(value), "{name}: {} = {value} is not in [{low}, {high}]", channel.name);
            assert!(
                spec.precision == Precision::F64 || f64::from(*value as f32).to_bits() == value.to_bits(),
                "{name}: {} = {value} is no float32",
                channel.name
            );
        }
        if outcome.terminated || outcome.truncated {
            length = 0;
        }
    }

    env.reset(&mut rng).expect("a simulation resets");
    for bad in [f64::NAN, f64::INFINITY] {
        let refused = env.step(&vec![bad; spec.action_space.action_dim()], &mut rng);
        assert!(matches!(refused, Err(EnvError::NotAnAction { .. })), "{name}: {bad} is no action");
    }
    for t in 0.. {
        let outcome = env.step(&action(&spec.action_space, t), &mut rng).expect("a valid action");
        if outcome.terminated || outcome.truncated {
            break;
        }
    }
    assert_eq!(env.step(&action(&spec.action_space, 0), &mut rng), Err(EnvError::NeedsReset), "{name}: after the end");
}

fn check_spec(spec: &Spec) {
    let name = &spec.name;
    for channel in spec.state.iter().chain(&spec.observation).chain(&spec.control) {
        let Channel { name: c, scale, bounds: (low, high), .. } = channel;
        assert!(scale.is_finite() && *scale > 0.0, "{name}: scale of {c}");
        assert!(low < high, "{name}: bounds of {c}");
        match channel.kind {
            Kind::RateOf(i) | Kind::CosOf(i) | Kind::SinOf(i) => assert!(i < spec.state_dim(), "{name}: {c}"),
            Kind::Plain | Kind::Angle => {}
        }
    }
    assert_eq!(spec.action_space.control_dim(), spec.control_dim(), "{name}");
    match &spec.action_space {
        Space::Box { low, high } => {
            for ((c, lo), hi) in spec.control.iter().zip(low).zip(high) {
                assert_eq!(c.bounds, (*lo, *hi), "{name}: the range of {}", c.name);
            }
        }
        Space::Discrete { controls } => {
            for row in controls.rows() {
                for (c, u) in spec.control.iter().zip(row) {
                    assert!((c.bounds.0..=c.bounds.1).contains(u), "{name}: the range of {}", c.name);
                }
            }
        }
    }
    assert!(spec.dt > 0.0 && spec.max_steps > 0, "{name}");
}

#[test]
fn every_system_keeps_the_promises_of_an_environment() {
    let systems = sindyna_envs::systems();
    assert_eq!(systems.len(), 5);
    for system in systems.into_iter().chain(sindyna_envs::fields()) {
        check_environment(|| system.environment());
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
                        (channel.bounds.0..=channel.bounds.1).contains(value),
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
        assert_eq!(clean.spec().observation.iter().map(|c| c.scale).collect::<Vec<_>>(), scales, "{name}");
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
