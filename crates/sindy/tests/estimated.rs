//! Equations from recordings whose noise nobody declares.

mod recorded;

use ndarray::Array2;
use rand::RngExt as _;
use recorded::{Field, assert_equation, equation, normal, record, record_held, spec};
use sindyna_core::{Kind, Seed};
use sindyna_sindy::{EquationReport, Identifier, Noise, Recording};

const PLAIN: [(&str, Kind); 3] = [("x", Kind::Plain), ("y", Kind::Plain), ("z", Kind::Plain)];

fn lorenz(x: &[f64], u: f64) -> Vec<f64> {
    vec![10.0 * (x[1] - x[0]) + 20.0 * u, x[0] * (28.0 - x[2]) - x[1], x[0] * x[1] - 8.0 / 3.0 * x[2]]
}

#[test]
fn lorenz_is_found_with_noise_that_nobody_declares_at_even_and_uneven_times() {
    for uneven in [false, true] {
        for noise in [1e-3, 1e-2] {
            let recording = record(lorenz, &[-8.0, 8.0, 27.0], (300, 0.02), (noise, 1.0, uneven), 3);
            let found = Identifier::new(&spec(&PLAIN, 0.02)).identify_recordings(&[recording]).expect("equations");
            assert_equation(&found, 0, &[("x", -10.0), ("y", 10.0), ("u", 20.0)], 0.05);
            assert_equation(&found, 1, &[("x", 28.0), ("y", -1.0), ("x·z", -1.0)], 0.05);
            assert_equation(&found, 2, &[("z", -8.0 / 3.0), ("x·y", 1.0)], 0.05);
            assert_eq!(found.report.noise, Noise::Estimated);
            let sigma = found.report.noise_deviations[0];
            // The spread of x is about eight.
            assert!((4.0..12.0).contains(&(sigma / noise)), "{sigma}");
        }
    }
}

fn van_der_pol(x: &[f64], u: f64) -> Vec<f64> {
    vec![x[1], 1.5 * (1.0 - x[0] * x[0]) * x[1] - x[0] + u]
}

#[test]
fn units_change_no_structure() {
    let kinds = [("x", Kind::Plain), ("v", Kind::RateOf(0))];
    for unit in [1e-9, 1.0, 1e9] {
        let recording = record(van_der_pol, &[1.0, 0.0], (400, 0.05), (1e-2, unit, false), 5);
        let found = Identifier::new(&spec(&kinds, 0.05)).identify_recordings(&[recording]).expect("equations");
        let truth = [("x", -1.0), ("v", 1.5), ("u", unit), ("x²·v", -1.5 / (unit * unit))];
        assert_equation(&found, 1, &truth, 0.05);
    }
}

#[test]
fn a_law_that_no_terms_can_say_is_no_adequate_equation() {
    let field: Field = |x, u| vec![6.0 * u - (5.0 * x[0]).tanh() * (1.0 + 0.5 * (7.0 * x[0]).sin())];
    let recording = record(field, &[1.0], (600, 0.1), (1e-3, 1.0, false), 2);
    let found = Identifier::new(&spec(&PLAIN[..1], 0.1)).identify_recordings(&[recording]).expect("equations");
    assert!(!found.report.equations[0].reached_floor, "{}", found.model);
}

fn prey_and_predators(x: &[f64], u: f64) -> Vec<f64> {
    let eaten = x[0] * x[1] / (1.0 + x[0]);
    vec![x[0] - 0.25 * x[0] * x[0] - 1.2 * eaten, 0.8 * eaten - 0.4 * x[1] + 0.2 * u]
}

