//! Recordings of equations written out, with noise, and what was found in them beside the truth.

#![allow(dead_code, reason = "no test uses all of it")]

use ndarray::Array2;
use rand::RngExt as _;
use sindyna_core::{Channel, Kind, Precision, Rng, Seed, Space, Spec};
use sindyna_sindy::{Identified, Recording};

pub(crate) type Field = fn(&[f64], f64) -> Vec<f64>;

pub(crate) fn normal(rng: &mut Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

pub(crate) fn spec(kinds: &[(&str, Kind)], dt: f64) -> Spec {
    let state: Vec<Channel> = kinds.iter().map(|(name, kind)| Channel::new(name, "", *kind, 1.0)).collect();
    Spec {
        name: "recording".into(),
        observation: state.clone(),
        state,
        control: vec![Channel::new("u", "", Kind::Plain, 1.0)],
        action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt,
    }
}

/// `samples` samples of `field` from `start`, about `dt` apart, under random inputs, each state with noise of `noise` times its standard
/// deviation and multiplied by `unit`.
pub(crate) fn record(
    field: Field,
    start: &[f64],
    samples: (usize, f64),
    errors: (f64, f64, bool),
    seed: u64,
) -> Recording {
    record_held(field, start, samples, errors, 1, seed)
}

/// The same under inputs that change every `hold` samples.
pub(crate) fn record_held(
    field: Field,
    start: &[f64],
    (samples, dt): (usize, f64),
    (noise, unit, uneven): (f64, f64, bool),
    hold: usize,
    seed: u64,
) -> Recording {
    const PARTS: usize = 40;
    let mut rng = Seed::new(seed).stream("recording", 0);
    let n = start.len();
    let mut x = start.to_vec();
    let mut times = vec![0.0];
    let mut states = Array2::zeros((samples, n));
    let mut controls = Array2::zeros((samples - 1, 1));
    let mut u = 0.0;
    for t in 0..samples {
        (0..n).for_each(|i| states[[t, i]] = x[i]);
        if t + 1 == samples {
            break;
        }
        if t % hold == 0 {
            u = 2.0 * rng.random::<f64>() - 1.0;
        }
        let step = if uneven { dt * (0.3 + 1.4 * rng.random::<f64>()) } else { dt };
        controls[[t, 0]] = u;
        let h = step / PARTS as f64;
        for _ in 0..PARTS {
            let at = |k: &[f64], c: f64| x.iter().zip(k).map(|(x, k)| x + c * k).collect::<Vec<_>>();
            let k1 = field(&x, u);
            let k2 = field(&at(&k1, 0.5 * h), u);
            let k3 = field(&at(&k2, 0.5 * h), u);
            let k4 = field(&at(&k3, h), u);
            (0..n).for_each(|i| x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        times.push(if uneven { times[t] + step } else { (t + 1) as f64 * dt });
    }
    for i in 0..n {
        let mean = states.column(i).sum() / samples as f64;
        let spread = (states.column(i).iter().map(|v: &f64| (v - mean).powi(2)).sum::<f64>() / samples as f64).sqrt();
        states.column_mut(i).mapv_inplace(|v| unit * (v + noise * spread * normal(&mut rng)));
    }
    Recording::new(times, states, controls)
}

/// Terms and coefficients of equation `i`, by name.
pub(crate) fn equation(found: &Identified, i: usize) -> Vec<(&str, f64)> {
    let report = &found.report.equations[i];
    let mut terms: Vec<(&str, f64)> = report
        .support
        .iter()
        .map(|&j| found.report.features[j].as_str())
        .zip(report.coefficients.iter().copied())
        .collect();
    terms.sort_by_key(|t| t.0);
    terms
}

pub(crate) fn assert_equation(found: &Identified, i: usize, truth: &[(&str, f64)], within: f64) {
    let terms = equation(found, i);
    let mut truth = truth.to_vec();
    truth.sort_by_key(|t| t.0);
    assert_eq!(terms.iter().map(|t| t.0).collect::<Vec<_>>(), truth.iter().map(|t| t.0).collect::<Vec<_>>());
    for ((name, c), (_, t)) in terms.iter().zip(&truth) {
        assert!((c / t - 1.0).abs() < within, "{name}: {c}, not {t}");
    }
}
