//! Inputs that are linear between samples, as those of a generator with a smooth signal are nearly.

use ndarray::{Array2, s};
use rand::RngExt as _;
use sindyna_core::{Channel, InterSample, Kind, Precision, Seed, Space, Spec};
use sindyna_sindy::{Doubt, Identified, Identifier, LibraryChoice, NoiseChoice, Recording};

const DT: f64 = 0.1;

fn spec() -> Spec {
    let x = Channel::new("x", "m", Kind::Plain, 1.0);
    let v = Channel::new("v", "m/s", Kind::RateOf(0), 1.0);
    Spec {
        name: "duffing".into(),
        observation: vec![x.clone(), v.clone()],
        state: vec![x, v],
        control: vec![Channel::new("u", "N", Kind::Plain, 1.0)],
        action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt: DT,
    }
}

/// v̇ = −4 x − 0.5 v − 2 x³ + 3 u under inputs that are drawn at every sample and linear between: samples of position and speed, the position with an error of
/// `noise` \[m\].
fn duffing(samples: usize, noise: f64) -> Recording {
    const PARTS: usize = 50;
    let mut rng = Seed::new(7).stream("duffing", 0);
    let u: Vec<f64> = (0..samples).map(|_| rng.random_range(-1.0..1.0)).collect();
    let (mut x, mut states) = ([0.3, 0.0], Array2::zeros((samples, 2)));
    for t in 0..samples {
        let error = noise * (0..12).map(|_| rng.random::<f64>() - 0.5).sum::<f64>();
        states.row_mut(t).iter_mut().zip([x[0] + error, x[1]]).for_each(|(slot, v)| *slot = v);
        let slope = u.get(t + 1).map_or(0.0, |next| (next - u[t]) / DT);
        let rate =
            |[x, v]: [f64; 2], time: f64| [v, -4.0 * x - 0.5 * v - 2.0 * x.powi(3) + 3.0 * (u[t] + slope * time)];
        let h = DT / PARTS as f64;
        for part in 0..PARTS {
            let time = part as f64 * h;
            let at = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
            let k1 = rate(x, time);
            let k2 = rate(at(k1, 0.5 * h), time + 0.5 * h);
            let k3 = rate(at(k2, 0.5 * h), time + 0.5 * h);
            let k4 = rate(at(k3, h), time + h);
            for i in 0..2 {
                x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
        }
    }
    let controls = Array2::from_shape_fn((samples - 1, 1), |(t, _)| u[t]);
    Recording::even(DT, states, Some(controls))
}

fn identified(recording: Recording) -> Identified {
    let identifier = Identifier::new(&spec()).with_noise(NoiseChoice::Estimated);
    identifier.identify_recordings(&[recording]).expect("equations")
}

/// The coefficients of v̇ by the names of their terms.
fn coefficients(found: &Identified) -> Vec<(String, f64)> {
    let names = ["x", "v", "u"].map(String::from);
    let term = |term: usize| found.model.terms()[term].display(&names).to_string();
    found.model.coefficients(1).iter().map(|e| (term(e.term), e.coefficient)).collect()
}

#[test]
fn equations_under_first_order_hold_are_exact() {
    let recording = duffing(200, 0.0).with_intersample(InterSample::Foh);
    let found = identified(recording.clone());
    let coefficients = coefficients(&found);
    for (term, truth) in [("x", -4.0), ("v", -0.5), ("x^3", -2.0), ("u", 3.0)] {
        let (_, value) =
            coefficients.iter().find(|(name, _)| name == term).unwrap_or_else(|| panic!("{coefficients:?}"));
        assert!((value / truth - 1.0).abs() < 1e-6, "{term}: {value}");
    }
    assert_eq!(coefficients.len(), 4, "{coefficients:?}");

    let steps = recording.steps();
    assert_eq!(steps, 198, "of the last step the input at its end is not known");
    let ahead = found.model.simulate(&recording.states.row(0).to_vec(), recording.inputs(0, steps)).expect("finite");
    let worst = (&ahead - &recording.states.slice(s![..=steps, ..])).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(worst < 1e-5, "{worst}");
}

#[test]
fn speeds_that_were_not_measured_are_found_under_first_order_hold() {
    let mut recording = duffing(600, 1e-4).with_intersample(InterSample::Foh);
    recording.states.column_mut(1).fill(f64::NAN);
    let found = identified(recording);
    let coefficients = coefficients(&found);
    for (term, truth) in [("x", -4.0), ("v", -0.5), ("x^3", -2.0), ("u", 3.0)] {
        let (_, value) =
            coefficients.iter().find(|(name, _)| name == term).unwrap_or_else(|| panic!("{coefficients:?}"));
        assert!((value / truth - 1.0).abs() < 0.05, "{term}: {value}");
    }
}

#[test]
fn held_inputs_in_their_place_leave_what_no_term_explains() {
    let found = identified(duffing(600, 1e-4));
    assert!(found.report.equations[1].is_spoilt(), "{:?}", found.report.equations[1].doubt);
}

/// ẋ = −60 x + 45 u under a slow input, a pole that is faster than the samples, and noise: samples of x, with inputs that are held or linear between them.
fn fast(intersample: InterSample) -> (Spec, Recording) {
    const SAMPLES: usize = 800;
    const FAST: f64 = 0.025;
    let mut rng = Seed::new(9).stream("fast", 0);
    let u = |t: usize| (0.21 * t as f64).sin() + 0.7 * (0.083 * t as f64).cos() + 0.4 * (0.47 * t as f64).sin();
    let (mut x, mut states) = (0.5, Array2::zeros((SAMPLES, 1)));
    for t in 0..SAMPLES {
        states[[t, 0]] = x + 0.01 * (0..12).map(|_| rng.random::<f64>() - 0.5).sum::<f64>();
        // Of ẋ = −a x + b (u + s τ): a particular solution that is linear in τ, and what decays.
        let (a, b) = (60.0, 45.0);
        let s = if intersample == InterSample::Foh { (u(t + 1) - u(t)) / FAST } else { 0.0 };
        let particular = |time: f64| b / a * (u(t) + s * time) - b * s / (a * a);
        x = particular(FAST) + (x - particular(0.0)) * (-a * FAST).exp();
    }
    let controls = Array2::from_shape_fn((SAMPLES - 1, 1), |(t, _)| u(t));
    let x = Channel::new("x", "m", Kind::Plain, 1.0);
    let spec = Spec { observation: vec![x.clone()], state: vec![x], dt: FAST, ..spec() };
    (spec, Recording::even(FAST, states, Some(controls)))
}

#[test]
fn inputs_that_are_not_held_are_doubted_where_poles_are_faster_than_samples() {
    for intersample in [InterSample::Zoh, InterSample::Foh] {
        let (spec, recording) = fast(intersample);
        let library = LibraryChoice::Terms(vec!["x".into(), "u".into()]);
        let identifier = Identifier::new(&spec).with_noise(NoiseChoice::Estimated).with_library(library);
        let found = identifier.expect("terms").identify_recordings(&[recording]).expect("equations");
        let doubt = found.report.equations[0].doubt;
        let is_doubted = matches!(doubt, Some(Doubt::Correlated | Doubt::NotHeld));
        assert_eq!(is_doubted, intersample == InterSample::Foh, "{doubt:?}: {:?}", found.model.equations());
    }
}
