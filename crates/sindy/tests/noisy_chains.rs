//! Chains and carts with poles, measured with noise: one Lagrangian ties all coefficients together.

mod mechanisms;
mod recorded;

use std::collections::BTreeMap;

use mechanisms::{Mechanism, chain};
use ndarray::{Array2, Axis, concatenate, s};
use sindyna_core::{Certainty, Kind, Rng, Seed};
use sindyna_sindy::{Identified, Identifier, Recording};

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
fn an_input_that_pushes_backwards_has_the_same_equations() {
    for seed in DRAWS {
        let mut rng = Seed::new(seed).stream("mechanisms", 0);
        let mechanism = chain(2, true, false, &mut rng);
        let log = mechanism.noisy_recordings((4, 100, 10), DT, 0.001, &mut rng);
        let backwards = |of: &Recording| Recording::even(DT, of.states.clone(), Some(-&of.controls));
        let turned: Vec<Recording> = log.iter().map(backwards).collect();
        let of = |log: &[Recording]| Identifier::new(&mechanism.spec(DT)).identify_recordings(log).expect("equations");
        let (found, same) = (of(&log), of(&turned));
        let coefficients = |found: &Identified| {
            let mut all: Vec<f64> =
                found.report.equations.iter().flat_map(|e| e.coefficients.clone()).map(f64::abs).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let (one, other) = (coefficients(&found), coefficients(&same));
        assert_eq!((found.certainty(), one.len()), (same.certainty(), other.len()), "{seed}\n{found}\n{same}");
        for (a, b) in one.iter().zip(&other) {
            assert!((a - b).abs() < 1e-6 * a.abs().max(1e-3), "{seed}: {a} {b}\n{found}\n{same}");
        }
    }
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

#[test]
fn what_rests_in_each_recording_is_no_joint() {
    for seed in DRAWS {
        let mut rng = Seed::new(seed).stream("target", 0);
        let mechanism = chain(2, false, false, &mut rng);
        let log = mechanism.noisy_recordings((4, 100, 10), DT, 0.01, &mut rng);
        // A target that is elsewhere in each, and its rate.
        let places = [0.12, 0.17, 0.08, 0.14];
        let with_target = |(recording, place): (&Recording, f64)| {
            let x = &recording.states;
            let beside = |value: f64, rng: &mut Rng| {
                Array2::from_shape_simple_fn((x.nrows(), 1), || value + 0.01 * recorded::normal(rng))
            };
            let (place, rate) = (beside(place, &mut rng), beside(0.0, &mut rng));
            let states = concatenate![Axis(1), x.slice(s![.., ..2]), place, x.slice(s![.., 2..]), rate];
            Recording::even(DT, states, Some(recording.controls.clone()))
        };
        let seen: Vec<Recording> = log.iter().zip(places).map(with_target).collect();
        let joint = Kind::Angle;
        let states = [("q0", joint), ("q1", joint), ("r", Kind::Plain)];
        let rates = [("v0", Kind::RateOf(0)), ("v1", Kind::RateOf(1)), ("vr", Kind::RateOf(2))];
        let spec = recorded::spec(&[states, rates].concat(), DT);
        let found = Identifier::new(&spec).identify_recordings(&seen).expect("equations");
        let alone = Identifier::new(&mechanism.spec(DT)).identify_recordings(&log).expect("equations");
        assert!(matches!(found.certainty(), Certainty::Adequate | Certainty::Ambiguous), "{seed}\n{found}");
        assert!(found.report.equations[5].support.is_empty(), "{seed}\n{found}");
        let terms = |found: &Identified, i: usize| -> BTreeMap<String, f64> {
            let of = &found.report.equations[i];
            of.support.iter().map(|j| found.report.features[*j].clone()).zip(of.coefficients.clone()).collect()
        };
        // Beside these are parameters that are next to nothing.
        for (i, same) in [(3, 2), (4, 3)] {
            let with = terms(&found, i);
            let told = terms(&alone, same).into_iter().filter(|(_, c)| c.abs() > 0.1);
            for (term, value) in told {
                assert!(
                    with.get(&term).is_some_and(|c| (c - value).abs() < 0.02 * value.abs()),
                    "{term}\n{found}\n{alone}"
                );
            }
        }
    }
}
