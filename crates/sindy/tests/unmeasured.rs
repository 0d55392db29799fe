//! Positions without their rates: these follow their equations over the whole recording.

mod recorded;

use ndarray::Array2;
use recorded::{normal, spec};
use sindyna_core::{Kind, Seed};
use sindyna_sindy::{Identifier, Recording};

const DT: f64 = 0.02;

/// A ball on a beam whose tilt u keeps it near a moving place: ẍ = 6.2 sin u − 0.13 ẋ, of which x is measured with errors of 0.2 mm.
fn ball(seed: u64) -> Recording {
    const PARTS: usize = 20;
    let mut rng = Seed::new(seed).stream("ball", 0);
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    let (mut states, mut controls) = (Array2::from_elem((1500, 2), f64::NAN), Array2::zeros((1499, 1)));
    for t in 0..1500 {
        states[[t, 0]] = x + 2e-4 * normal(&mut rng);
        if t == 1499 {
            break;
        }
        let time = DT * t as f64;
        let place = 0.3 * (0.7 * time).sin() + 0.2 * (1.9 * time + 0.5).cos();
        let u = (1.6 * (place - x) - 0.5 * v).clamp(-0.6, 0.6);
        controls[[t, 0]] = u;
        for _ in 0..PARTS {
            let h = DT / PARTS as f64;
            let rate = |v: f64| 6.2 * u.sin() - 0.13 * v;
            let middle = v + 0.5 * h * rate(v);
            (x, v) = (x + h * middle, v + h * rate(middle));
        }
    }
    Recording::even(DT, states, Some(controls))
}

#[test]
fn a_rate_that_was_not_measured_makes_up_for_no_term() {
    for seed in 0..3 {
        let mut spec = spec(&[("x", Kind::Plain), ("v", Kind::RateOf(0))], DT);
        spec.control[0].unit = "rad".into();
        let found = Identifier::new(&spec).identify_recordings(&[ball(seed)]).expect("equations");
        let report = &found.report.equations[1];
        assert!(report.doubt.is_none(), "{seed}: {}", found.model);
        let terms: Vec<&str> = report.support.iter().map(|&j| found.report.features[j].as_str()).collect();
        assert_eq!(terms, ["v", "sin u"], "{seed}");
        for ((found, error), truth) in report.coefficients.iter().zip(&report.standard_errors).zip([-0.13, 6.2]) {
            assert!((found - truth).abs() < 4.0 * error, "{seed}: {found} ± {error}, not {truth}");
        }
    }
}
