//! Equations of motion by the default target, against systems whose equations are written out here.

mod common;

use common::{Truth, record, uniform};
use sindyna_core::{Channel, Dataset, Kind, Precision, Rng, Space, Spec};
use sindyna_sindy::{Form, Identified, Identifier};

fn identify(spec: &Spec, data: &Dataset) -> Identified {
    Identifier::new(spec).identify(data).expect("enough rows")
}

/// Checks that equation `i` has exactly the terms of `truth`, each coefficient to the relative accuracy `within`.
fn assert_terms(found: &Identified, i: usize, truth: &[(&str, f64)], within: f64) {
    let report = &found.report.equations[i];
    let name = |j: &usize| found.report.features[*j].as_str();
    let mut terms: Vec<(&str, f64)> =
        report.support.iter().map(name).zip(report.coefficients.iter().copied()).collect();
    let mut truth = truth.to_vec();
    terms.sort_by_key(|t| t.0);
    truth.sort_by_key(|t| t.0);
    let names = |list: &[(&str, f64)]| list.iter().map(|t| t.0.to_owned()).collect::<Vec<_>>();
    assert_eq!(names(&terms), names(&truth), "{}", found.model);
    for ((term, coefficient), (_, true_one)) in terms.iter().zip(&truth) {
        assert!((coefficient / true_one - 1.0).abs() < within, "{term}: {coefficient}, not {true_one}");
    }
    assert!(report.reached_floor, "{}", found.model);
}

/// A push to each side for four steps, of a size that changes with every step.
fn swing(reach: f64) -> impl Fn(&mut Rng, usize) -> f64 {
    move |rng, i| {
        if (i / 4).is_multiple_of(2) { uniform(rng, 0.5, 1.0) * reach } else { -uniform(rng, 0.5, 1.0) * reach }
    }
}

#[test]
fn a_cart_with_a_pole_is_found_from_ten_steps() {
    // (4/3) l ω̇ = g sin θ − cos θ v̇ and (M + m) v̇ = F + m l (ω² sin θ − cos θ ω̇).
    let per_length = 1.0 / (0.5 * 4.0 / 3.0);
    for seed in 0..5 {
        let start = |rng: &mut Rng| (0..4).map(|_| uniform(rng, -0.05, 0.05)).collect();
        let data = record(&common::cart_pole(), seed, 10, start, |rng, i| swing(10.0)(rng, i), |x| x[2].abs() > 0.2);
        let found = identify(&common::cart_pole().spec, &data);
        let push = [("u", 1.0 / 1.1), ("ω²·sin θ", 0.05 / 1.1), ("cos θ·dω/dt", -0.05 / 1.1)];
        assert_terms(&found, 1, &push, 1e-2);
        assert_terms(&found, 3, &[("sin θ", 9.8 * per_length), ("cos θ·dv/dt", -per_length)], 1e-4);
    }
}

#[test]
fn an_angle_whose_zero_is_off_is_told_with_its_offset() {
    const MASSES: f64 = 10.471_975_5 + 5.018_591_6;
    const MOMENT: f64 = 5.018_591_6 * 0.300_000_42;
    const INERTIA: f64 = 0.188_749_77 + MOMENT * 0.300_000_42;
    for seed in 0..5 {
        let start = |rng: &mut Rng| (0..4).map(|_| uniform(rng, -0.01, 0.01)).collect();
        let truth = common::inverted_pendulum();
        let data = record(&truth, seed, 10, start, |rng, i| swing(3.0)(rng, i), |x| x[1].abs() > 0.2);
        let found = identify(&truth.spec, &data);
        assert!((found.model.offsets()[1] - 0.001_666_67).abs() < 1e-12, "{}", found.model);
        let cart = [
            ("v", -1.0 / MASSES),
            ("u", 100.0 / MASSES),
            ("ω²·sin θ", MOMENT / MASSES),
            ("cos θ·dω/dt", -MOMENT / MASSES),
        ];
        let pole = [("ω", -1.0 / INERTIA), ("sin θ", 9.81 * MOMENT / INERTIA), ("cos θ·dv/dt", -MOMENT / INERTIA)];
        assert_terms(&found, 2, &cart, 1e-9);
        assert_terms(&found, 3, &pole, 1e-9);
    }
}

