//! Known equations from short rollouts: the support must be exactly the true one.

mod common;

use ndarray::Array2;
use sindyna_core::{Channel, Dataset, Dynamics as _, Kind, Precision, Scheme, Space, Spec};
use sindyna_sindy::{
    BestSubset, CoordinateMode, Differentiator, Identified, Identifier, Library, LibraryChoice, SavitzkyGolay, Sindy,
    SolverChoice, Stlsq, Target, Trajectory,
};

fn supports(found: &Identified) -> Vec<Vec<String>> {
    let names = |s: &Vec<usize>| s.iter().map(|&j| found.report.features[j].clone()).collect();
    found.report.equations.iter().map(|e| names(&e.support)).collect()
}

/// The seeds of 0..n, with what was found, for which that has not exactly the terms `expected`, in any order.
fn wrong(n: u64, expected: &[&[&str]], find: impl Fn(u64) -> Identified) -> Vec<(u64, String)> {
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    let expected: Vec<Vec<String>> =
        expected.iter().map(|e| sorted(e.iter().map(ToString::to_string).collect())).collect();
    let check = |seed| {
        let found = find(seed);
        let got: Vec<_> = supports(&found).into_iter().map(sorted).collect();
        (got != expected).then(|| (seed, found.model.to_string()))
    };
    (0..n).filter_map(check).collect()
}

fn identify(spec: &Spec, data: &sindyna_core::Dataset) -> Identified {
    Identifier::new(spec).with_target(Target::Increment).identify(data).expect("enough data")
}

#[test]
fn pendulum_is_found_from_six_steps() {
    let spec = common::pendulum().spec;
    let terms: [&[&str]; 2] = [&["ω", "sin θ", "u"], &["sin θ", "u"]];
    for steps in [6, 10, 20] {
        let wrong = wrong(40, &terms, |seed| identify(&spec, &common::pendulum_data(seed, steps)));
        assert_eq!(wrong, [], "{steps} steps");
    }
}

#[test]
fn mountain_car_is_found_from_eight_steps() {
    let spec = common::mountain_car().spec;
    let terms: [&[&str]; 2] = [&["v", "u", "cos 3x"], &["u", "cos 3x"]];
    for steps in [8, 20, 50] {
        let wrong = wrong(40, &terms, |seed| identify(&spec, &common::mountain_car_data(seed, steps)));
        assert_eq!(wrong, [], "{steps} steps");
    }
}

#[test]
fn pendulum_seen_in_double_precision_is_found_too() {
    let mut spec = common::pendulum().spec;
    spec.precision = Precision::F64;
    let truth = common::Truth { spec: spec.clone(), ..common::pendulum() };
    let terms: [&[&str]; 2] = [&["ω", "sin θ", "u"], &["sin θ", "u"]];
    let start = |rng: &mut sindyna_core::Rng| vec![common::uniform(rng, -3.1, 3.1), 0.0];
    let control = |rng: &mut sindyna_core::Rng, _| common::uniform(rng, -2.0, 2.0);
    let find = |seed| identify(&spec, &common::record(&truth, seed, 10, start, control, |_| false));
    assert_eq!(wrong(40, &terms, find), []);
    assert!((0..40).all(|seed| find(seed).report.equations.iter().all(|e| e.reached_floor)));
}

#[test]
fn the_papers_libraries_have_the_papers_sizes() {
    let parameters = |spec: &Spec, library, data: &Dataset| {
        let identifier = Identifier::new(spec).with_coordinates(CoordinateMode::Raw).with_library(library);
        let identifier = identifier.expect("a library").with_solver(SolverChoice::Stlsq(Stlsq::paper()));
        identifier.identify(data).expect("enough data").model.parameters()
    };
    let pendulum = common::pendulum().spec;
    let data = common::pendulum_data(0, 20);
    assert_eq!(parameters(&pendulum, LibraryChoice::Paper, &data), 99);
    assert_eq!(parameters(&pendulum, LibraryChoice::PaperDegree2, &data), 99);
    let car = common::mountain_car().spec;
    assert_eq!(parameters(&car, LibraryChoice::Paper, &common::mountain_car_data(0, 50)), 50);
    let cart_pole = common::cart_pole().spec;
    assert_eq!(parameters(&cart_pole, LibraryChoice::Paper, &common::cart_pole_data(0, 30)), 164);
    let inverted = common::inverted_pendulum().spec;
    assert_eq!(parameters(&inverted, LibraryChoice::Paper, &common::inverted_pendulum_data(0, 30)), 164);
}

#[test]
fn pendulum_as_a_map_needs_the_angle_itself() {
    let spec = common::pendulum().spec;
    let terms: [&[&str]; 2] = [&["θ", "ω", "sin θ", "u"], &["ω", "sin θ", "u"]];
    let identifier = Identifier::new(&spec).with_target(Target::Discrete);
    let wrong = wrong(40, &terms, |seed| identifier.identify(&common::pendulum_data(seed, 20)).expect("enough data"));
    assert!(wrong.len() <= 2, "{wrong:?}");
}