#[test]
fn ratios_are_found() {
    for noise in [0.0, 1e-3] {
        let recording = record(prey_and_predators, &[1.0, 1.0], (400, 0.2), (noise, 1.0, false), 4);
        let found = Identifier::new(&spec(&PLAIN[..2], 0.2)).identify_recordings(&[recording]).expect("equations");
        let within = if noise > 0.0 { 0.02 } else { 1e-6 };
        // Each equation has the ratio, with its parameter, or is the true one multiplied by 1 + x.
        let ratio = |i: usize| equation(&found, i).iter().map(|t| t.0.to_owned()).find(|t| t.starts_with("y·x/("));
        match ratio(0) {
            Some(ratio) => assert_equation(&found, 0, &[("x", 1.0), ("x²", -0.25), (&ratio, -1.2)], within),
            None => {
                let prey = [("x", 1.0), ("x²", 0.75), ("x³", -0.25), ("x·y", -1.2), ("x·dx/dt", -1.0)];
                assert_equation(&found, 0, &prey, within);
            }
        }
        match ratio(1) {
            Some(ratio) => assert_equation(&found, 1, &[("y", -0.4), ("u", 0.2), (&ratio, 0.8)], within),
            None => {
                let predators = [("y", -0.4), ("u", 0.2), ("x·y", 0.4), ("x·u", 0.2), ("x·dy/dt", -1.0)];
                assert_equation(&found, 1, &predators, within);
            }
        }
        for parameter in found.report.equations.iter().flat_map(|e| &e.parameters) {
            assert!((parameter.value - 1.0).abs() < within, "{parameter:?}");
        }
    }
}

/// A pendulum hanging from the end of an arm that turns about a vertical axis and is driven by u.
fn rotary_pendulum(x: &[f64], u: f64) -> Vec<f64> {
    let (sin, cos) = x[1].sin_cos();
    let (arm, pole) = (x[2], x[3]);
    let a = 6.0 * u - 0.4 * arm - 2.0 * sin * cos * arm * pole + 0.8 * sin * pole * pole;
    let b = -10.0 * sin - 0.2 * pole + sin * cos * arm * arm;
    let (inertia, coupling) = (2.0 + sin * sin, 0.8 * cos);
    let determinant = inertia - coupling * coupling;
    vec![arm, pole, (a - coupling * b) / determinant, (inertia * b - coupling * a) / determinant]
}

#[test]
fn inertia_that_depends_on_an_angle_is_found_in_noise() {
    let kinds = [("ph", Kind::Angle), ("th", Kind::Angle), ("r", Kind::RateOf(0)), ("w", Kind::RateOf(1))];
    let recordings: Vec<Recording> = (0..4)
        .map(|seed| {
            let start = [0.3, 1.2 - 0.6 * seed as f64, 0.5, 1.0];
            record(rotary_pendulum, &start, (100, 0.03), (1e-3, 1.0, false), seed)
        })
        .collect();
    let found = Identifier::new(&spec(&kinds, 0.03)).identify_recordings(&recordings).expect("equations");
    let arm = [("r", -0.16), ("u", 2.4), ("w²·sin th", 0.32), ("r·w·sin 2th", -0.4), ("cos th·dw/dt", -0.32)];
    assert_equation(&found, 2, &[&arm[..], &[("cos 2th·dr/dt", 0.2)]].concat(), 0.03);
    let pole = [("sin th", -10.0), ("w", -0.2), ("r²·sin 2th", 0.5), ("cos th·dr/dt", -0.8)];
    assert_equation(&found, 3, &pole, 0.03);
}

#[test]
fn recordings_that_do_not_fit_are_refused() {
    let identifier = Identifier::new(&spec(&PLAIN, 0.02));
    let good = record(lorenz, &[-8.0, 8.0, 27.0], (30, 0.02), (0.0, 1.0, true), 3);
    let refused = |change: fn(&mut Recording)| {
        let mut bad = good.clone();
        change(&mut bad);
        identifier.identify_recordings(&[bad]).expect_err("bad").to_string()
    };
    assert!(refused(|r| r.times[3] = r.times[2]).contains("must increase"));
    assert!(refused(|r| r.states[[4, 1]] = f64::NAN).contains("NaN"));
    assert!(refused(|r| r.times.truncate(3)).contains("times"));
}

