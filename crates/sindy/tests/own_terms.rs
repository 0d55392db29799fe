//! Terms the user adds stand beside the library's.

use sindyna_core::{Channel, Dataset, Kind, Precision, Space, Spec};
use sindyna_sindy::Identifier;

fn mass() -> Spec {
    let state = vec![Channel::new("x", "m", Kind::Plain, 1.0), Channel::new("v", "m/s", Kind::RateOf(0), 1.0)];
    Spec {
        name: "mass in air".into(),
        observation: state.clone(),
        state,
        control: vec![Channel::new("g", "N", Kind::Plain, 1.0)],
        action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt: 0.1,
    }
}

/// 100 steps of v⁺ = v + Δt (g/2 − 0.3 v|v|), x⁺ = x + Δt v.
fn pushed_about() -> Dataset {
    let mut data = Dataset::new(2, 1, 1, 0.1);
    let (mut x, mut v) = (0.3_f64, 0.1_f64);
    data.begin(&[x, v]).expect("finite");
    for i in 0..100 {
        let g = (0.1 * f64::from(i)).cos();
        (x, v) = (x + 0.1 * v, v + 0.1 * (g / 2.0 - 0.3 * v * v.abs()));
        data.push(&[g], &[g], 0.0, &[x, v]).expect("finite");
    }
    data
}

#[test]
fn quadratic_drag_is_found_once_its_term_is_offered() {
    let plain = Identifier::new(&mass()).identify(&pushed_about()).expect("enough rows");
    assert!(plain.report.equations[1].residual > 1e-9, "no term of the library is v|v|");

    let identifier = Identifier::new(&mass()).with_own_terms(vec!["v*abs(v)".into()]).expect("known names");
    let found = identifier.identify(&pushed_about()).expect("enough rows");
    assert_eq!(found.model.equations()[0], "x\u{307} = v");
    assert_eq!(found.model.nonzero(), 2, "{}", found.model.equations()[1]);
    let mut coefficients: Vec<f64> = found.model.coefficients(1).iter().map(|e| e.coefficient).collect();
    coefficients.sort_by(f64::total_cmp);
    assert!((coefficients[0] + 0.3).abs() < 1e-9 && (coefficients[1] - 0.5).abs() < 1e-9, "{coefficients:?}");
}

#[test]
fn a_term_over_an_unknown_name_is_refused_with_the_known_ones() {
    let refusal = Identifier::new(&mass()).with_own_terms(vec!["sin(phi)".into()]).expect_err("no such variable");
    let refusal = refusal.to_string();
    assert!(refusal.contains("phi") && refusal.contains('v') && refusal.contains('g'), "{refusal}");
}
