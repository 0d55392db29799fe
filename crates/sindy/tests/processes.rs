//! Vessels, tanks and valves.

mod recorded;

use recorded::{Field, assert_equation, equation, record_held, spec};
use sindyna_core::Kind;
use sindyna_sindy::{Identified, Identifier, Recording};

/// What the inputs between −1 and 1 of a recording are.
fn opening(u: f64) -> f64 {
    0.5 * (u + 1.0)
}

/// A vessel that is filled and empties against the air.
fn vessel(x: &[f64], u: f64) -> Vec<f64> {
    vec![7.0 * opening(u) - 1.1 * (x[0] - 101.3).max(0.0).sqrt()]
}

/// A tank that is filled evenly and emptied by a valve.
fn emptied(x: &[f64], u: f64) -> Vec<f64> {
    vec![0.3 - 0.2 * opening(u) * x[0].max(0.0).sqrt()]
}

/// Two tanks that are joined; the first is filled, the second empties.
fn joined(x: &[f64], u: f64) -> Vec<f64> {
    let between = 0.15 * (x[0] - x[1]).signum() * (x[0] - x[1]).abs().sqrt();
    vec![0.2 * opening(u) - between, between - 0.1 * x[1].max(0.0).sqrt()]
}

fn identified(states: &[&str], dt: f64, recording: &Recording) -> Identified {
    let kinds: Vec<(&str, Kind)> = states.iter().map(|name| (*name, Kind::Plain)).collect();
    Identifier::new(&spec(&kinds, dt)).identify_recordings(std::slice::from_ref(recording)).expect("equations")
}

/// A recording of `field` under valves that are open between 0 and 1.
fn under_valves(field: Field, start: &[f64], dt: f64, noise: f64, seed: u64) -> Recording {
    let mut recording = record_held(field, start, (500, dt), (noise, 1.0, false), 5, seed);
    recording.controls.mapv_inplace(opening);
    recording
}

#[test]
fn a_vessel_empties_to_the_pressure_around_it() {
    for (noise, within) in [(0.0, 1e-6), (0.01, 0.1)] {
        for seed in 0..3 {
            let found = identified(&["p"], 0.5, &under_valves(vessel, &[110.0], 0.5, noise, seed));
            let report = &found.report.equations[0];
            let [zero] = &report.parameters[..] else { panic!("{:?}", equation(&found, 0)) };
            let root = found.report.features[zero.term].clone();
            assert!(root.starts_with("sqrt(p − "), "{root}");
            assert_equation(&found, 0, &[("u", 7.0), (&root, -1.1)], within);
            assert!((zero.value - 101.3).abs() < 4.0 * zero.standard_error + 1e-6, "{zero:?}");
        }
    }
}

#[test]
fn a_valve_lets_through_what_the_level_presses() {
    for seed in 0..3 {
        let found = identified(&["h"], 1.0, &under_valves(emptied, &[6.0], 1.0, 0.01, seed));
        assert_equation(&found, 0, &[("1", 0.3), ("u·sqrt h", -0.2)], 0.05);
    }
}

#[test]
fn joined_tanks_flow_by_the_difference_of_their_levels() {
    let between = "sign(h − k)·sqrt(abs(h − k))";
    for seed in 0..3 {
        let found = identified(&["h", "k"], 1.0, &under_valves(joined, &[1.8, 0.9], 1.0, 0.01, seed));
        assert_equation(&found, 0, &[("u", 0.2), (between, -0.15)], 0.05);
        assert_equation(&found, 1, &[("sqrt k", -0.1), (between, 0.15)], 0.05);
    }
}
