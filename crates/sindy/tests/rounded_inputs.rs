//! Logs whose columns were all written with a few decimals: the inputs are rounded like the states.

use ndarray::Array2;
use rand::RngExt as _;
use rand_distr::StandardNormal;
use sindyna_core::{Channel, Kind, Precision, Rng, Seed, Space, Spec};
use sindyna_sindy::{Identified, Identifier, Recording};

/// Rates of the states under an input.
type Rates = dyn Fn([f64; 2], f64) -> [f64; 2];

/// A motor of 2 states, a current and a speed, or a mass on a spring, whose states are position and speed.
fn spec(names: [&str; 2], is_rate: bool, dt: f64, (of_states, step): (f64, f64)) -> Spec {
    let mut first = Channel::new(names[0], "", Kind::Plain, 1.0);
    let mut second = Channel::new(names[1], "", if is_rate { Kind::RateOf(0) } else { Kind::Plain }, 1.0);
    (first.prior.resolution, second.prior.resolution) = (of_states, of_states);
    let mut u = Channel::new("u", "", Kind::Plain, 1.0);
    u.prior.written = step;
    Spec {
        name: "rounded".into(),
        observation: vec![first.clone(), second.clone()],
        state: vec![first, second],
        control: vec![u],
        action_space: Space::Box { low: vec![-10.0], high: vec![10.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt,
    }
}

fn rounded(v: f64, step: f64) -> f64 {
    (v / step).round() * step
}

/// `samples` of a system from rest, `dt` \[s\] apart, under inputs within ± `u` that are held for `held` samples, all rounded to `step`.
fn log(
    rates: &Rates,
    (samples, dt): (usize, f64),
    (u, held): (f64, std::ops::Range<usize>),
    step: f64,
    rng: &mut Rng,
) -> Recording {
    const PARTS: usize = 20;
    let (mut x, mut input, mut left) = ([0.0, 0.0], 0.0, 0);
    let mut states = Array2::zeros((samples, 2));
    let mut controls = Array2::zeros((samples - 1, 1));
    for t in 0..samples {
        states.row_mut(t).iter_mut().zip(x).for_each(|(slot, v)| *slot = rounded(v, step));
        if left == 0 {
            (input, left) = (rng.random_range(-u..u), rng.random_range(held.clone()));
        }
        left -= 1;
        if t + 1 < samples {
            controls[[t, 0]] = rounded(input, step);
        }
        let h = dt / PARTS as f64;
        for _ in 0..PARTS {
            let at = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
            let k1 = rates(x, input);
            let k2 = rates(at(k1, 0.5 * h), input);
            let k3 = rates(at(k2, 0.5 * h), input);
            let k4 = rates(at(k3, h), input);
            (0..2).for_each(|i| x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
    }
    Recording::even(dt, states, Some(controls))
}

/// Terms, coefficients and standard errors of equation `i`.
fn equation(found: &Identified, i: usize) -> Vec<(String, f64, f64)> {
    let equation = &found.report.equations[i];
    let names = equation.support.iter().map(|&j| found.report.features[j].clone());
    let told = names.zip(&equation.coefficients).zip(&equation.standard_errors);
    told.map(|((term, c), e)| (term, *c, *e)).collect()
}

/// Counts in `z` how far the coefficients of equation `i` are from `truth`, in standard errors.
fn compare(found: &Identified, i: usize, truth: &[(&str, f64)], z: &mut Vec<f64>, context: &str) {
    let told = equation(found, i);
    assert_eq!(told.len(), truth.len(), "{context}\n{found}");
    for (name, value) in truth {
        let (_, c, error) = told.iter().find(|t| t.0 == *name).unwrap_or_else(|| panic!("{context} {name}\n{found}"));
        z.push((c - value) / error);
    }
}

#[test]
fn a_motor_has_its_equations_however_many_decimals_were_written() {
    let mut z = Vec::new();
    for step in [1e-2, 1e-3, 1e-4, 1e-6] {
        for seed in 100..104 {
            let mut rng = Seed::new(seed).stream("motor", 0);
            let [r, k, v, m, b] =
                [150.0..350.0, 8.0..20.0, 120.0..280.0, 200.0..400.0, 0.3..1.5].map(|r| rng.random_range(r));
            let rates = move |x: [f64; 2], u: f64| [-r * x[0] - k * x[1] + v * u, m * x[0] - b * x[1]];
            let recording = log(&rates, (1000, 0.001), (10.0, 10..60), step, &mut rng);
            let found = Identifier::new(&spec(["i", "w"], false, 0.001, (step, step)))
                .identify_recordings(&[recording])
                .expect("equations");
            let context = format!("{step} {seed} {:?}", [r, k, v, m, b]);
            assert!(found.report.equations.iter().all(|e| e.doubt.is_none()), "{context}\n{found}");
            compare(&found, 0, &[("i", -r), ("w", -k), ("u", v)], &mut z, &context);
            compare(&found, 1, &[("i", m), ("w", -b)], &mut z, &context);
            assert!(
                found.report.warnings.iter().any(|w| w.contains("the input `u` is taken as rounded")),
                "{context}\n{found}"
            );
        }
    }
    // What is not known of the inputs is not known of the coefficients.
    let covered = z.iter().filter(|z| z.abs() < 1.96).count() as f64 / z.len() as f64;
    let spread = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
    assert!(covered > 0.85 && spread < 1.3, "{covered} {spread} {z:?}");
}

#[test]
fn what_an_input_does_beside_its_gain_is_not_taken_for_rounding() {
    for (step, cube) in [(1e-2, 0.03), (1e-3, 0.02), (1e-4, 0.005)] {
        for seed in 110..113 {
            let mut rng = Seed::new(seed).stream("spring", 0);
            let (k, d) = (rng.random_range(5.0..12.0), rng.random_range(0.2..0.6));
            let rates = move |x: [f64; 2], u: f64| [x[1], -k * x[0] - d * x[1] + 4.0 * u + cube * u.powi(3)];
            let recording = log(&rates, (1000, 0.02), (2.0, 5..40), step, &mut rng);
            let found = Identifier::new(&spec(["x", "v"], true, 0.02, (step, step)))
                .identify_recordings(&[recording])
                .expect("equations");
            let told = equation(&found, 1);
            let term = told.iter().find(|(name, ..)| name == "u³");
            let (_, c, error) = term.unwrap_or_else(|| panic!("{step} {seed}\n{found}"));
            assert!((c - cube).abs() < 4.0 * error, "{step} {seed} {c} {error}\n{found}");
        }
    }
}

#[test]
fn settings_of_a_few_digits_are_exact() {
    for seed in 120..123 {
        let mut rng = Seed::new(seed).stream("spring", 0);
        let rates = |x: [f64; 2], u: f64| [x[1], -9.0 * x[0] - 0.3 * x[1] + 4.0 * rounded(u, 0.01)];
        let mut recording = log(&rates, (600, 0.02), (2.0, 5..40), 1e-6, &mut rng);
        recording.controls.mapv_inplace(|u| rounded(u, 0.01));
        let found = Identifier::new(&spec(["x", "v"], true, 0.02, (1e-6, 0.01)))
            .identify_recordings(&[recording])
            .expect("equations");
        assert!(found.report.warnings.is_empty(), "{seed}\n{found}");
        let told = equation(&found, 1);
        assert!(
            told.len() == 3 && told.iter().any(|(name, c, _)| name == "u" && (c - 4.0).abs() < 1e-4),
            "{seed}\n{found}"
        );
    }
}

#[test]
fn errors_of_inputs_too_small_to_be_told_are_in_the_standard_errors() {
    const NOISE: f64 = 2e-3;
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for step in [1e-3, 3e-3, 6e-3] {
        for seed in 130..134 {
            let mut rng = Seed::new(seed).stream("spring", 0);
            let (k, d, b) = (rng.random_range(5.0..12.0), rng.random_range(0.2..0.6), rng.random_range(2.0..6.0));
            let rates = move |x: [f64; 2], u: f64| [x[1], -k * x[0] - d * x[1] + b * u];
            let mut recording = log(&rates, (1000, 0.02), (2.0, 5..40), 1e-9, &mut rng);
            recording.controls.mapv_inplace(|u| rounded(u, step));
            for v in &mut recording.states {
                *v = rounded(*v + NOISE * rng.sample::<f64, _>(StandardNormal), 1e-9);
            }
            for (written, z) in [(step, &mut with), (0.0, &mut without)] {
                let found = Identifier::new(&spec(["x", "v"], true, 0.02, (1e-9, written)))
                    .identify_recordings(&[recording.clone()])
                    .expect("equations");
                let truth = [("x", -k), ("v", -d), ("u", b)];
                if equation(&found, 1).iter().all(|(name, ..)| truth.iter().any(|(own, _)| own == name)) {
                    compare(&found, 1, &truth, z, &format!("{step} {seed} {:?}", [k, d, b]));
                }
            }
        }
    }
    let spread = |z: &[f64]| (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
    let covered = with.iter().filter(|z| z.abs() < 1.96).count() as f64 / with.len() as f64;
    assert!(covered > 0.75 && spread(&with) < 1.5, "{covered} {} {with:?}", spread(&with));
    assert!(spread(&without) > 1.5, "otherwise they are not: {without:?}");
}
