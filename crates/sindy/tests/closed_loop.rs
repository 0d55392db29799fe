//! Systems that a controller keeps at an unstable state of rest, recorded while it does.

use ndarray::{Array2, s};
use rand::RngExt as _;
use sindyna_core::{Channel, Kind, Precision, Rng, Seed, Space, Spec};
use sindyna_sindy::{Identified, Identifier, LibraryChoice, NoiseChoice, Recording};

const DT: f64 = 0.02;

fn spec() -> Spec {
    let angle = Channel::new("th", "rad", Kind::Angle, 1.0);
    let rate = Channel::new("w", "rad/s", Kind::RateOf(0), 1.0);
    Spec {
        name: "pendulum".into(),
        observation: vec![angle.clone(), rate.clone()],
        state: vec![angle, rate],
        control: vec![Channel::new("u", "N m", Kind::Plain, 1.0)],
        action_space: Space::Box { low: vec![-5.0], high: vec![5.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt: DT,
    }
}

fn normal(rng: &mut Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// ẇ = 20 sin θ − 0.4 w + 4 u by semi-implicit steps.
fn step([th, w]: [f64; 2], u: f64) -> [f64; 2] {
    let w = w + DT * (20.0 * th.sin() - 0.4 * w + 4.0 * u);
    [th + DT * w, w]
}

/// `swung` steps of it swinging under random torques, then `held` steps upright under feedback of its measurements, which have errors of 0.001.
fn recordings(seed: u64, swung: usize, held: usize) -> Vec<Recording> {
    let mut rng = Seed::new(seed).stream("closed loop", 0);
    let phases = [(swung, [3.1, 0.0], false), (held, [0.002, 0.0], true)];
    let of = |(steps, start, closed): (usize, [f64; 2], bool)| {
        let (mut x, mut states, mut controls) = (start, Array2::zeros((steps + 1, 2)), Array2::zeros((steps, 1)));
        let mut push = 0.0;
        for t in 0..=steps {
            let measured = x.map(|x| x + 0.001 * normal(&mut rng));
            states.slice_mut(s![t, ..]).iter_mut().zip(measured).for_each(|(slot, v)| *slot = v);
            if t == steps {
                break;
            }
            if t % 7 == 0 {
                push = rng.random_range(-2.0..2.0);
            }
            let u = if closed { -7.0 * measured[0] - 1.5 * measured[1] } else { push };
            controls[[t, 0]] = u;
            x = step(x, u);
        }
        Recording::even(DT, states, Some(controls))
    };
    phases.into_iter().filter(|phase| phase.0 > 0).map(of).collect()
}

fn identified(identifier: Identifier, recordings: &[Recording]) -> Identified {
    identifier.with_noise(NoiseChoice::Estimated).identify_recordings(recordings).expect("equations")
}

/// (estimate − truth) / standard error of each of the coefficients of ẇ by its term; `None` for a false term.
fn errors(found: &Identified) -> Option<Vec<(String, f64)>> {
    const TRUTH: [(&str, f64); 3] = [("sin th", 20.0), ("w", -0.4), ("u", 4.0)];
    let equation = &found.report.equations[1];
    let numbers = equation.coefficients.iter().zip(&equation.standard_errors);
    let of = |(&j, (coefficient, error)): (&usize, (&f64, &f64))| {
        let (term, truth) = TRUTH.into_iter().find(|(term, _)| *term == found.report.features[j])?;
        Some((term.to_owned(), (coefficient - truth) / error))
    };
    equation.support.iter().zip(numbers).map(of).collect()
}

#[test]
fn what_swings_and_is_then_held_upright_is_adequate() {
    for seed in 0..5 {
        let found = identified(Identifier::new(&spec()), &recordings(seed, 120, 1_000));
        let doubts: Vec<_> = found.report.equations.iter().map(|e| e.doubt).collect();
        let errors = errors(&found).expect("no false terms");
        assert!(doubts.iter().all(Option::is_none), "{seed}: {doubts:?} {errors:?}");
        assert!(errors.len() == 3 && errors.iter().all(|(_, e)| e.abs() < 4.0), "{seed}: {errors:?}");
    }
}

#[test]
fn coefficients_of_what_is_only_held_have_no_bias() {
    const SEEDS: u64 = 20;
    let (mut gravity, mut torque) = (0.0, 0.0);
    for seed in 0..SEEDS {
        let library = LibraryChoice::Terms(["sin(th)", "w", "u"].map(String::from).to_vec());
        let identifier = Identifier::new(&spec()).with_library(library).expect("terms");
        // Friction is small beside both.
        let errors = errors(&identified(identifier, &recordings(seed, 0, 600))).expect("no false terms");
        let of = |name: &str| errors.iter().find(|(term, _)| term == name).expect("both are needed").1;
        gravity += of("sin th") / SEEDS as f64;
        torque += of("u") / SEEDS as f64;
    }
    // Least squares over coefficients and states: 2.3 and 1.9.
    let chance = 3.5 / (SEEDS as f64).sqrt();
    assert!(gravity.abs() < chance && torque.abs() < chance, "{gravity} {torque}");
}
