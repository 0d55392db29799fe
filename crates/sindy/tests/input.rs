//! Wrong input is answered with an error that says what is wrong, never with a panic.

mod common;

use ndarray::{Array2, array};
use sindyna_core::{Dataset, FitError};
use sindyna_sindy::{
    BestSubset, FiniteDifference, Identifier, Library, LibraryChoice, Model, SavitzkyGolay, Sindy, SolverChoice, Stlsq,
    Target, Trajectory, parse,
};

fn identify(data: &Dataset) -> Result<sindyna_sindy::Identified, FitError> {
    Identifier::new(&common::pendulum().spec).identify(data)
}

#[test]
fn too_few_rows_say_how_many_are_needed() {
    let error = identify(&common::pendulum_data(0, 3)).expect_err("three rows");
    assert_eq!(error.to_string(), "3 usable rows are too few to identify 1 equation; at least 4 are needed");
    assert!(matches!(identify(&Dataset::new(3, 1, 1, 0.05)), Err(FitError::TooFewRows { got: 0, .. })));
    // A few more are answered with some model, whatever it is worth.
    for steps in 4..8 {
        identify(&common::pendulum_data(0, steps)).expect("enough rows");
    }
}

#[test]
fn data_of_another_shape_are_refused() {
    let error = identify(&common::mountain_car_data(0, 20)).expect_err("two observed values");
    assert_eq!(error.to_string(), "observed values: expected 3, got 2");
    let error = identify(&Dataset::new(3, 1, 1, 0.1)).expect_err("another time step");
    assert_eq!(error.to_string(), "the data were recorded every 0.1 s, the system is declared with 0.05 s");
}

#[test]
fn data_without_any_motion_give_equations_without_terms() {
    let truth = common::mountain_car();
    let mut data = Dataset::new(2, 1, 1, 1.0);
    data.begin(&[0.0, 0.0]).expect("finite");
    for _ in 0..10 {
        data.push(&[0.0], &[0.0], 0.0, &[0.0, 0.0]).expect("finite");
    }
    let found = Identifier::new(&truth.spec).identify(&data).expect("ten rows");
    assert_eq!(found.model.equations(), ["x\u{307} = v", "v\u{307} = 0"]);
    assert_eq!((found.model.nonzero(), found.model.nonzero_paper()), (0, 3));
}

#[test]
fn terms_that_cannot_be_read_are_refused_with_their_place() {
    let names = ["x".to_owned(), "v".to_owned()];
    for (text, message) in [
        ("", "``: expected a number, a name or `(` at position 1, found the end"),
        ("x +", "`x +`: expected a number, a name or `(` at position 4, found the end"),
        ("sin(x", "`sin(x`: expected `)` at position 6, found the end"),
        ("x v", "`x v`: expected an operator or the end at position 3, found `v`"),
        ("x^0.5.1", "`x^0.5.1`: expected a number as the power at position 3, found `0`"),
        ("x^v", "`x^v`: expected a number as the power at position 3, found `v`"),
        ("2*y", "`2*y`: no variable named `y` (position 3); known: x, v"),
        ("1e999", "`1e999`: expected a finite number at position 1, found `1`"),
        ("1.2.3", "`1.2.3`: expected a finite number at position 1, found `1`"),
    ] {
        assert_eq!(parse(text, &names).expect_err(text).to_string(), message);
    }
    let unknown = parse("arctan(x)", &names).expect_err("no such function").to_string();
    assert!(
        unknown
            .ends_with("known: sin, cos, tan, exp, log, sqrt, abs, sign, tanh, max, atan, min, clip, atan2, tolerance"),
        "{unknown}"
    );
    assert!(parse(&"(".repeat(100_000), &names).is_err());
    assert!(parse(&"-".repeat(100_000), &names).is_err());
    let terms = LibraryChoice::Terms(vec!["ω^2*sin(φ)".into()]);
    let error = Identifier::new(&common::pendulum().spec).with_library(terms).expect_err("φ is no state");
    assert_eq!(error.to_string(), "`ω^2*sin(φ)`: no variable named `φ` (position 9); known: θ, ω, u");
}

#[test]
fn terms_that_are_not_finite_on_the_data_are_named() {
    let terms = LibraryChoice::Terms(vec!["u".into(), "log(ω - 100)".into()]);
    let identifier = Identifier::new(&common::pendulum().spec).with_library(terms).expect("terms over the variables");
    let error = identifier.identify(&common::pendulum_data(0, 20)).expect_err("a logarithm of negative numbers");
    assert_eq!(error.to_string(), "the term `log(ω - 100)` is NaN in row 0");
}