#[test]
fn the_papers_mass_is_found_from_one_push() {
    // §2: x, v observed, force g: ẋ = v, v̇ = g/M.
    let mass = 2.0;
    let x = Channel::new("x", "m", Kind::Plain, 1.0);
    let v = Channel::new("v", "m/s", Kind::RateOf(0), 1.0);
    let spec = Spec {
        name: "mass".into(),
        state: vec![x.clone(), v.clone()],
        observation: vec![x, v],
        control: vec![Channel::new("g", "N", Kind::Plain, 1.0)],
        action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt: 0.1,
    };
    let mut data = Dataset::new(2, 1, 1, 0.1);
    let (mut x, mut v) = (0.3, -0.2);
    data.begin(&[x, v]).expect("finite");
    for i in 0..30 {
        let g = (0.9 * f64::from(i)).sin();
        (x, v) = (x + 0.1 * v, v + 0.1 * g / mass);
        data.push(&[g], &[g], 0.0, &[x, v]).expect("finite");
    }
    let found = identify(&spec, &data);
    assert_eq!(supports(&found), [["v"], ["g"]]);
    assert!((found.report.equations[1].coefficients[0] - 1.0 / mass).abs() < 1e-12);
    assert!(found.report.equations.iter().all(|e| e.reached_floor && e.proved));
    assert_eq!(found.model.equations(), ["Δx/Δt = v", "Δv/Δt = 0.5 g"]);
}

fn lorenz(noise: f64, seed: u64) -> Array2<f64> {
    let field = |x: [f64; 3]| [10.0 * (x[1] - x[0]), x[0] * (28.0 - x[2]) - x[1], x[0] * x[1] - 8.0 / 3.0 * x[2]];
    let (mut x, h) = ([-8.0, 8.0, 27.0], 0.002);
    let mut rows = Vec::new();
    for _ in 0..5000 {
        rows.extend(x);
        let at = |k: [f64; 3], c: f64| std::array::from_fn(|i| x[i] + c * k[i]);
        let k1 = field(x);
        let k2 = field(at(k1, h / 2.0));
        let k3 = field(at(k2, h / 2.0));
        let k4 = field(at(k3, h));
        x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    let mut rng = sindyna_core::Seed::new(seed).stream("noise", 0);
    // Sum of uniform numbers: near enough to a normal one, of standard deviation 1.
    let mut normal = || (0..12).map(|_| common::uniform(&mut rng, -0.5, 0.5)).sum::<f64>();
    // The states' standard deviations are about 8.
    Array2::from_shape_vec((5000, 3), rows).expect("three columns").mapv(|v| v + 8.0 * noise * normal())
}

#[test]
fn lorenz_is_found_at_one_percent_noise() {
    let truth = [vec![1, 2], vec![1, 2, 6], vec![3, 5]];
    for seed in 0..5 {
        let x = lorenz(0.01, seed);
        let filter = SavitzkyGolay::new(41, 3).expect("an odd window");
        let target = Target::Continuous {
            differentiator: Differentiator::Smoothed(filter),
            scheme: Scheme::Rk4 { substeps: 1 },
        };
        for solver in [
            SolverChoice::Stlsq(Stlsq::new(0.5, 0.05).expect("valid settings")),
            SolverChoice::BestSubset(BestSubset::default().with_max_size(6)),
        ] {
            let fit = Sindy::new(Library::polynomial(2), target, solver).fit(&[Trajectory::new(x.view())], 0.002);
            let fit = fit.expect("plenty of samples");
            for (equation, truth) in fit.equations.iter().zip(&truth) {
                assert_eq!(equation.support, *truth, "seed {seed}, {solver:?}: {}", fit.model);
            }
            assert!((fit.coefficients[[1, 1]] - 28.0).abs() < 0.3, "{}", fit.model);
        }
    }
}

#[test]
fn pendulum_in_raw_observations_steps_the_angle() {
    let truth = common::pendulum();
    let data = common::pendulum_data(3, 60);
    let found =
        Identifier::new(&truth.spec).with_coordinates(CoordinateMode::Raw).identify(&data).expect("enough data");
    assert_eq!(found.model.states(), ["cos θ", "sin θ", "ω"]);
    let mut rng = sindyna_core::Seed::new(0).numpy();
    for angle in [0.3_f64, 3.1, 9.5, -20.0] {
        let (x, u) = ([angle, 1.0], [0.5]);
        let mut next = [0.0; 2];
        found.model.step(&x, &u, &mut rng, &mut next).expect("finite");
        let expected = (truth.step)(&x, &u);
        assert!((next[0] - expected[0]).abs() < 0.02 && (next[1] - expected[1]).abs() < 1e-3, "{next:?} {expected:?}");
    }
}

#[test]
fn rows_at_a_limit_are_kept_out_and_counted() {
    let truth = common::pendulum();
    let push = |rng: &mut sindyna_core::Rng, _| 2.0 + 0.0 * common::uniform(rng, 0.0, 1.0);
    // Full torque from a fast start: |ω| = 8 is reached.
    let mut data = common::record(&truth, 1, 12, |_| vec![0.2, 6.5], push, |_| false);
    let varied = common::pendulum_data(5, 10);
    for rollout in varied.rollouts() {
        data.begin(rollout.observations.row(0).as_slice().expect("a row")).expect("finite");
        for i in 0..rollout.controls.nrows() {
            let u = [rollout.controls[[i, 0]]];
            data.push(&u, &u, 0.0, rollout.observations.row(i + 1).as_slice().expect("a row")).expect("finite");
        }
    }
    let found = identify(&truth.spec, &data);
    assert!(found.report.rows_at_limit > 3, "{}", found.report.rows_at_limit);
    assert_eq!(found.report.rows + found.report.rows_at_limit, 22);
    assert_eq!(found.model.equations()[1], "Δω/Δt = 15 sin θ + 3 u");
}