/// A spring that saturates, with friction, driven by u.
fn soft_spring(x: &[f64], u: f64) -> Vec<f64> {
    vec![x[1], -12.0 * (x[0] / 0.4).tanh() - 0.5 * x[1] + 2.0 * u]
}

#[test]
fn saturation_is_found_with_its_scale_and_the_error_of_that() {
    let kinds = [("x", Kind::Plain), ("v", Kind::RateOf(0))];
    let (mut squares, seeds) = (0.0, 4);
    for seed in 0..seeds {
        let recording = record(soft_spring, &[0.8, 0.0], (300, 0.03), (0.01, 1.0, false), seed);
        let found = Identifier::new(&spec(&kinds, 0.03)).identify_recordings(&[recording]).expect("equations");
        let report = &found.report.equations[1];
        let [scale] = &report.parameters[..] else { panic!("{:?}", equation(&found, 1)) };
        let name = found.report.features[scale.term].clone();
        assert!(name.starts_with("tanh(x/"), "{name}");
        assert_equation(&found, 1, &[(&name, -12.0), ("v", -0.5), ("u", 2.0)], 0.1);
        assert!(scale.standard_error < 0.05, "{scale:?}");
        squares += ((scale.value - 0.4) / scale.standard_error).powi(2);
        assert!(report.reached_floor, "{:?}", report.doubt);
    }
    // The mean square of a standard normal number over four draws is above 3.7 one time in 200.
    assert!(squares / f64::from(seeds as u32) < 3.7, "{squares}");
}

/// A heater whose power saturates, under inputs from 0 to 5.
fn saturating_heater(x: &[f64], u: f64) -> Vec<f64> {
    let u = 2.5 * (u + 1.0);
    vec![20.0 * u / (1.7 + u) - 0.2 * x[0]]
}

#[test]
fn an_input_that_saturates_enters_as_a_ratio() {
    for seed in 0..4 {
        let mut recording = record(saturating_heater, &[50.0], (400, 0.5), (0.01, 1.0, false), seed);
        recording.controls.mapv_inplace(|u| 2.5 * (u + 1.0));
        let identifier = Identifier::new(&spec(&[("T", Kind::Plain)], 0.5));
        let found = identifier.identify_recordings(&[recording]).expect("equations");
        let report = &found.report.equations[0];
        let [scale] = &report.parameters[..] else { panic!("{:?}", equation(&found, 0)) };
        let name = found.report.features[scale.term].clone();
        assert!(name.starts_with("u/("), "{name}");
        assert_equation(&found, 0, &[(&name, 20.0), ("T", -0.2)], 0.05);
        assert!((scale.value - 1.7).abs() < 4.0 * scale.standard_error, "{scale:?}");
    }
}

/// Short recordings leave residuals that are correlated by what was fitted to each: where it begins. Their prediction errors are not.
#[test]
fn a_true_model_of_many_short_recordings_is_not_called_correlated() {
    let field: Field = |x, u| vec![x[1], -4.0 * x[0] - 0.5 * x[1] + 3.0 * u];
    let identifier = Identifier::new(&spec(&[("x", Kind::Plain), ("v", Kind::RateOf(0))], 0.1));
    for seed in 0..4 {
        let piece = |i: u64| {
            let mut rng = Seed::new(seed).stream("start", i);
            let start = [normal(&mut rng), normal(&mut rng)];
            record(field, &start, (5, 0.1), (0.02, 1.0, false), 1000 * seed + i)
        };
        let pieces: Vec<Recording> = (0..60).map(piece).collect();
        let found = identifier.identify_recordings(&pieces).expect("equations");
        assert_equation(&found, 1, &[("x", -4.0), ("v", -0.5), ("u", 3.0)], 0.1);
        assert_eq!(found.report.equations[1].doubt, None, "seed {seed}");
    }
}