#[test]
fn a_term_of_zeros_is_never_chosen() {
    let terms = ["0*u", "u", "sin(θ)", "ω"].map(String::from).to_vec();
    for solver in [
        SolverChoice::BestSubset(BestSubset::default()),
        SolverChoice::Stlsq(Stlsq::default().with_columns(sindyna_sindy::Columns::Normalised)),
        SolverChoice::LeastSquares { ridge: 0.0 },
    ] {
        let identifier = Identifier::new(&common::pendulum().spec).with_library(LibraryChoice::Terms(terms.clone()));
        let found =
            identifier.expect("terms").with_solver(solver).identify(&common::pendulum_data(0, 20)).expect("rows");
        let equation = &found.report.equations[1];
        assert!(equation.coefficients.iter().all(|c| c.is_finite()));
        assert!(
            (equation.coefficients[equation.support.iter().position(|&j| j == 2).expect("sin θ")] - 15.0).abs() < 0.1
        );
    }
}

#[test]
fn plain_arrays_are_checked() {
    let sindy =
        Sindy::new(Library::polynomial(2), "continuous".parse().expect("a target"), "stlsq".parse().expect("a solver"));
    let x = Array2::from_shape_fn((20, 2), |(i, j)| (i * (j + 1)) as f64);
    let u = Array2::<f64>::zeros((7, 1));
    let message = |t: &[Trajectory<'_>], dt: f64| sindy.fit(t, dt).expect_err("wrong input").to_string();
    let fine = Trajectory::new(x.view());
    assert_eq!(message(&[fine], 0.0), "the time step must be finite and > 0, got 0");
    assert_eq!(message(&[], 0.1), "there are no samples");
    let wrong = fine.with_controls(u.view());
    assert_eq!(message(&[wrong], 0.1), "trajectory 0: rows of controls: expected 20, got 7");
    let narrow = array![[1.0], [2.0], [3.0]];
    assert_eq!(message(&[fine, Trajectory::new(narrow.view())], 0.1), "trajectory 1: states: expected 2, got 1");
    let mut nan = x.clone();
    nan[[3, 1]] = f64::NAN;
    assert_eq!(message(&[Trajectory::new(nan.view())], 0.1), "trajectory 0: a state is NaN in row 3, column 1");
    let short = array![[1.0, 2.0], [3.0, 4.0]];
    let message = message(&[Trajectory::new(short.view())], 0.1);
    assert_eq!(message, "trajectory 0: a trajectory of 2 samples is too short, at least 3 are needed");
    let discrete = Sindy::new(Library::Identity, Target::Discrete, "least-squares".parse().expect("a solver"));
    let one = array![[1.0, 2.0]];
    assert!(discrete.fit(&[Trajectory::new(one.view())], 1.0).is_err());
    let none = Array2::<f64>::zeros((0, 2));
    assert!(discrete.fit(&[Trajectory::new(none.view())], 1.0).is_err());
}

#[test]
fn settings_out_of_range_are_refused() {
    assert_eq!(Stlsq::new(f64::NAN, 0.05).expect_err("NaN").to_string(), "threshold must be finite and >= 0, got NaN");
    assert!(Stlsq::new(0.1, -1.0).is_err());
    assert!(Stlsq::default().with_max_iterations(0).is_err());
    assert!(FiniteDifference::new(0).is_err() && FiniteDifference::new(13).is_err());
    assert!(SavitzkyGolay::new(10, 3).is_err() && SavitzkyGolay::new(3, 3).is_err());
}

#[test]
fn models_that_are_none_are_refused() {
    let model = identify(&common::pendulum_data(0, 20)).expect("enough rows").model;
    let json = model.to_json();
    assert_eq!(Model::from_json(&json), Ok(model));
    let message = |from: &str, to: &str| {
        let changed = json.replacen(from, to, 1);
        assert_ne!(changed, json, "{from} is not in {json}");
        Model::from_json(&changed).expect_err(to).to_string()
    };
    assert_eq!(
        message("\"format\": 2", "\"format\": 9"),
        "the model has format version 9, this program reads version 2"
    );
    assert_eq!(message("\"dt\": 0.05", "\"dt\": 0.0"), "the control interval is 0");
    assert!(message("\"dt\": 0.05", "\"dt\": NaN").starts_with("not a model: "));
    assert!(message("\"dt\": 0.05,", "").contains("missing field `dt`"));
    assert_eq!(message("\"states\": [\n    \"θ\",", "\"states\": ["), "equations: expected 1, got 2");
    assert!(message("sin(θ)", "sin(φ)").contains("no variable named `φ`"));
    assert!(Model::from_json("").is_err() && Model::from_json("[]").is_err());
}
