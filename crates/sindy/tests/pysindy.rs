//! The same numbers as PySINDy 2.1.0; see `golden/pysindy/README.md` for how they were made.

use ndarray::{Array1, Array2, array};
use serde::Deserialize;
use sindyna_core::Scheme;
use sindyna_sindy::{
    Columns, Differentiator, Finish, FiniteDifference, Library, SavitzkyGolay, Sindy, SolverChoice, Stlsq, Target,
    Trajectory, Triangle,
};

#[derive(Deserialize)]
struct Golden {
    dt: f64,
    x: Vec<Vec<f64>>,
    u: Option<Vec<Vec<f64>>>,
    x_dot: Option<Vec<Vec<f64>>>,
    feature_names: Vec<String>,
    theta_head: Vec<Vec<f64>>,
    coefficients: Vec<Vec<f64>>,
}

fn golden(name: &str) -> Golden {
    let path = format!("{}/tests/golden/pysindy/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).expect("the golden file")).expect("its JSON")
}

fn matrix(rows: &[Vec<f64>]) -> Array2<f64> {
    let width = rows.first().map_or(0, Vec::len);
    Array2::from_shape_vec((rows.len(), width), rows.concat()).expect("rows of one width")
}

/// The largest difference of two arrays, relative to the largest number.
fn difference(ours: &Array2<f64>, theirs: &Array2<f64>) -> f64 {
    assert_eq!(ours.dim(), theirs.dim());
    let largest = theirs.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    (ours - theirs).iter().fold(0.0_f64, |m, v| m.max(v.abs())) / largest
}

fn continuous(differentiator: Differentiator) -> Target {
    Target::Continuous { differentiator, scheme: Scheme::Rk4 { substeps: 1 } }
}

fn order(p: usize) -> Target {
    continuous(Differentiator::Finite(FiniteDifference::new(p).expect("a valid order")))
}

fn smoothed() -> Target {
    continuous(Differentiator::Smoothed(SavitzkyGolay::default()))
}

fn stlsq(threshold: f64, ridge: f64) -> Stlsq {
    Stlsq::new(threshold, ridge).expect("valid settings")
}

/// Names and supports must be the same, numbers agree to 1e-8 of the largest.
fn check(name: &str, library: Library, target: Target, solver: Stlsq) {
    let golden = golden(name);
    let x = matrix(&golden.x);
    let u = golden.u.as_deref().map(matrix);
    let trajectory = match &u {
        Some(u) => Trajectory::new(x.view()).with_controls(u.view()),
        None => Trajectory::new(x.view()),
    };
    let fit = Sindy::new(library.clone(), target, SolverChoice::Stlsq(solver)).fit(&[trajectory], golden.dt);
    let fit = fit.expect("PySINDy fits it too");
    assert_eq!(fit.names, golden.feature_names, "{name}");

    let n = x.ncols();
    let k = u.as_ref().map_or(0, Array2::ncols);
    let inputs: Vec<String> = (0..n).map(|i| format!("x{i}")).chain((0..k).map(|i| format!("u{i}"))).collect();
    let terms = library.terms(&inputs).expect("terms");
    let head = Array2::from_shape_fn((golden.theta_head.len(), terms.len()), |(i, j)| {
        let z: Vec<f64> = golden.x[i].iter().chain(golden.u.iter().flat_map(|u| &u[i])).copied().collect();
        terms[j].expr.eval(&z)
    });
    assert!(difference(&head, &matrix(&golden.theta_head)) < 1e-14, "{name}: Θ");
    if let Some(x_dot) = &golden.x_dot {
        let error = difference(&fit.targets, &matrix(x_dot));
        assert!(error < 1e-8, "{name}: derivatives differ by {error:e}");
    }
    let theirs = matrix(&golden.coefficients);
    let support = |m: &Array2<f64>| m.mapv(|c| c.abs() > 0.0);
    assert_eq!(support(&fit.coefficients), support(&theirs), "{name}: supports");
    let error = difference(&fit.coefficients, &theirs);
    assert!(error < 1e-8, "{name}: coefficients differ by {error:e}");
}

#[test]
fn lorenz_with_default_settings() {
    check("lorenz_poly2_fd_stlsq", Library::polynomial(2), order(2), stlsq(0.1, 0.05));
}

#[test]
fn noisy_lorenz_with_smoothed_differences() {
    check("lorenz_noisy_poly2_smoothedfd_stlsq", Library::polynomial(2), smoothed(), stlsq(0.2, 0.05));
}

#[test]
fn lorenz_with_controls() {
    check("lorenz_control_poly2_fd_stlsq", Library::polynomial(2), order(2), stlsq(0.1, 0.05));
}

#[test]
fn lorenz_with_controls_normalised_columns_and_a_strong_ridge() {
    let solver = stlsq(0.3, 1.0).with_columns(Columns::Normalised);
    check("lorenz_control_poly2_smoothedfd_ridge", Library::polynomial(2), smoothed(), solver);
}

#[test]
fn duffing_with_differences_of_fourth_order() {
    check("duffing_poly3_fd4_stlsq", Library::polynomial(3), order(4), stlsq(0.05, 0.05));
}

#[test]
fn mountain_car_with_the_papers_library_and_settings() {
    let squares = Library::Polynomial { degree: 2, interaction: false, bias: true };
    let library = squares.plus(Library::fourier(3));
    check("mountaincar_paper_library_discrete_stlsq", library, Target::Discrete, Stlsq::paper());
}

#[test]
fn the_readme_example() {
    let t: Array1<f64> = Array1::linspace(0.0, 1.0, 100);
    let x = Array2::from_shape_fn((100, 2), |(i, j)| if j == 0 { 3.0 * (-2.0 * t[i]).exp() } else { 0.5 * t[i].exp() });
    let sindy = Sindy::new(Library::polynomial(2), order(2), SolverChoice::Stlsq(Stlsq::default()));
    let fit = sindy.fit(&[Trajectory::new(x.view())], 1.0 / 99.0).expect("a hundred samples");
    let theirs = array![
        [0.0, -2.000_119_452_993, 0.0, 0.0, 0.0, 0.0],
        [-2.773_341_650_601e-5, 0.0, 1.000_085_704_596, 0.0, 0.0, -4.029_690_185_249e-5]
    ];
    assert!(difference(&fit.coefficients, &theirs) < 1e-8, "{}", fit.coefficients);
    assert!((fit.score() - 0.999_999_996_294_611_9).abs() < 1e-12);
}

#[test]
fn the_logistic_map() {
    let mut x = vec![0.5];
    for i in 0..200 {
        x.push(3.6 * x[i] * (1.0 - x[i]));
    }
    let x = Array2::from_shape_vec((x.len(), 1), x).expect("one column");
    let sindy = Sindy::new(Library::polynomial(2), Target::Discrete, SolverChoice::Stlsq(Stlsq::default()));
    let fit = sindy.fit(&[Trajectory::new(x.view())], 1.0).expect("200 samples");
    assert!(difference(&fit.coefficients, &array![[0.0, 3.6, -3.6]]) < 1e-10, "{}", fit.coefficients);
}

/// A regression without random numbers: (A | y1 y2).
fn regression() -> Triangle {
    let rows = Array2::from_shape_fn((40, 7), |(i, j)| {
        let i = i as f64;
        let (s, c) = ((0.37 * i).sin(), (0.21 * i).cos());
        let a = [1.0, s, c, s * c, 0.05 * i];
        match j {
            5 => 2.0 * a[1] - 0.5 * a[4] + 0.02 * (1.7 * i).sin(),
            6 => 0.3 * a[0] + 1.5 * a[3] + 0.02 * (2.3 * i).cos(),
            _ => a[j],
        }
    });
    let mut triangle = Triangle::new(7);
    triangle.push(rows.view()).expect("finite rows");
    triangle
}

#[test]
fn the_regression_without_random_numbers_and_its_variants() {
    let triangle = regression();
    let first = [0.0, 2.000_257_128_36, 0.0, 0.0, -0.499_822_589_405];
    let second = [0.300_332_261_05, 0.0, 0.0, 1.499_621_910_482, 0.0];
    let shrunk = [0.0, 1.995_242_055_194, 0.0, 0.0, -0.499_064_050_056];
    let shrunk_second = [0.300_221_922_58, 0.0, 0.0, 1.491_831_480_379, 0.0];
    let cut = [0.0, 0.0, 0.0, 1.542_377_488_122, 0.0];
    let scaled = [9.037_082_787e-4, 2.000_242_228_544, 0.0, -6.418_851_631e-4, -0.500_572_503_185];
    let default = Stlsq::default();
    for (name, solver, expected) in [
        ("default", default, [first, second]),
        ("unbias=False", default.with_finish(Finish::Ridge), [shrunk, shrunk_second]),
        ("threshold=.4", stlsq(0.4, 0.05), [first, cut]),
        ("normalize_columns", default.with_columns(Columns::Normalised), [scaled, second]),
    ] {
        for (i, expected) in expected.into_iter().enumerate() {
            let fit = solver.solve(&triangle, 5, 5 + i);
            for (ours, theirs) in fit.coefficients.iter().zip(expected) {
                assert!((ours - theirs).abs() < 1e-10, "{name}: {ours} is not {theirs}");
            }
            assert!(fit.converged, "{name}");
        }
    }
}

#[test]
fn differences_of_sine_and_cosine() {
    let x = Array2::from_shape_fn((5, 2), |(i, j)| {
        let t = 0.25 * i as f64;
        if j == 0 { t.sin() } else { t.cos() }
    });
    let x_dot = FiniteDifference::default().differentiate(x.view(), 0.25).expect("five samples");
    let theirs = [[1.020_380_596_828, -0.003_865_750_096], [0.958_851_077_208, -0.244_834_876_219]];
    for (row, theirs) in x_dot.rows().into_iter().zip(theirs) {
        for (ours, theirs) in row.iter().zip(theirs) {
            assert!((ours - theirs).abs() < 1e-12);
        }
    }
}