/// A sensor that is wrong now and then spoils neither terms nor coefficients, nor what is told of its noise.
#[test]
fn glitches_of_sensors_are_left_out() {
    for seed in 0..3 {
        let mut recording = record(lorenz, &[-8.0, 8.0, 27.0], (400, 0.02), (1e-2, 1.0, false), seed);
        let mut rng = Seed::new(seed).stream("glitches", 0);
        let mut glitches = 0;
        for value in &mut recording.states {
            if rng.random::<f64>() < 0.015 {
                *value += if rng.random::<f64>() < 0.5 { 4.0 } else { -4.0 };
                glitches += 1;
            }
        }
        let found = Identifier::new(&spec(&PLAIN, 0.02)).identify_recordings(&[recording]).expect("equations");
        assert_equation(&found, 0, &[("x", -10.0), ("y", 10.0), ("u", 20.0)], 0.05);
        assert_equation(&found, 1, &[("x", 28.0), ("y", -1.0), ("x·z", -1.0)], 0.05);
        assert_equation(&found, 2, &[("z", -8.0 / 3.0), ("x·y", 1.0)], 0.05);
        let left_out = found.report.rows_astray;
        assert!(glitches > 5 && left_out >= glitches && left_out <= 3 * glitches, "{left_out} for {glitches}");
        // The spread of x is about eight, a glitch fifty times the noise.
        let sigma = found.report.noise_deviations[0];
        assert!((0.04..0.12).contains(&sigma), "{sigma}");
    }
}

/// Terms that are the same on all data are told beside the one that is meant, and are no doubt.
#[test]
fn terms_that_are_the_same_on_all_data_are_told() {
    let field: Field = |x, u| vec![1.2 + u - 0.5 * x[0] * x[0].abs()];
    let recording = record(field, &[1.5], (400, 0.3), (1e-3, 1.0, false), 4);
    assert!(recording.states.iter().all(|s| *s > 0.0));
    let found =
        Identifier::new(&spec(&[("s", Kind::Plain)], 0.3)).identify_recordings(&[recording]).expect("equations");
    assert_equation(&found, 0, &[("1", 1.2), ("u", 1.0), ("s²", -0.5)], 0.05);
    assert_eq!(found.report.equations[0].doubt, None, "{found}");
    let warnings = found.report.warnings.join("\n");
    assert!(warnings.contains("`s²` and `s·abs s` are proportional on all data"), "{warnings}");
}

/// Prey N and predators P that saturate: a limit cycle with few of either most of the time, so that noise makes numbers negative. No polynomials come
/// near, and while one equation is wrong the other cannot be judged by its trajectories.
fn saturated_predators(x: &[f64], u: f64) -> Vec<f64> {
    let eaten = x[0] * x[1] / (0.4 + x[0]);
    vec![x[0] * (1.0 - 0.3 * x[0]) - eaten + 0.02 * (1.0 + u), 0.7 * eaten - 0.3 * x[1]]
}

#[test]
fn ratios_in_two_equations_are_found_together() {
    let kinds = [("N", Kind::Plain), ("P", Kind::Plain)];
    for seed in 0..3 {
        let recording = record(saturated_predators, &[1.0, 0.6], (500, 0.2), (1e-2, 1.0, false), seed);
        assert!(recording.states.column(0).iter().any(|n| *n < 0.0));
        let found = Identifier::new(&spec(&kinds, 0.2)).identify_recordings(&[recording]).expect("equations");
        let names: Vec<&str> = equation(&found, 1).iter().map(|t| t.0).collect();
        assert!(names.len() == 2 && names.iter().any(|name| name.starts_with("P·N/(")), "seed {seed}: {names:?}");
        let parameter = &found.report.equations[1].parameters[0];
        assert!((parameter.value / 0.4 - 1.0).abs() < 0.1, "seed {seed}: {parameter:?}");
    }
}

