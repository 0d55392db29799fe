//! Steps that follow other laws than the rest must neither spoil the equations nor be passed over in silence.

mod common;

use sindyna_core::{Dataset, Spec};
use sindyna_sindy::Identifier;

/// A pendulum whose limit of 8 rad/s nobody has declared.
fn undeclared() -> Spec {
    let mut spec = common::pendulum().spec;
    for channel in spec.state.iter_mut().chain(&mut spec.observation).filter(|c| c.name == "ω") {
        channel.prior.bounds = (f64::NEG_INFINITY, f64::INFINITY);
    }
    spec
}

/// Thirty steps; the pendulum falls, is held at its limit for a while, and goes on.
fn falling(seed: u64) -> Dataset {
    let truth = common::pendulum();
    let push = |rng: &mut sindyna_core::Rng, _| common::uniform(rng, -2.0, 2.0);
    common::record(&truth, seed, 30, |_| vec![0.4, 6.0], push, |_| false)
}

#[test]
fn an_undeclared_limit_is_told_from_the_equations() {
    for seed in 0..10 {
        let found = Identifier::new(&undeclared()).identify(&falling(seed)).expect("enough rows");
        let equation = &found.report.equations[1];
        assert!(equation.reached_floor && found.report.rows_astray > 0, "seed {seed}: {}", found.model);
        assert_eq!(found.report.rows + found.report.rows_astray, 30);
        let mut coefficients = equation.coefficients.clone();
        coefficients.sort_by(f64::total_cmp);
        assert!(
            coefficients.len() == 2 && (coefficients[0] - 3.0).abs() < 1e-5 && (coefficients[1] - 15.0).abs() < 1e-5,
            "seed {seed}: {}",
            found.model
        );
    }
}

#[test]
fn a_law_the_terms_cannot_say_leaves_no_strays() {
    // Half of the steps push with twice the gain: no equation holds for all but a few.
    let truth = common::pendulum();
    let mut data = Dataset::new(3, 1, 1, truth.spec.dt);
    let (mut x, mut rng) = (vec![0.3, 0.0], sindyna_core::Seed::new(3).numpy());
    let seen = |x: &[f64]| [x[0].cos(), x[0].sin(), x[1]].map(|v| f64::from(v as f32));
    data.begin(&seen(&x)).expect("finite");
    for i in 0..30 {
        let u = common::uniform(&mut rng, -2.0, 2.0);
        x = (truth.step)(&x, &[if i % 2 == 0 { u } else { 2.0 * u }]);
        data.push(&[u], &[u], 0.0, &seen(&x)).expect("finite");
    }
    let found = Identifier::new(&truth.spec).identify(&data).expect("enough rows");
    assert_eq!(found.report.rows_astray, 0);
    assert!(!found.report.equations[1].reached_floor, "{}", found.model);
}
