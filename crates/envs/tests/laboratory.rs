//! What the laboratory's systems promise, measured. `--nocapture` prints the errors of a step.

#![allow(clippy::print_stdout, reason = "the errors are shown to whoever asks with --nocapture")]

use sindyna_core::{Dynamics as _, Environment as _, Held, Kind, Scheme, Seed, Space, VectorField as _};

/// Steps followed from each of the starts.
const STEPS: usize = 100;
const STARTS: usize = 20;

#[test]
fn a_step_is_exact_to_1e_10_of_the_scales() {
    use rand::RngExt as _;
    for system in sindyna_envs::fields() {
        let spec = system.spec();
        let exact = Held::new(system.rates(), Scheme::Rk4 { substeps: 1000 }, spec.dt);
        let Space::Box { low, high } = &spec.action_space else { panic!("real inputs") };
        let mut rng = Seed::new(3).numpy();
        let (n, k) = (spec.state_dim(), spec.control_dim());
        let (mut x, mut next, mut truth, mut u) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; k]);
        let mut worst = 0.0_f64;
        for _ in 0..STARTS {
            system.task().initial(&mut rng, &mut x);
            for _ in 0..STEPS {
                for (u, (&low, &high)) in u.iter_mut().zip(low.iter().zip(high)) {
                    *u = rng.random_range(low..=high);
                }
                system.dynamics().step(&x, &u, &mut rng, &mut next).expect("a true system stays finite");
                exact.step(&x, &u, &mut rng, &mut truth).expect("a true system stays finite");
                for ((a, b), channel) in next.iter().zip(&truth).zip(&spec.state) {
                    worst = worst.max((a - b).abs() / channel.prior.scale);
                }
                x.copy_from_slice(&next);
            }
        }
        println!("{}: {worst:.1e} of the scale in a step of {} s", system.name(), spec.dt);
        assert!(worst < 1e-10, "{}: {worst:e}", system.name());
    }
}

#[test]
fn states_are_seen_as_they_are_and_rates_are_rates() {
    for system in sindyna_envs::fields() {
        let spec = system.spec();
        assert_eq!(spec.observation, spec.state);
        let mut env = system.environment();
        let mut rng = Seed::new(0).numpy();
        env.reset(&mut rng).expect("a simulation resets");
        assert_eq!(env.observation(), env.state());
        // Both ways of naming it find it, and no task has its name.
        assert_eq!(sindyna_envs::find_field(system.name()).map(|s| s.name()), Some(system.name()));
        assert!(sindyna_envs::find(system.name()).is_none());

        let x = env.state().to_vec();
        let mut rates = vec![0.0; x.len()];
        system.rates().eval(&x, &vec![0.5; spec.control_dim()], &mut rates);
        for (i, channel) in spec.state.iter().enumerate() {
            if let Kind::RateOf(of) = channel.kind {
                assert_eq!(rates[of].to_bits(), x[i].to_bits(), "{}: {}", system.name(), channel.name);
            }
        }
        assert_eq!(system.true_equations().len(), spec.state_dim());
    }
}
