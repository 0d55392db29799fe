//! Identification that begins with what was found in fewer data.

mod recorded;

use recorded::{Field, assert_equation, record, spec};
use sindyna_core::{Certainty, Kind};
use sindyna_sindy::{Doubt, Identifier};

fn pendulum_without_friction(x: &[f64], u: f64) -> Vec<f64> {
    vec![x[1], -9.0 * x[0].sin() + u]
}

fn pendulum_with_friction(x: &[f64], u: f64) -> Vec<f64> {
    vec![x[1], -9.0 * x[0].sin() - 0.3 * x[1] + u]
}

#[test]
fn what_was_found_in_fewer_data_stays_where_it_is_right_and_gives_way_where_it_is_not() {
    let spec = spec(&[("q", Kind::Angle), ("w", Kind::RateOf(0))], 0.05);
    let of =
        |field: Field, samples: usize, seed: u64| record(field, &[1.5, 0.0], (samples, 0.05), (0.01, 1.0, false), seed);
    let few = Identifier::new(&spec).identify_recordings(&[of(pendulum_with_friction, 200, 1)]).unwrap();
    let truth = [("sin q", -9.0), ("w", -0.3), ("u", 1.0)];
    assert_equation(&few, 1, &truth, 0.1);
    let more = [of(pendulum_with_friction, 200, 1), of(pendulum_with_friction, 400, 2)];
    let again = Identifier::new(&spec).with_previous(Some(&few.model)).identify_recordings(&more).unwrap();
    assert_equation(&again, 1, &truth, 0.05);
    // Of another pendulum it is a wrong beginning, from which the search departs.
    let other = Identifier::new(&spec).identify_recordings(&[of(pendulum_without_friction, 200, 3)]).unwrap();
    assert_equation(&other, 1, &[("sin q", -9.0), ("u", 1.0)], 0.1);
    let found = Identifier::new(&spec).with_previous(Some(&other.model)).identify_recordings(&more).unwrap();
    assert_equation(&found, 1, &truth, 0.05);
}

#[test]
fn a_search_that_ended_early_doubts_the_terms_and_not_that_they_explain_the_data() {
    let spec = spec(&[("q", Kind::Angle), ("w", Kind::RateOf(0))], 0.05);
    let recording = record(pendulum_with_friction, &[1.5, 0.0], (200, 0.05), (0.01, 1.0, false), 1);
    let mut found = Identifier::new(&spec).identify_recordings(&[recording]).unwrap();
    assert_eq!(found.certainty(), Certainty::Adequate, "{found}");
    for (doubt, certainty) in [
        (Doubt::Unfinished, Certainty::Ambiguous),
        (Doubt::OtherTerms, Certainty::Ambiguous),
        (Doubt::Correlated, Certainty::Doubted),
    ] {
        let equation = &mut found.report.equations[1];
        (equation.reached_floor, equation.doubt) = (false, Some(doubt));
        assert_eq!(found.certainty(), certainty, "{doubt:?}");
    }
}
