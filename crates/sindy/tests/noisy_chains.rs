//! Chains and carts with poles, measured with noise: one Lagrangian ties all coefficients together.

mod mechanisms;
mod recorded;

use mechanisms::{Mechanism, chain};
use sindyna_core::{Certainty, Rng, Seed};
use sindyna_sindy::Identifier;

const DT: f64 = 0.02;

/// Identifies a system with drawn constants from four recordings of 100 steps, with errors of the part `noise` of the spread of each state, and asks for accelerations within `within` of their spread over ±3 rad.
fn is_adequate(make: impl Fn(&mut Rng) -> Mechanism, noise: f64, within: f64) {
    for seed in DRAWS {
        let mut rng = Seed::new(seed).stream("mechanisms", 0);
        let mechanism = make(&mut rng);
        let log = mechanism.noisy_recordings((4, 100, 10), DT, noise, &mut rng);
        let found = Identifier::new(&mechanism.spec(DT)).identify_recordings(&log).expect("equations");
        let deviation = mechanism.deviation(&found.model);
        assert!(deviation < within, "{} {seed} {noise}: {deviation:e}\n{found}", mechanism.name);
        assert!(found.report.equations.iter().all(|e| e.doubt.is_none()), "{} {seed} {noise}\n{found}", mechanism.name);
    }
}

/// Seeds of constants, data and noise.
const DRAWS: std::ops::Range<u64> = 1003..1005;

#[test]
fn two_links_are_adequate_with_noise() {
    is_adequate(|rng| chain(2, false, false, rng), 0.01, 0.03);
}

#[test]
fn two_poles_on_a_cart_are_adequate_with_noise() {
    is_adequate(|rng| chain(2, true, false, rng), 0.001, 0.003);
}

#[test]
fn three_links_are_adequate_with_noise() {
    is_adequate(|rng| chain(3, false, false, rng), 0.001, 0.003);
}

#[test]
fn falls_are_explained_with_noise_whatever_was_found_in_fewer_of_them() {
    let mut rng = Seed::new(1005).stream("mechanisms", 0);
    let mechanism = chain(2, true, false, &mut rng);
    let log = mechanism.noisy_recordings((16, 15, 10), 0.05, 0.001, &mut rng);
    let spec = mechanism.spec(0.05);
    let few = Identifier::new(&spec).identify_recordings(&log[..2]).expect("equations");
    let found = Identifier::new(&spec).with_previous(Some(&few.model)).identify_recordings(&log).expect("equations");
    let deviation = mechanism.deviation(&found.model);
    assert!(deviation < 0.005 && deviation < mechanism.deviation(&few.model), "{deviation:e}\n{few}\n{found}");
    // A parameter that is next to nothing has others beside it that are so, too.
    assert!(matches!(found.certainty(), Certainty::Adequate | Certainty::Ambiguous), "{found}");
}
