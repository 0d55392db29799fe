//! Laws of nature with powers, and products of inputs with states.

mod recorded;

use recorded::{Field, assert_equation, equation, record_held, spec};
use sindyna_core::Kind;
use sindyna_sindy::{Identified, Identifier};

/// What is found in 500 samples of `field` under inputs between −1 and 1, with noise of a thousandth.
fn found(states: &[(&str, Kind)], (field, start): (Field, &[f64]), dt: f64, seed: u64) -> Identified {
    let recording = record_held(field, start, (500, dt), (0.001, 1.0, false), 5, seed);
    Identifier::new(&spec(states, dt)).identify_recordings(std::slice::from_ref(&recording)).expect("equations")
}

/// Expects the terms of `truth` in equation `i`, of which those that end with ^ have exponents inside, near `exponents`.
fn assert_powers(found: &Identified, i: usize, truth: &[(&str, f64)], exponents: &[f64]) {
    let report = &found.report.equations[i];
    let inside: Vec<f64> = report.parameters.iter().map(|inside| inside.value).collect();
    assert_eq!(inside.len(), exponents.len(), "{:?}", equation(found, i));
    for exponent in exponents {
        let near = inside.iter().any(|value| (value - exponent).abs() < 0.05 * exponent.abs());
        assert!(near, "{exponent}: {:?}", equation(found, i));
    }
    assert_eq!(report.support.len(), truth.len(), "{:?}", equation(found, i));
    for (begins, coefficient) in truth {
        let is_meant = |term: &str| if begins.ends_with('^') { term.starts_with(begins) } else { term == *begins };
        let at = report.support.iter().position(|term| is_meant(&found.report.features[*term]));
        let at = at.unwrap_or_else(|| panic!("{begins}: {:?}", equation(found, i)));
        let off = report.coefficients[at] / coefficient - 1.0;
        assert!(off.abs() < 0.05, "{begins}: {:?}", equation(found, i));
    }
}

/// A tank with a wall that leans outwards, filled and emptied by pumps.
fn leaning(x: &[f64], u: f64) -> Vec<f64> {
    vec![0.8 * u / x[0].powf(1.6) + 0.3 - 0.1 * x[0]]
}

/// A capacitor with a load of constant power.
fn loaded(x: &[f64], u: f64) -> Vec<f64> {
    vec![4.0 + 3.0 * u - 0.4 * x[0] - 5.0 / x[0]]
}

#[test]
fn powers_may_be_negative() {
    for seed in 0..3 {
        let leaning = found(&[("h", Kind::Plain)], (leaning, &[3.0]), 0.4, seed);
        assert_powers(&leaning, 0, &[("1", 0.3), ("h", -0.1), ("u\u{b7}h^", 0.8)], &[-1.6]);
    }
}

/// Velocity and mass of a rocket.
fn burning(x: &[f64], u: f64) -> Vec<f64> {
    vec![60.0 * (1.0 + u) / x[1] - 9.81, -0.1 - 0.1 * u]
}

/// Volume and temperature of a tank that is heated, and filled from 15 °C.
fn filled(x: &[f64], u: f64) -> Vec<f64> {
    let flow = 0.2 + 0.15 * u;
    vec![flow - 0.1 * x[0], (flow * (15.0 - x[1]) + 5.0) / x[0]]
}

/// An epidemic among those who live, and are born.
fn spreading(x: &[f64], u: f64) -> Vec<f64> {
    let (born, infected) = (10.0 * (1.0 + u), 0.8 * x[0] * x[1] / x[2]);
    vec![born - infected, infected - 0.3 * x[1], born - 0.1 * x[1]]
}

#[test]
fn masses_and_volumes_stand_below() {
    for seed in 0..3 {
        let loaded = found(&[("v", Kind::Plain)], (loaded, &[6.0]), 0.3, seed);
        assert_equation(&loaded, 0, &[("1", 4.0), ("u", 3.0), ("v", -0.4), ("1/v", -5.0)], 0.05);
        let rocket = found(&[("v", Kind::Plain), ("m", Kind::Plain)], (burning, &[0.0, 5.0]), 0.05, seed);
        assert_equation(&rocket, 0, &[("1", -9.81), ("1/m", 60.0), ("u/m", 60.0)], 0.05);
        let tank = found(&[("V", Kind::Plain), ("T", Kind::Plain)], (filled, &[2.0, 30.0]), 0.1, seed);
        assert_equation(&tank, 1, &[("1/V", 8.0), ("u/V", 2.25), ("T/V", -0.2), ("T\u{b7}u/V", -0.15)], 0.05);
        let states = [("S", Kind::Plain), ("I", Kind::Plain), ("N", Kind::Plain)];
        let epidemic = found(&states, (spreading, &[950.0, 50.0, 1000.0]), 0.1, seed);
        assert_equation(&epidemic, 1, &[("I", -0.3), ("S\u{b7}I/N", 0.8)], 0.05);
    }
}

/// A boat whose propeller turns both ways.
fn propelled(x: &[f64], u: f64) -> Vec<f64> {
    vec![1.5 * u * u.abs() - 0.6 * x[0]]
}

/// Those who may fall ill, and those who are, under measures u.
fn epidemic(x: &[f64], u: f64) -> Vec<f64> {
    let infected = (1.2 - 0.8 * u) * x[0] * x[1];
    vec![0.5 - 0.1 * x[0] - infected, infected - 0.7 * x[1]]
}

#[test]
fn inputs_act_by_their_squares_and_on_products() {
    for seed in 0..3 {
        let boat = found(&[("v", Kind::Plain)], (propelled, &[0.1]), 0.1, seed);
        assert_equation(&boat, 0, &[("u\u{b7}abs u", 1.5), ("v", -0.6)], 0.05);
        let epidemic = found(&[("S", Kind::Plain), ("I", Kind::Plain)], (epidemic, &[0.8, 0.4]), 0.1, seed);
        assert_equation(&epidemic, 1, &[("I", -0.7), ("S\u{b7}I", 1.2), ("S\u{b7}I\u{b7}u", -0.8)], 0.05);
    }
}

/// The flow through a compressor, which turns over where the pressure that it makes falls.
fn surging(x: &[f64], u: f64) -> Vec<f64> {
    vec![3.5 - 10.0 * x[1] + 40.0 * x[0].powi(2) - 55.0 * x[0].powi(3), 6.0 * x[0] - (4.5 + 1.5 * u) * x[1]]
}

#[test]
fn less_than_half_a_wave_is_a_parabola() {
    for seed in 0..4 {
        let recording = record_held(surging, &[0.5, 0.6], (1000, 0.01), (0.004, 1.0, false), 10, seed);
        let states = spec(&[("flow", Kind::Plain), ("pressure", Kind::Plain)], 0.01);
        let flow = Identifier::new(&states).identify_recordings(std::slice::from_ref(&recording)).expect("equations");
        assert_equation(
            &flow,
            0,
            &[("1", 3.5), ("pressure", -10.0), ("flow\u{b2}", 40.0), ("flow\u{b3}", -55.0)],
            0.05,
        );
        assert!(flow.report.equations[0].equally_good.is_empty(), "{:?}", flow.report.equations[0].equally_good);
    }
}