/// A load on a spring that is shaken by something nobody measured: its motion is explained by no terms, that of the arm before it is.
#[test]
fn parts_that_need_no_other_states_are_found_beside_one_that_no_terms_can_say() {
    let field: Field = |x, u| {
        let hidden = x[4].sin() + (1.7 * x[5]).sin();
        vec![
            x[1],
            -4.0 * x[0] - 0.5 * x[1] + 3.0 * u,
            x[3],
            6.0 * (x[0] - x[2]) + 8.0 * hidden,
            x[5],
            -9.0 * x[4].sin(),
        ]
    };
    let kinds = [("x", Kind::Plain), ("v", Kind::RateOf(0)), ("y", Kind::Plain), ("w", Kind::RateOf(2))];
    for seed in 0..3 {
        let mut recording = record(field, &[1.0, 0.0, 0.5, 0.0, 2.5, 0.0], (400, 0.05), (5e-3, 1.0, false), seed);
        recording.states = recording.states.slice(ndarray::s![.., ..4]).to_owned();
        let found = Identifier::new(&spec(&kinds, 0.05)).identify_recordings(&[recording]).expect("equations");
        assert_equation(&found, 1, &[("x", -4.0), ("v", -0.5), ("u", 3.0)], 0.05);
        assert!(found.report.equations[1].reached_floor, "seed {seed}: {found}");
        // Terms are in the order of the candidates. States that follow wrong equations would move coefficients by more than their errors.
        let EquationReport { coefficients, standard_errors, .. } = &found.report.equations[1];
        for ((own, error), truth) in coefficients.iter().zip(standard_errors).zip([-4.0, -0.5, 3.0]) {
            assert!((own - truth).abs() < 3.5 * error, "seed {seed}: {own} ± {error}, not {truth}");
        }
        assert!(!found.report.equations[3].reached_floor, "seed {seed}: {found}");
    }
}

/// Two links in a plane, the elbow driven: q₁ = 0 hangs down.
fn acrobot(x: &[f64], u: f64) -> Vec<f64> {
    let (i1, i2, h, w1, w2) = (0.057, 0.051, 0.032, 2.25, 1.57);
    let (s2, c2, s12) = (x[1].sin(), x[1].cos(), (x[0] + x[1]).sin());
    let (m11, m12, m22) = (i1 + i2 + 2.0 * h * c2, i2 + h * c2, i2);
    let first = h * s2 * (2.0 * x[2] + x[3]) * x[3] - w1 * x[0].sin() - w2 * s12;
    let second = 4.0 * u - h * s2 * x[2] * x[2] - w2 * s12;
    let determinant = m11 * m22 - m12 * m12;
    vec![x[2], x[3], (m22 * first - m12 * second) / determinant, (m11 * second - m12 * first) / determinant]
}

/// Two seconds of a double pendulum, angles with noise of a milliradian and rates of a tenth of a radian per second: where pieces tell its Lagrangian, that explains the
/// whole. Not all such logs tell it; no other equations are called adequate.
#[test]
fn a_double_pendulum_is_found_in_two_seconds_of_noisy_samples_or_doubted() {
    let kinds = [("a", Kind::Angle), ("b", Kind::Angle), ("v", Kind::RateOf(0)), ("w", Kind::RateOf(1))];
    let second = [("u", 4.0 / 0.051), ("v²·sin b", -0.032 / 0.051), ("sin(a + b)", -1.57 / 0.051)];
    let coupling = [("dv/dt", -1.0), ("cos b·dv/dt", -0.032 / 0.051)];
    let mut n_found = 0;
    for seed in 0..5 {
        let mut recording = record_held(acrobot, &[0.0; 4], (101, 0.02), (0.0, 1.0, false), 7, seed);
        let mut rng = Seed::new(seed).stream("sensors", 0);
        recording.states.indexed_iter_mut().for_each(|((_, i), x)| *x += [1e-3, 1e-3, 0.1, 0.1][i] * normal(&mut rng));
        let found = Identifier::new(&spec(&kinds, 0.02)).identify_recordings(&[recording]).expect("equations");
        if found.report.equations.iter().all(|e| e.doubt.is_none()) {
            assert_equation(&found, 3, &[&second[..], &coupling].concat(), 0.1);
            n_found += 1;
        }
    }
    assert!(n_found >= 2, "{n_found} of 5");
}