/// Lorenz's equations with a push on the first, sampled every 0.02 s, float64.
fn pushed_lorenz() -> Truth {
    let channel = |name: &str| Channel::new(name, "", Kind::Plain, 20.0);
    let state = vec![channel("x"), channel("y"), channel("z")];
    let spec = Spec {
        name: "lorenz".into(),
        observation: state.clone(),
        state,
        control: vec![Channel::new("u", "", Kind::Plain, 20.0)],
        action_space: Space::Box { low: vec![-20.0], high: vec![20.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt: 0.02,
    };
    let step = |x: &[f64], u: &[f64]| {
        let field =
            |x: &[f64]| [10.0 * (x[1] - x[0]) + u[0], x[0] * (28.0 - x[2]) - x[1], x[0] * x[1] - 8.0 / 3.0 * x[2]];
        let at = |x: &[f64], k: &[f64; 3], c: f64| x.iter().zip(k).map(|(x, k)| x + c * k).collect::<Vec<_>>();
        let (mut x, h) = (x.to_vec(), 0.02 / 8.0);
        for _ in 0..8 {
            let k1 = field(&x);
            let k2 = field(&at(&x, &k1, 0.5 * h));
            let k3 = field(&at(&x, &k2, 0.5 * h));
            let k4 = field(&at(&x, &k3, h));
            (0..3).for_each(|i| x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        x
    };
    Truth { spec, step }
}

#[test]
fn a_continuous_system_without_declared_rates_is_found_through_the_integrator() {
    let truth = pushed_lorenz();
    let data = record(&truth, 1, 100, |_| vec![-8.0, 8.0, 27.0], |rng, _| uniform(rng, -20.0, 20.0), |_| false);
    let found = identify(&truth.spec, &data);
    assert_terms(&found, 0, &[("x", -10.0), ("y", 10.0), ("u", 1.0)], 1e-9);
    assert_terms(&found, 1, &[("x", 28.0), ("y", -1.0), ("x·z", -1.0)], 1e-9);
    assert_terms(&found, 2, &[("z", -8.0 / 3.0), ("x·y", 1.0)], 1e-9);
}

#[test]
fn samples_of_a_linear_system_are_not_taken_for_euler_steps() {
    // ẋ = −x + u, sampled every 0.1 s: x⁺ = a x + (1 − a) u with a = exp(−0.1), which Euler steps of other coefficients give too.
    let mut truth = pushed_lorenz();
    truth.spec.state.truncate(1);
    truth.spec.observation.truncate(1);
    truth.spec.dt = 0.1;
    truth.step = |x, u| {
        let a = (-0.1_f64).exp();
        vec![a * x[0] + (1.0 - a) * u[0]]
    };
    let data = record(&truth, 1, 60, |_| vec![1.0], |rng, _| uniform(rng, -1.0, 1.0), |_| false);
    let found = identify(&truth.spec, &data);
    assert_terms(&found, 0, &[("x", -1.0), ("u", 1.0)], 1e-8);
    for (coefficient, error) in
        found.report.equations[0].coefficients.iter().zip(&found.report.equations[0].standard_errors)
    {
        assert!((coefficient.abs() - 1.0).abs() < 5.0 * error, "{coefficient} ± {error}");
    }
}

#[test]
fn terms_that_the_data_cannot_tell_apart_are_reported() {
    // A pendulum that hardly swings, seen as float32: the restoring torque may be any of several waves.
    let start = |_: &mut Rng| vec![1e-5, 0.0];
    let mut truth = common::pendulum();
    truth.step = |x, u| {
        let rate = x[1] + 0.05 * (-15.0 * x[0].sin() + 3.0 * u[0]);
        vec![x[0] + 0.05 * rate, rate]
    };
    let data = record(&truth, 3, 12, start, |rng, _| uniform(rng, -1e-5, 1e-5), |_| false);
    let found = identify(&truth.spec, &data);
    let report = &found.report.equations[1];
    let name = |j: &usize| found.report.features[*j].as_str();
    let sets = || std::iter::once(&report.support).chain(&report.equally_good);
    let shown = |wanted: &str| sets().any(|set| set.len() == 2 && set.iter().any(|j| name(j) == wanted));
    assert!(shown("sin θ") && shown("sin 2θ"), "{}: {:?}", found.model, report.equally_good);
}

#[test]
fn noise_does_not_hide_a_declared_limit() {
    let mut truth = common::pendulum();
    truth.spec.noise = 0.01;
    let start = |rng: &mut Rng| vec![uniform(rng, -1.0, 1.0), uniform(rng, 4.0, 7.0)];
    for seed in 0..5 {
        let data = record(&truth, seed, 200, start, |rng, i| swing(2.0)(rng, i), |x| x[1].abs() >= 8.0);
        let found = identify(&truth.spec, &data);
        assert!(found.report.rows_at_limit > 0);
        assert_terms(&found, 1, &[("sin θ", 15.0), ("u", 3.0)], 0.05);
    }
}

/// A log of one rollout: channels with their roles, and the samples that `step` makes from `start` under random inputs.
fn logged(
    state: Vec<Channel>,
    dt: f64,
    steps: usize,
    scales: &[f64],
    start: &[f64],
    step: impl Fn(&mut [f64], f64),
) -> (Spec, Dataset) {
    let spec = Spec {
        name: "log".into(),
        observation: state.clone(),
        state,
        control: vec![Channel::new("u", "", Kind::Plain, 1.0)],
        action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt,
    };
    let mut rng = sindyna_core::Seed::new(5).stream("inputs", 0);
    let scaled = |x: &[f64]| x.iter().zip(scales).map(|(x, s)| x * s).collect::<Vec<_>>();
    let mut data = Dataset::new(start.len(), 1, 1, dt);
    let mut x = start.to_vec();
    data.begin(&scaled(&x)).expect("finite states");
    for _ in 0..steps {
        let u = uniform(&mut rng, -1.0, 1.0);
        step(&mut x, u);
        data.push(&[u], &[u], 0.0, &scaled(&x)).expect("finite states");
    }
    (spec, data)
}

#[test]
fn units_of_nanometres_change_no_coefficient() {
    for s in [1e-12, 1e-9, 1.0, 1e9] {
        let channels = vec![Channel::new("x", "", Kind::Plain, s), Channel::new("v", "", Kind::RateOf(0), s)];
        let (spec, data) = logged(channels, 0.01, 200, &[s, s], &[1.0, 0.0], |x, u| {
            x[1] += 0.01 * (-4.0 * x[0] - 0.5 * x[1] - 0.3 * x[0] * x[1] + 2.0 * u);
            x[0] += 0.01 * x[1];
        });
        let found = identify(&spec, &data);
        assert_terms(&found, 1, &[("x", -4.0), ("v", -0.5), ("x·v", -0.3 / s), ("u", 2.0 * s)], 1e-6);
    }
}

#[test]
fn a_chain_of_rates_is_stepped_from_the_last_rate_to_the_first() {
    let channel = |name: &str, kind| Channel::new(name, "", kind, 1.0);
    let channels = vec![channel("x", Kind::Plain), channel("v", Kind::RateOf(0)), channel("a", Kind::RateOf(1))];
    let (spec, data) = logged(channels, 0.05, 400, &[1.0; 3], &[0.3, -0.1, 0.2], |x, u| {
        x[2] += 0.05 * (-2.0 * x[2] - 3.0 * x[1] - 1.5 * x[0] + 2.0 * u);
        x[1] += 0.05 * x[2];
        x[0] += 0.05 * x[1];
    });
    let found = identify(&spec, &data);
    assert_terms(&found, 2, &[("a", -2.0), ("v", -3.0), ("x", -1.5), ("u", 2.0)], 1e-9);
    // The model is the map that made the data.
    let mut next = [0.0; 3];
    let mut rng = sindyna_core::Seed::new(0).stream("none", 0);
    let (x, u) = ([0.3, -0.1, 0.2], 0.7);
    sindyna_core::Dynamics::step(&found.model, &x, &[u], &mut rng, &mut next).expect("a finite step");
    let a = x[2] + 0.05 * (-2.0 * x[2] - 3.0 * x[1] - 1.5 * x[0] + 2.0 * u);
    let v = x[1] + 0.05 * a;
    for (got, expected) in next.iter().zip([x[0] + 0.05 * v, v, a]) {
        assert!((got - expected).abs() < 1e-9, "{next:?}");
    }
}

/// x⁺ after `substeps` semi-implicit Euler steps of a damped, driven pendulum, and of a cart with a pole.
fn skipped_pendulum<const SUBSTEPS: usize>(x: &[f64], u: &[f64]) -> Vec<f64> {
    let (mut angle, mut rate, h) = (x[0], x[1], 0.05 / SUBSTEPS as f64);
    for _ in 0..SUBSTEPS {
        rate += h * (-12.0 * angle.sin() - 0.4 * rate + 5.0 * u[0]);
        angle += h * rate;
    }
    vec![angle, rate]
}

fn skipped_cart_pole<const SUBSTEPS: usize>(x: &[f64], u: &[f64]) -> Vec<f64> {
    let (mut x, h) = (x.to_vec(), 0.04 / SUBSTEPS as f64);
    for _ in 0..SUBSTEPS {
        let temp = (u[0] + 0.05 * x[3] * x[3] * x[1].sin()) / 1.1;
        let turn = (9.8 * x[1].sin() - x[1].cos() * temp) / (0.5 * (4.0 / 3.0 - 0.1 * x[1].cos().powi(2) / 1.1));
        let push = temp - 0.05 * turn * x[1].cos() / 1.1;
        x[2] += h * push;
        x[3] += h * turn;
        x[0] += h * x[2];
        x[1] += h * x[3];
    }
    x
}

#[test]
fn a_simulator_that_takes_several_steps_from_sample_to_sample_is_found_with_their_number() {
    let state = vec![Channel::new("θ", "rad", Kind::Angle, 3.0), Channel::new("ω", "rad/s", Kind::RateOf(0), 8.0)];
    let spec =
        Spec { observation: state.clone(), state, dt: 0.05, precision: Precision::F64, ..common::pendulum().spec };
    type Step = fn(&[f64], &[f64]) -> Vec<f64>;
    let steps: [(usize, Step); 4] = [
        (2, skipped_pendulum::<2>),
        (3, skipped_pendulum::<3>),
        (5, skipped_pendulum::<5>),
        (10, skipped_pendulum::<10>),
    ];
    for (substeps, step) in steps {
        let truth = Truth { spec: spec.clone(), step };
        for (seed, count) in [(0, 20), (1, 20), (2, 300)] {
            let start = |rng: &mut Rng| (0..2).map(|_| uniform(rng, -1.0, 1.0)).collect();
            let data = record(&truth, seed, count, start, |rng, i| swing(2.0)(rng, i), |_| false);
            let found = identify(&truth.spec, &data);
            assert_eq!(found.model.form(), Form::SemiImplicit { substeps }, "{}", found.model);
            assert_terms(&found, 1, &[("sin θ", -12.0), ("ω", -0.4), ("u", 5.0)], 1e-9);
        }
    }
    let truth = Truth { spec: Spec { dt: 0.04, ..common::inverted_pendulum().spec }, step: skipped_cart_pole::<4> };
    let per_length = 1.0 / (0.5 * 4.0 / 3.0);
    for seed in 0..4 {
        let start = |rng: &mut Rng| (0..4).map(|_| uniform(rng, -0.3, 0.3)).collect();
        let data = record(&truth, seed, 30, start, |rng, i| swing(3.0)(rng, i), |_| false);
        let found = identify(&truth.spec, &data);
        assert_eq!(found.model.form(), Form::SemiImplicit { substeps: 4 }, "{}", found.model);
        assert_terms(&found, 3, &[("sin θ", 9.8 * per_length), ("cos θ·dv/dt", -per_length)], 1e-8);
    }
}

#[test]
fn several_steps_of_a_linear_system_are_counted_too() {
    let step: fn(&[f64], &[f64]) -> Vec<f64> = |x, u| {
        let (mut x, mut v) = (x[0], x[1]);
        for _ in 0..5 {
            v += 0.005 * (-0.3 * v + u[0]);
            x += 0.005 * v;
        }
        vec![x, v]
    };
    let state = vec![Channel::new("x", "m", Kind::Plain, 1.0), Channel::new("v", "m/s", Kind::RateOf(0), 1.0)];
    let spec =
        Spec { observation: state.clone(), state, dt: 0.025, precision: Precision::F64, ..common::pendulum().spec };
    let truth = Truth { spec, step };
    for (seed, count) in [(0, 100), (1, 100), (2, 20)] {
        let data = record(&truth, seed, count, |_| vec![0.2, 0.0], |rng, _| uniform(rng, -0.5, 0.5), |_| false);
        let found = identify(&truth.spec, &data);
        assert_eq!(found.model.form(), Form::SemiImplicit { substeps: 5 }, "{}", found.model);
        assert_terms(&found, 1, &[("v", -0.3), ("u", 1.0)], 1e-9);
    }
}
