//! States far from zero: temperatures in kelvins.

mod recorded;

use recorded::{Field, assert_equation, record, spec};
use sindyna_core::Kind;
use sindyna_sindy::Identifier;

const TEMPERATURES: [(&str, Kind); 2] = [("plate", Kind::Plain), ("probe", Kind::Plain)];

/// A heated plate and a probe on it, above the room.
fn above_the_room(x: &[f64], u: f64) -> Vec<f64> {
    vec![1.2 * u - 0.04 * x[0] + 0.03 * x[1], 0.02 * x[0] - 0.03 * x[1]]
}

/// The same in kelvins, in a room of 293 K.
fn in_kelvins(x: &[f64], u: f64) -> Vec<f64> {
    above_the_room(&[x[0] - 293.0, x[1] - 293.0], u)
}

#[test]
fn temperatures_in_kelvins_have_the_equations_of_those_above_the_room() {
    for (field, room) in [(above_the_room as Field, 0.0), (in_kelvins, 293.0)] {
        for seed in 0..6 {
            let recording = record(field, &[room + 5.0, room - 2.0], (300, 2.0), (0.03, 1.0, false), seed);
            let found =
                Identifier::new(&spec(&TEMPERATURES, 2.0)).identify_recordings(&[recording]).expect("equations");
            let constant = |value: f64| if room > 0.0 { vec![("1", value)] } else { Vec::new() };
            let plate = [constant(2.93), vec![("plate", -0.04), ("probe", 0.03), ("u", 1.2)]].concat();
            let probe = [constant(2.93), vec![("plate", 0.02), ("probe", -0.03)]].concat();
            assert_equation(&found, 0, &plate, 0.15);
            assert_equation(&found, 1, &probe, 0.15);
        }
    }
}

/// A balloon held at 1,520 m.
fn balloon(x: &[f64], u: f64) -> Vec<f64> {
    vec![x[1], -0.15 * x[1] * x[1].abs() - 0.1 * x[1] + 1.2 * u - 0.02 * (x[0] - 1520.0)]
}

/// Coefficients that differ between the halves of the data in digits which rounding leaves open are no reason for doubt.
#[test]
fn an_exact_altitude_is_no_approximation() {
    let recording = record(balloon, &[1510.0, 0.0], (800, 0.2), (0.0, 1.0, false), 1);
    let identifier = Identifier::new(&spec(&[("z", Kind::Plain), ("v", Kind::RateOf(0))], 0.2));
    let found = identifier.identify_recordings(&[recording]).expect("equations");
    let truth = [("1", 30.4), ("z", -0.02), ("v", -0.1), ("v·abs v", -0.15), ("u", 1.2)];
    assert_equation(&found, 1, &truth, 1e-6);
    assert_eq!(found.report.equations[1].doubt, None);
}