/// A log that ends at its equilibrium: the terms cancel there, and others explain it as well. Wrong terms are not called adequate.
#[test]
fn terms_that_cancel_at_an_equilibrium_are_not_hidden_behind_others() {
    let field: Field = |x, _| vec![1.8 * x[0] - 0.11 * x[0] * x[0]];
    for seed in 0..6 {
        let recording = record(field, &[11.0], (500, 0.02), (0.5, 1.0, false), seed);
        let found = Identifier::new(&spec(&PLAIN[..1], 0.02)).identify_recordings(&[recording]).expect("equations");
        let names: Vec<&str> = equation(&found, 0).iter().map(|t| t.0).collect();
        assert!(names == ["x", "x²"] || !found.report.equations[0].reached_floor, "seed {seed}: {found}");
    }
}

fn pendulum(x: &[f64], u: f64) -> Vec<f64> {
    vec![x[1], -9.81 * x[0].sin() - 0.3 * x[1] + 4.0 * u]
}

/// An encoder alone: the rate of the angle is found with the equations.
#[test]
fn rates_that_were_not_measured_are_found_with_the_equations() {
    let kinds = [("a", Kind::Angle), ("w", Kind::RateOf(0))];
    for (noise, within) in [(0.0, 1e-6), (1e-3, 0.01), (1e-2, 0.05)] {
        for seed in 0..3 {
            let mut recording = record(pendulum, &[0.5, 0.0], (400, 0.05), (noise, 1.0, seed == 2), seed);
            recording.states.column_mut(1).fill(f64::NAN);
            let found = Identifier::new(&spec(&kinds, 0.05)).identify_recordings(&[recording]).expect("equations");
            assert_equation(&found, 1, &[("sin a", -9.81), ("w", -0.3), ("u", 4.0)], within);
            assert!(found.report.equations[1].reached_floor, "{noise} {seed}: {found}");
        }
    }
}

/// A motor's speed alone, behind a filter: its rate and the rate of that are found, and so the linear equation of third order.
#[test]
fn rates_of_rates_that_were_not_measured_are_found() {
    let field: Field = |x, u| vec![x[1] - x[0], 2.0 * (x[2] - x[1]), 5.0 * (u - x[2])];
    let kinds = [("x", Kind::Plain), ("v", Kind::RateOf(0)), ("a", Kind::RateOf(1))];
    for (noise, within) in [(0.0, 1e-5), (1e-2, 0.05)] {
        let mut recording = record(field, &[0.0, 0.0, 0.0], (500, 0.1), (noise, 1.0, false), 1);
        recording.states.slice_mut(ndarray::s![.., 1..]).fill(f64::NAN);
        let found = Identifier::new(&spec(&kinds, 0.1)).identify_recordings(&[recording]).expect("equations");
        assert_equation(&found, 2, &[("x", -10.0), ("v", -17.0), ("a", -8.0), ("u", 10.0)], within);
        // With noise the sine of a small x is as good.
        assert!(noise > 0.0 || found.report.equations[2].reached_floor, "{noise}: {found}");
        assert_eq!(found.report.unmeasured, [1, 2]);
    }
}

