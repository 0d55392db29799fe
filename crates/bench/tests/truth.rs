//! The measures tell true equations from near ones.

use sindyna_bench::{measure, rivals, system, warm_up};
use sindyna_core::Seed;
use sindyna_sindy::{Entry, Form, Identifier, Model, ModelParts};
use sindyna_truth::{Structure, Truth, structure};

/// ω̇ = Σ c φ for the pendulum, whose angle's zero is `offset` away.
fn pendulum(terms: &[(&str, f64)], offset: f64) -> Model {
    let entries = terms.iter().enumerate().map(|(i, (_, c))| Entry::new(i + 1, *c)).collect();
    let parts = ModelParts {
        states: vec!["θ".into(), "ω".into()],
        controls: vec!["u".into()],
        form: Form::SemiImplicit { substeps: 1 },
        dt: 0.05,
        readings: None,
        terms: std::iter::once("ω").chain(terms.iter().map(|(t, _)| *t)).map(Into::into).collect(),
        equations: vec![vec![Entry::new(0, 1.0)], entries],
        kinematic: vec![true, false],
        offsets: vec![offset, 0.0],
        n_features: 3,
    };
    Model::new(parts).expect("the parts fit")
}

fn truth(name: &str) -> Truth {
    Truth::of(&system(name).expect("there is one"), 2000)
}

fn coefficients(structure: &Structure) -> &[f64] {
    let Structure::True { coefficients } = structure else { panic!("{structure:?} is not the truth") };
    coefficients
}

#[test]
fn true_terms_have_their_true_coefficients_whatever_the_estimates_are() {
    let truth = truth("pendulum");
    for offset in [0.0, 0.003] {
        let found = structure(&truth, &pendulum(&[("sin(θ)", 14.0), ("u", 3.3)], offset));
        for (got, expected) in coefficients(&found).iter().zip([15.0, 3.0]) {
            assert!((got / expected - 1.0).abs() < 1e-12, "{found:?}");
        }
    }
}

#[test]
fn superfluous_and_missing_terms_are_seen() {
    let truth = truth("pendulum");
    let wider = pendulum(&[("sin(θ)", 15.0), ("u", 3.0), ("ω^2", 1e-9)], 0.0);
    assert_eq!(structure(&truth, &wider), Structure::Wider);
    assert!(truth.deviation(&wider).worst < 1e-7, "and yet it is as good as exact");
    let polynomial = pendulum(&[("θ", 15.0), ("θ^3", -2.5), ("u", 3.0)], 0.0);
    assert_eq!(structure(&truth, &polynomial), Structure::Other);
    assert_eq!(structure(&truth, &pendulum(&[], 0.0)), Structure::Other);
}

#[test]
fn deviations_are_parts_of_the_spread() {
    // ω̇ = 15 sin θ + 3 u over a turn and |u| < 2 spreads by √(15²/2 + 3²·4/3) = 11.15; 1.5 sin θ are missing.
    let found = truth("pendulum").deviation(&pendulum(&[("sin(θ)", 13.5), ("u", 3.0)], 0.0));
    assert!((found.worst - 1.5 / 11.15).abs() < 2e-3, "{found:?}");
    assert!((found.rms - 1.5 / 2_f64.sqrt() / 11.15).abs() < 3e-3, "{found:?}");
}

#[test]
fn ten_steps_of_the_cart_pole_give_implicit_equations_that_are_true() -> anyhow::Result<()> {
    let system = system("cart-pole")?;
    let (truth, identifier) = (Truth::of(&system, 2000), Identifier::new(system.spec()));
    let data = warm_up(&system, 10, Seed::new(0))?;
    assert_eq!(data.n_steps(), 10);
    let (measured, model) = measure(&truth, &identifier, &data)?;
    assert!(measured.true_terms && measured.true_terms_shown && measured.explained, "{measured:?}");
    assert!(measured.deviation.worst.is_some_and(|worst| worst < 1e-4));
    // 1/M, m l/M and −m l/M; g/(4/3 l) and −1/(4/3 l).
    let mut found = coefficients(&structure(&truth, &model)).to_vec();
    found.sort_by(f64::total_cmp);
    for (got, expected) in found.iter().zip([-1.5, -0.05 / 1.1, 0.05 / 1.1, 1.0 / 1.1, 14.7]) {
        assert!((got / expected - 1.0).abs() < 1e-10, "{found:?}");
    }
    let rivals = rivals(&truth, &identifier, &data);
    assert!(rivals.stlsq_best.worst.is_some_and(|worst| worst > 0.1), "thresholding does not find them: {rivals:?}");
    Ok(())
}
