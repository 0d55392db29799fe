//! Chains, carts with poles, and bodies that turn in space: exact from few samples, whatever their constants.

mod mechanisms;
mod recorded;

use mechanisms::{Mechanism, chain, furuta, spherical};
use sindyna_core::{Rng, Seed};
use sindyna_sindy::Identifier;

const DT: f64 = 0.02;

/// Identifies systems with other constants from `steps` steps each, and asks for the true accelerations over ±3 rad.
fn is_exact(make: impl Fn(&mut Rng) -> Mechanism, steps: usize) {
    for seed in DRAWS {
        let mut rng = Seed::new(seed).stream("mechanisms", 0);
        let mechanism = make(&mut rng);
        let log = mechanism.recordings(steps, DT, &mut rng);
        let found = Identifier::new(&mechanism.spec(DT)).identify_recordings(&log).expect("equations");
        let deviation = mechanism.deviation(&found.model);
        assert!(deviation < 1e-4, "{} {seed}: {deviation:e}\n{found}", mechanism.name);
        assert!(found.report.equations.iter().all(|e| e.reached_floor), "{} {seed}\n{found}", mechanism.name);
    }
}

/// Seeds of constants and data.
const DRAWS: std::ops::Range<u64> = 1000..1003;

#[test]
fn chains_of_two_links_are_exact_from_eighteen_steps() {
    is_exact(|rng| chain(2, false, false, rng), 18);
    is_exact(|rng| chain(2, false, true, rng), 18);
}

#[test]
fn longer_chains_are_exact_from_thirty_steps() {
    is_exact(|rng| chain(3, false, false, rng), 30);
    is_exact(|rng| chain(4, false, false, rng), 30);
}

#[test]
fn carts_with_poles_are_exact_from_thirty_steps() {
    is_exact(|rng| chain(1, true, false, rng), 12);
    is_exact(|rng| chain(2, true, false, rng), 18);
    is_exact(|rng| chain(2, true, true, rng), 18);
    is_exact(|rng| chain(3, true, false, rng), 30);
}

#[test]
fn what_turns_in_space_is_exact_from_thirty_steps() {
    is_exact(furuta, 30);
    is_exact(spherical, 30);
}