/// Angles in the steps of a simulator that moves them by the new rates.
#[test]
fn positions_may_be_those_of_a_simulator() {
    let kinds = [("a", Kind::Angle), ("w", Kind::RateOf(0))];
    for noise in [0.0, 1e-2] {
        let mut rng = Seed::new(4).stream("simulated", 0);
        let (mut a, mut w, dt) = (3.0_f64, 0.0, 0.05);
        let mut states = Array2::from_elem((400, 2), f64::NAN);
        let mut controls = Array2::zeros((399, 1));
        let mut rates = ndarray::Array1::zeros(400);
        for t in 0..400 {
            states[[t, 0]] = a + noise * normal(&mut rng);
            rates[t] = w;
            if t < 399 {
                controls[[t, 0]] = if t % 5 == 0 { 2.0 * rng.random::<f64>() - 1.0 } else { controls[[t - 1, 0]] };
                w += dt * (15.0 * a.sin() - 0.2 * w + 3.0 * controls[[t, 0]]);
                a += dt * w;
            }
        }
        let recording = Recording::even(dt, states, Some(controls));
        let identifier = Identifier::new(&spec(&kinds, dt));
        let found = identifier.identify_recordings(std::slice::from_ref(&recording)).expect("equations");
        let filled = identifier.filled(&found.model, &[recording]).expect("states");
        let off = (&filled[0].states.column(1) - &rates).mapv(|d| d * d).mean().expect("samples").sqrt();
        assert!(off < if noise > 0.0 { 0.05 } else { 1e-6 }, "{noise}: {off}");
        assert_equation(&found, 1, &[("sin a", 15.0), ("w", -0.2), ("u", 3.0)], if noise > 0.0 { 0.05 } else { 1e-6 });
        assert!(matches!(found.model.form(), sindyna_sindy::Form::SemiImplicit { .. }), "{found}");
    }
}

/// What follows from the equations and the angles is the rate that nobody measured; the measured angles stay.
#[test]
fn rates_that_were_not_measured_are_filled_in() {
    let kinds = [("a", Kind::Angle), ("w", Kind::RateOf(0))];
    let whole = record(pendulum, &[0.5, 0.0], (300, 0.05), (1e-3, 1.0, false), 7);
    let clean = record(pendulum, &[0.5, 0.0], (300, 0.05), (0.0, 1.0, false), 7);
    let mut recording = whole.clone();
    recording.states.column_mut(1).fill(f64::NAN);
    let identifier = Identifier::new(&spec(&kinds, 0.05));
    let found = identifier.identify_recordings(&[recording.clone()]).expect("equations");
    let filled = identifier.filled(&found.model, &[recording]).expect("states");
    assert_eq!(filled[0].states.column(0), whole.states.column(0));
    let (w, truth) = (filled[0].states.column(1), clean.states.column(1));
    let off = (&w - &truth).mapv(|d| d * d).mean().expect("samples").sqrt();
    let spread = truth.mapv(|v| v * v).mean().expect("samples").sqrt();
    assert!(off < 2e-3 * spread, "{off} of {spread}");
}

#[test]
fn only_rates_of_measured_states_may_be_unmeasured() {
    let mut recording = record(van_der_pol, &[1.0, 0.0], (100, 0.05), (1e-2, 1.0, false), 5);
    recording.states.column_mut(1).fill(f64::NAN);
    let of = |kinds: &[(&str, Kind)], recording: &Recording| {
        Identifier::new(&spec(kinds, 0.05))
            .identify_recordings(std::slice::from_ref(recording))
            .expect_err("refused")
            .to_string()
    };
    let refused = of(&PLAIN[..2], &recording);
    assert!(refused.contains("`y` was not measured and is not the rate of a measured state"), "{refused}");
    recording.states[[3, 0]] = f64::NAN;
    let refused = of(&[("x", Kind::Plain), ("v", Kind::RateOf(0))], &recording);
    assert!(refused.contains("not finite"), "{refused}");
    recording.states.column_mut(0).fill(f64::NAN);
    let refused = of(&[("x", Kind::Plain), ("v", Kind::RateOf(0))], &recording);
    assert!(refused.contains("`x` was not measured"), "{refused}");
}
