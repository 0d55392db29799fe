//! Stops, dead zones and friction: terms with kinks and jumps, in noise and in what simulators with fixed steps make of them.

mod recorded;

use ndarray::Array2;
use rand::RngExt as _;
use sindyna_core::{Kind, Seed, Spec};
use sindyna_sindy::{Identified, Identifier, Recording};

type Field = fn(f64, f64, f64) -> f64;

const DT: f64 = 0.04;

/// A mass.
fn spec() -> Spec {
    recorded::spec(&[("x", Kind::Plain), ("v", Kind::RateOf(0))], DT)
}

/// A mass that `field` accelerates, in four recordings of 75 samples: four classical Runge–Kutta steps from sample to sample, over kinks as over anything. `noise`
/// in standard deviations of each state.
fn record(field: Field, noise: f64, seed: u64) -> Vec<Recording> {
    let mut rng = Seed::new(seed).stream("kinks", 0);
    let mut recordings = Vec::new();
    for _ in 0..4 {
        let mut x = [2.0 * rng.random::<f64>() - 1.0, 4.0 * rng.random::<f64>() - 2.0];
        let mut states = Array2::zeros((75, 2));
        let mut controls = Array2::zeros((74, 1));
        for t in 0..75 {
            states.row_mut(t).assign(&ndarray::aview1(&x));
            if t == 74 {
                break;
            }
            let u = 6.0 * rng.random::<f64>() - 3.0;
            controls[[t, 0]] = u;
            let h = DT / 4.0;
            for _ in 0..4 {
                let rate = |k: [f64; 2], c: f64| {
                    let (x, v) = (x[0] + c * k[0], x[1] + c * k[1]);
                    [v, field(x, v, u)]
                };
                let k1 = rate([0.0; 2], 0.0);
                let k2 = rate(k1, 0.5 * h);
                let k3 = rate(k2, 0.5 * h);
                let k4 = rate(k3, h);
                (0..2).for_each(|i| x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            }
        }
        recordings.push((states, controls));
    }
    let deviation = |i: usize| {
        let all: Vec<f64> = recordings.iter().flat_map(|(s, _)| s.column(i).to_vec()).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        (all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt()
    };
    let sigma = [0, 1].map(|i| noise * deviation(i));
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    for (states, _) in &mut recordings {
        for mut row in states.rows_mut() {
            (0..2).for_each(|i| row[i] += sigma[i] * normal());
        }
    }
    recordings.into_iter().map(|(states, controls)| Recording::even(DT, states, Some(controls))).collect()
}

/// Terms of v̇ with their coefficients, and the parameters inside them.
fn found(field: Field, noise: f64, seed: u64) -> (Identified, Vec<(String, f64)>, Vec<f64>) {
    let found = Identifier::new(&spec()).identify_recordings(&record(field, noise, seed)).expect("equations");
    let report = &found.report.equations[1];
    let terms = report.support.iter().map(|&j| found.report.features[j].clone());
    let terms = terms.zip(report.coefficients.iter().copied()).collect();
    let inside = report.parameters.iter().map(|p| p.value).collect();
    (found, terms, inside)
}

/// Whether the terms whose names begin so, and no others, have these coefficients but for a part of them.
fn assert_terms(terms: &[(String, f64)], truth: &[(&str, f64)], within: f64) {
    assert_eq!(terms.len(), truth.len(), "{terms:?}");
    for (name, value) in truth {
        let Some((_, own)) = terms.iter().find(|(n, _)| n.starts_with(name)) else { panic!("no {name}: {terms:?}") };
        assert!((own / value - 1.0).abs() < within, "{name} {value}: {own}");
    }
}

fn stop(x: f64, v: f64, u: f64) -> f64 {
    -2.0 * x - 20.0 * (x - 0.4).max(0.0) - 0.3 * v + u
}

fn stop_below(x: f64, v: f64, u: f64) -> f64 {
    -2.0 * x + 20.0 * (-0.4 - x).max(0.0) - 0.3 * v + u
}

fn clearance(x: f64, v: f64, u: f64) -> f64 {
    -15.0 * ((x - 0.3).max(0.0) - (-0.3 - x).max(0.0)) - 0.4 * v + u
}

#[test]
fn a_stop_is_found_with_its_place() {
    for seed in 0..3 {
        let (found, terms, inside) = found(stop, 0.01, seed);
        assert_terms(&terms, &[("x", -2.0), ("v", -0.3), ("u", 1.0), ("max(x", -20.0)], 0.2);
        assert!((inside[0] - 0.4).abs() < 0.02, "{inside:?}");
        assert_eq!(found.report.equations[1].doubt, None);
    }
}

#[test]
fn a_stop_on_the_other_side_is_written_from_there() {
    let (_, terms, inside) = found(stop_below, 0.01, 0);
    assert_eq!(inside.len(), 1);
    assert_terms(&terms, &[("x", -2.0), ("v", -0.3), ("u", 1.0), ("max(−0.", 20.0)], 0.2);
    assert!((inside[0] + 0.4).abs() < 0.02, "{inside:?}");
}

#[test]
fn clearance_is_one_term() {
    let (_, terms, inside) = found(clearance, 0.01, 0);
    assert_terms(&terms, &[("v", -0.4), ("u", 1.0), ("max(x", -15.0)], 0.1);
    assert!((inside[0] - 0.3).abs() < 0.02, "{inside:?}");
}

fn friction(x: f64, v: f64, u: f64) -> f64 {
    -9.0 * x - 0.5 * v.signum() + 2.0 * u
}

/// The simulator steps over kinks as over anything; so does the model, once its steps are those of the simulator.
#[test]
fn without_noise_all_is_exact_over_kinks_too() {
    for seed in 0..2 {
        let (found, terms, inside) = found(stop, 0.0, seed);
        assert_terms(&terms, &[("x", -2.0), ("v", -0.3), ("u", 1.0), ("max(x", -20.0)], 1e-6);
        assert!((inside[0] - 0.4).abs() < 1e-6, "{inside:?}");
        let report = &found.report;
        assert!(
            report.equations[1].reached_floor && report.rows_astray == 0,
            "{:?} {}",
            report.equations[1].doubt,
            report.rows_astray
        );
        let (_, terms, _) = self::found(friction, 0.0, seed);
        assert_terms(&terms, &[("x", -9.0), ("sign v", -0.5), ("u", 2.0)], 1e-6);
    }
}
