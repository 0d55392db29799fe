//! Equations from arrays, with no task around: constraints, noise, simulation, Jacobians.

use ndarray::Array2;
use rand::RngExt as _;
use sindyna_core::{FitError, Seed};
use sindyna_sindy::{
    AnalysisError, EquationConstraint, EquationConstraintError, Identified, Identifier, NoiseChoice, Recording,
    Signals, SignalsError, Stage, Watch,
};

const DT: f64 = 0.05;

/// A driven, damped pendulum: ω̇ = −9.81 sin θ − 0.4 ω + 2 u, with noise of this part of each state's size.
fn pendulum(samples: usize, noise: f64, seed: u64) -> Recording {
    const PARTS: usize = 40;
    let mut rng = Seed::new(seed).stream("pendulum", 0);
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let (mut x, mut states) = ([1.2, 0.0], Array2::zeros((samples, 2)));
    let mut controls = Array2::zeros((samples - 1, 1));
    for t in 0..samples {
        (0..2).for_each(|i| states[[t, i]] = x[i] + noise * [0.7, 2.2][i] * normal());
        if t + 1 == samples {
            break;
        }
        let u = 2.0 * (0.37 * t as f64).sin() + f64::from(u8::from(t % 40 < 20));
        controls[[t, 0]] = u;
        let rate = |x: [f64; 2]| [x[1], -9.81 * x[0].sin() - 0.4 * x[1] + 2.0 * u];
        let h = DT / PARTS as f64;
        for _ in 0..PARTS {
            let at = |k: [f64; 2], c: f64| [x[0] + c * k[0], x[1] + c * k[1]];
            let k1 = rate(x);
            let k2 = rate(at(k1, 0.5 * h));
            let k3 = rate(at(k2, 0.5 * h));
            let k4 = rate(at(k3, h));
            (0..2).for_each(|i| x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
    }
    Recording::even(DT, states, Some(controls))
}

fn signals() -> Signals {
    Signals::new(&["th", "w"], &["u"]).angle("th").and_then(|s| s.rate("w", "th")).expect("names there are")
}

fn identifier() -> Identifier {
    Identifier::of_signals(&signals(), DT).expect("good signals")
}

/// The terms of ω̇ with their coefficients, by name.
fn terms(found: &Identified) -> Vec<(String, f64)> {
    let equation = &found.report.equations[1];
    let name = |j: &usize| found.report.features[*j].clone();
    let mut terms: Vec<(String, f64)> =
        equation.support.iter().map(name).zip(equation.coefficients.iter().copied()).collect();
    terms.sort_by(|a, b| a.0.cmp(&b.0));
    terms
}

fn assert_terms(found: &Identified, expected: &[(&str, f64)], tolerance: f64) {
    let got = terms(found);
    assert_eq!(got.len(), expected.len(), "{got:?}");
    for ((name, value), (wanted, truth)) in got.iter().zip(expected) {
        assert!(name == wanted && (value - truth).abs() < tolerance, "{got:?} is not {expected:?}");
    }
}

#[test]
fn noisy_arrays_become_equations_that_predict() {
    let found = identifier().identify_recordings(&[pendulum(400, 0.01, 1)]).expect("equations");
    assert_terms(&found, &[("sin th", -9.81), ("u", 2.0), ("w", -0.4)], 0.03);
    let text = found.to_string();
    assert!(text.contains("sin th") && text.contains("adequate") && text.contains("fit 9"), "{text}");

    let clean = pendulum(200, 0.0, 2);
    let ahead = found.model.simulate(&[1.2, 0.0], clean.controls.view()).expect("a simulation");
    let largest = (&ahead - &clean.states).mapv(f64::abs).fold(0.0_f64, |a, b| a.max(*b));
    assert!(largest < 0.1, "{largest}");
    for horizon in [Some(1), Some(20), None] {
        let fit = found.model.compare(std::slice::from_ref(&clean), horizon).expect("a comparison");
        assert!(fit.iter().all(|f| (0.95..=1.0).contains(f)), "{horizon:?} {fit:?}");
    }
    // Predictions from near are better than those from far, and the mean predicts nothing.
    let fit = |horizon| found.model.compare(std::slice::from_ref(&clean), horizon).expect("a comparison")[0];
    assert!(fit(Some(1)) > fit(Some(40)));
}

#[test]
fn models_drawn_scatter_as_the_standard_errors_say() {
    use sindyna_core::{Certainty, Dynamics as _};

    const DRAWS: usize = 2_000;
    let found = identifier().identify_recordings(&[pendulum(300, 0.01, 3)]).expect("equations");
    assert!(found.certainty() >= Certainty::Ambiguous, "{found}");
    let models = found.models.as_ref().expect("the noise was estimated");
    let (best, errors) = (&found.report.equations[1], &found.report.equations[1].standard_errors);
    let mut rng = Seed::new(0).numpy();
    let mut drawn = Vec::new();
    for _ in 0..DRAWS {
        let model = models.draw(&mut rng);
        let own: Vec<f64> = model.coefficients(1).iter().map(|e| e.coefficient).collect();
        if model.terms() == found.model.terms() {
            drawn.push(own);
        }
    }
    assert!(drawn.len() > DRAWS / 20, "the likeliest terms are drawn often: {}", drawn.len());
    let n = drawn.len() as f64;
    for (j, (value, error)) in best.coefficients.iter().zip(errors).enumerate() {
        let mean = drawn.iter().map(|d| d[j]).sum::<f64>() / n;
        let deviation = (drawn.iter().map(|d| (d[j] - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!((mean - value).abs() < 5.0 * error / n.sqrt(), "{mean} {value} ± {error}");
        assert!((0.8..1.25).contains(&(deviation / error)), "{deviation} {error}");
    }
    // Seen as nothing but dynamics, every draw moves on its own.
    let next = |rng: &mut _| {
        let (mut next, model) = ([0.0; 2], (models as &dyn sindyna_core::Posterior).draw(rng));
        model.step(&[1.0, 0.0], &[0.5], &mut Seed::new(0).numpy(), &mut next).expect("finite");
        next
    };
    assert_ne!(next(&mut rng), next(&mut rng));
}

#[test]
fn steps_are_linearised_as_they_are_made() {
    use sindyna_core::{Diverged, Dynamics, Rng, Seed};
    use sindyna_sindy::Model;

    /// A model of which only the steps are known.
    struct Steps<'a>(&'a Model);
    impl Dynamics for Steps<'_> {
        fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
            self.0.step(x, u, rng, next)
        }
    }

    let found = identifier().identify_recordings(&[pendulum(300, 0.005, 3)]).expect("equations");
    let json = found.model.to_json();
    let with = |form: &str, scheme: serde_json::Value| {
        let mut document: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        document["form"] = form.into();
        document["scheme"] = scheme;
        Model::from_json(&document.to_string()).expect("a model")
    };
    let mut models = vec![found.model.clone(), with("semi_implicit", serde_json::Value::Null)];
    models.extend(["increment", "discrete"].map(|form| with(form, serde_json::Value::Null)));
    for model in &models {
        let (x, u, mut rng) = ([0.4, -1.0], [0.7], Seed::new(0).numpy());
        let exact = model.linearize(&x, &u, &mut rng).expect("finite");
        let differences = Steps(model).linearize(&x, &u, &mut rng).expect("finite");
        for (a, b) in exact.0.iter().chain(&exact.1).zip(differences.0.iter().chain(&differences.1)) {
            assert!((a - b).abs() < 1e-8, "{:?}: {exact:?} {differences:?}", model.form());
        }
    }
}

#[test]
fn coarse_steps_are_fewer_and_lead_nearly_where_fine_ones_do() {
    use sindyna_core::{Dynamics, Scheme, Seed};
    use sindyna_sindy::{Form, Model};

    let found = identifier().identify_recordings(&[pendulum(300, 0.005, 3)]).expect("equations");
    let mut document: serde_json::Value = serde_json::from_str(&found.model.to_json()).expect("JSON");
    document["scheme"]["rk4"]["substeps"] = 8.into();
    let fine = Model::from_json(&document.to_string()).expect("a model");
    assert_eq!(fine.form(), Form::Continuous(Scheme::Rk4 { substeps: 8 }));
    let coarse = fine.coarse().expect("fewer substeps");
    let (mut rng, mut a, mut b) = (Seed::new(0).numpy(), [0.0; 2], [0.0; 2]);
    fine.step(&[0.4, -1.0], &[0.7], &mut rng, &mut a).expect("finite");
    coarse.step(&[0.4, -1.0], &[0.7], &mut rng, &mut b).expect("finite");
    let far = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(far > 0.0 && far < 1e-5, "{far}");
    assert!(coarse.coarse().and_then(|c| c.coarse()).is_none(), "one step cannot be made of fewer");
}

#[test]
fn jacobians_are_those_of_differences() {
    let found = identifier().identify_recordings(&[pendulum(300, 0.005, 3)]).expect("equations");
    let (x, u) = ([0.4, -1.0], [0.7]);
    let (a, b) = found.model.jacobians(&x, &u).expect("regular equations");
    let rate = |x: [f64; 2], u: f64| {
        let mut f = [0.0; 2];
        sindyna_core::VectorField::eval(&found.model, &x, &[u], &mut f);
        f
    };
    for j in 0..3 {
        let at = |h: f64| {
            let mut z = [x[0], x[1], u[0]];
            z[j] += h;
            rate([z[0], z[1]], z[2])
        };
        let (up, down) = (at(1e-6), at(-1e-6));
        for i in 0..2 {
            let difference = (up[i] - down[i]) / 2e-6;
            let exact = if j < 2 { a[[i, j]] } else { b[[i, 0]] };
            assert!((difference - exact).abs() < 1e-7, "{i} {j}");
        }
    }
    assert_eq!(found.model.jacobians(&[0.0], &u), Err(AnalysisError::Shape { what: "states", expected: 2, got: 1 }));
}

#[test]
fn what_is_known_is_not_looked_for_again() {
    let data = [pendulum(200, 0.02, 4)];
    let known = EquationConstraint::Known("-9.81*sin(th) + 2*u".into());
    let found =
        identifier().with_constraint("w", known).expect("a formula").identify_recordings(&data).expect("a rest");
    assert_terms(&found, &[("sin th", -9.81), ("u", 2.0), ("w", -0.4)], 0.05);
    let equation = &found.report.equations[1];
    assert_eq!((equation.n_known, equation.standard_errors.len()), (2, 3));
    // Given coefficients are as given, and what is left to find is found more exactly than with all of them free.
    assert!(terms(&found)[..2].iter().all(|(_, c)| *c == -9.81 || *c == 2.0));
    let free = identifier().identify_recordings(&data).expect("equations");
    let error = |found: &Identified| {
        let equation = &found.report.equations[1];
        let at = equation.support.iter().position(|j| found.report.features[*j] == "w").expect("friction");
        equation.standard_errors[at]
    };
    assert!(error(&found) < error(&free), "{} {}", error(&found), error(&free));
    // A wrong part is not explained away in silence.
    let wrong = EquationConstraint::Known("-9.81*sin(th) + 2*u - 2*w^3".into());
    let found =
        identifier().with_constraint("w", wrong).expect("a formula").identify_recordings(&data).expect("a rest");
    assert!(terms(&found).len() > 3 || !found.report.equations[1].reached_floor);
}

#[test]
fn required_forbidden_and_signed_terms_are_respected() {
    let data = [pendulum(200, 0.02, 5)];
    let with = |constraint| {
        identifier().with_constraint("w", constraint).expect("a term").identify_recordings(&data).expect("equations")
    };
    let found = with(EquationConstraint::Required("w^2".into()));
    assert!(terms(&found).iter().any(|(name, _)| name == "w²"), "{:?}", terms(&found));
    assert!(terms(&found).iter().any(|(name, c)| name == "u" && (c - 2.0).abs() < 0.1));
    let without = |identifier: Identifier, term: &str| {
        identifier.with_constraint("w", EquationConstraint::Forbidden(term.into())).expect("a term")
    };
    // u·|u| and u³ together are nearly u.
    let found = without(without(identifier(), "u"), "u*abs(u)").identify_recordings(&data).expect("equations");
    assert!(terms(&found).iter().all(|(name, _)| name != "u"));
    assert!(
        !found.report.equations[1].reached_floor,
        "without its input the equation is no more than an approximation"
    );
    let found = with(EquationConstraint::Positive("w".into()));
    assert!(terms(&found).iter().all(|(name, c)| name != "w" || *c > 0.0), "{:?}", terms(&found));
    // The data contradict this sign, and not the other one.
    let is_told =
        |found: &Identified| found.report.warnings.iter().any(|w| w.contains("contradict the declared sign of `w`"));
    assert!(is_told(&found), "{:?}", found.report.warnings);
    assert!(!is_told(&with(EquationConstraint::Negative("w".into()))));
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |state: &str, constraint| identifier().with_constraint(state, constraint).expect_err("a refusal");
    let known = |text: &str| EquationConstraint::Known(text.into());
    assert!(matches!(refused("x", known("u")), EquationConstraintError::NoSuchState { .. }));
    assert!(matches!(refused("th", known("u")), EquationConstraintError::Kinematic { .. }));
    assert!(matches!(refused("w", known("u*")), EquationConstraintError::Parse(_)));
    let required = EquationConstraint::Required("2*u".into());
    assert!(matches!(refused("w", required), EquationConstraintError::NotOneTerm { .. }));
    // A target that cannot respect a constraint does not ignore it.
    let other = identifier().with_target("increment".parse().expect("a target"));
    let other = other.with_constraint("w", known("u")).expect("a formula");
    let error = other.identify_recordings(&[pendulum(50, 0.0, 6)]).expect_err("a refusal");
    assert!(error.to_string().contains("known"), "{error}");

    assert!(matches!(Signals::new(&["x"], &[]).angle("y"), Err(SignalsError::NoSuchState { .. })));
    assert!(matches!(signals().rate("th", "w"), Err(SignalsError::Rate { .. })));
    let twice = Identifier::of_signals(&Signals::new(&["x"], &["x"]), DT).expect_err("one name twice");
    assert_eq!(twice, SignalsError::Name { name: "x".into() });
    let never = Identifier::of_signals(&signals(), 0.0).expect_err("no interval");
    assert_eq!(never, SignalsError::SamplingInterval { dt: 0.0 });
}

#[test]
fn without_noise_what_leaves_more_than_rounding_is_no_more_than_an_approximation() {
    let identifier = identifier().with_noise(NoiseChoice::Rounding);
    let found = identifier.identify_recordings(&[pendulum(300, 0.01, 7)]).expect("equations");
    assert!(!found.report.equations[1].reached_floor);
    let found = identifier.identify_recordings(&[pendulum(300, 0.0, 7)]).expect("equations");
    assert!(found.report.equations[1].reached_floor, "{found}");
    assert_terms(&found, &[("sin th", -9.81), ("u", 2.0), ("w", -0.4)], 1e-6);
}

#[test]
fn an_identification_tells_how_it_goes_and_ends_when_told() {
    let data = [pendulum(300, 0.01, 8)];
    let told = std::cell::Cell::new(0);
    let tell = |stage: Stage| {
        if let Stage::Search { spent } = stage {
            assert!((0.0..=1.0).contains(&spent));
        }
        told.set(told.get() + 1);
    };
    let whole = identifier().identify_recordings_watched(&data, &Watch::default().telling(&tell)).expect("equations");
    assert!(told.get() > 3);
    assert_eq!(terms(&whole), terms(&identifier().identify_recordings(&data).expect("equations")));
    let asked = std::cell::Cell::new(0);
    for patience in [0, 1, 5, 50, 500] {
        asked.set(0);
        let go_on = || {
            asked.set(asked.get() + 1);
            asked.get() <= patience
        };
        let ended = identifier().identify_recordings_watched(&data, &Watch::going_on(&go_on));
        assert!(matches!(ended, Err(FitError::Interrupted)), "{patience}");
        assert!(asked.get() < patience + 200, "asked {} times", asked.get());
    }
}
