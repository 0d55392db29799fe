//! Equations as people read them, and models as files keep them.

mod common;

use insta::assert_snapshot;
use sindyna_core::{Precision, Scheme};
use sindyna_sindy::{
    CoordinateMode, Differentiator, Entry, Expr, Form, Identifier, LibraryChoice, Model, ModelParts, SolverChoice,
    Stlsq, Target, parse,
};

#[test]
fn pendulum() {
    let spec = common::pendulum().spec;
    let identifier = Identifier::new(&spec).with_target(Target::Increment);
    let found = identifier.identify(&common::pendulum_data(0, 20)).expect("enough rows");
    assert_snapshot!(found.model, @r"
    Δθ/Δt = ω + 0.75 sin θ + 0.15 u
    Δω/Δt = 15 sin θ + 3 u
    ");
    assert_eq!((found.model.nonzero(), found.model.nonzero_paper()), (2, 7));
}

#[test]
fn mountain_car_as_a_map() {
    let spec = common::mountain_car().spec;
    let identifier = Identifier::new(&spec).with_library(LibraryChoice::Paper).expect("two states");
    let found = identifier.with_target(Target::Discrete).identify(&common::mountain_car_data(0, 50)).expect("rows");
    assert_snapshot!(found.model, @r"
    x⁺ = x + 0.999998 v − 0.00249997 cos 3x + 0.0015 u
    v⁺ = v − 0.0025 cos 3x + 0.0015 u
    ");
    assert_eq!((found.model.parameters(), found.model.nonzero(), found.model.nonzero_paper()), (50, 3, 7));
}

#[test]
fn every_form_says_what_is_on_its_left() {
    let mut spec = common::pendulum().spec;
    spec.precision = Precision::F64;
    let data = common::pendulum_data(0, 30);
    let target = Target::Continuous { differentiator: Differentiator::default(), scheme: Scheme::Euler };
    let solver = SolverChoice::Stlsq(Stlsq::new(0.5, 0.0).expect("valid settings"));
    let terms = LibraryChoice::Terms(["ω", "sin(θ)", "u"].map(String::from).to_vec());
    let identifier = Identifier::new(&spec).with_library(terms).expect("terms").with_solver(solver);
    let left = |identifier: Identifier| {
        let equations = identifier.identify(&data).expect("rows").model.equations();
        equations.iter().map(|e| e.split(" = ").next().unwrap_or("").to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(left(identifier.clone().with_target(target)), ["θ̇", "ω̇"]);
    assert_eq!(left(identifier.clone().with_target(Target::Discrete)), ["θ⁺", "ω⁺"]);
    assert_eq!(left(identifier), ["Δθ/Δt", "Δω/Δt"]);
    let raw = Identifier::new(&spec).with_coordinates(CoordinateMode::Raw);
    assert_eq!(left(raw), ["Δ(cos θ)/Δt", "Δ(sin θ)/Δt", "Δω/Δt"]);
}

#[test]
fn terms_for_people() {
    let names: Vec<String> = ["θ", "v", "cos φ"].map(String::from).into();
    let symbols: Vec<String> = ["θ", "v", "c"].map(String::from).into();
    let pretty = |text: &str| parse(text, &symbols).expect("a term").pretty(&names).to_string();
    for (text, expected) in [
        ("v^2*sin(θ)", "v²·sin θ"),
        ("cos(3*v)", "cos 3v"),
        ("sin(θ)^2", "sin² θ"),
        ("sin(θ + v)*(v - 1)", "sin(θ + v)·(v − 1)"),
        ("c^2*sin(c)", "(cos φ)²·sin(cos φ)"),
        ("v^-1/(θ*v)", "v⁻¹/(θ·v)"),
        ("-v*-2", "(−v)·(−2)"),
        ("0.0000012345678*v", "1.23457e−6v"),
        ("v^0.7*θ", "v^0.7·θ"),
        ("(θ + v)^-1.5", "(θ + v)^−1.5"),
        ("c^2.0", "(cos φ)²"),
    ] {
        assert_eq!(pretty(text), expected);
    }
}

#[test]
fn json_keeps_every_digit() {
    let parts = ModelParts {
        states: vec!["pole angle".into(), "ω".into()],
        controls: vec!["u".into()],
        form: Form::Continuous(Scheme::Rk4 { substeps: 2 }),
        dt: 0.1 + 0.2,
        readings: None,
        terms: vec!["sin(pole_angle)".into(), "0.1*u + 1e-300".into()],
        equations: vec![
            vec![Entry::new(1, f64::MIN_POSITIVE)],
            vec![Entry::new(0, 1.0 / 3.0), Entry { term: 1, coefficient: -5e-324, rate: Some(0) }],
        ],
        kinematic: vec![true, false],
        offsets: vec![0.0; 2],
        n_features: 2,
    };
    let model = Model::new(parts).expect("a valid model");
    assert_eq!(Model::from_json(&model.to_json()), Ok(model.clone()));
    let direct: Model = serde_json::from_str(&serde_json::to_string(&model).expect("JSON")).expect("a model");
    assert_eq!(direct, model);
    assert_eq!(model.terms()[0], Expr::Call(sindyna_sindy::Function::Sin, Box::new(Expr::Variable(0))));
    assert_eq!(model.equations()[1], "ω̇ = 0.333333 sin(pole angle) − 4.94066e−324 (0.1u + 1e−300)·dpole angle/dt");
}
