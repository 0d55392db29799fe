//! Exported Python modules, really run: they step as the model itself does.
//!
//! Python and NumPy are looked for in `.venv` at the root of the repository, which `scripts/mujoco_install` makes, or in
//! the virtual environment `SINDYNA_MUJOCO_VENV`.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use rand::RngExt as _;
use sindyna_core::{Dynamics as _, Rng, Scheme, Seed};
use sindyna_sindy::export::{Stepping, System, python};
use sindyna_sindy::{Entry, Form, Model, ModelParts, parse};

/// What `program` prints.
fn run(program: &str) -> String {
    let venv = std::env::var_os("SINDYNA_MUJOCO_VENV");
    let venv = venv.map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.venv"), PathBuf::from);
    let interpreter = venv.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let child = Command::new(&interpreter)
        .args(["-X", "utf8", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = child
        .unwrap_or_else(|e| panic!("{}: {e}\n\nthe tests need it: run scripts/mujoco_install", interpreter.display()));
    child.stdin.take().expect("it is piped").write_all(program.as_bytes()).expect("Python reads its program");
    let output = child.wait_with_output().expect("Python ends");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}\n{program}");
    String::from_utf8(output.stdout).expect("numbers are ASCII")
}

/// `count` rows of `width` numbers between −2 and 2.
fn random(count: usize, width: usize, rng: &mut Rng) -> Vec<Vec<f64>> {
    (0..count).map(|_| (0..width).map(|_| rng.random_range(-2.0..2.0)).collect()).collect()
}

/// The rows that `expression` over `x` and `u` gives, in Python.
fn evaluate(module: &str, expression: &str, x: &[Vec<f64>], u: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let program = format!(
        "{module}\nimport json\nx = np.array({x:?})\nu = np.array({u:?})\nprint(json.dumps(({expression}).tolist()))\n"
    );
    serde_json::from_str(&run(&program)).expect("rows of numbers")
}

fn agree(got: &[Vec<f64>], expected: &[Vec<f64>]) {
    assert_eq!(got.len(), expected.len());
    for (row, (got, expected)) in got.iter().zip(expected).enumerate() {
        assert_eq!(got.len(), expected.len());
        for (g, e) in got.iter().zip(expected) {
            assert!((g - e).abs() <= 1e-12 * e.abs().max(1.0), "row {row}: {got:?} is not {expected:?}");
        }
    }
}

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(ToString::to_string).collect()
}

/// A model with every function and operation, and names that are no Python.
fn model(form: Form) -> Model {
    Model::new(ModelParts {
        states: names(&["θ̇", "lambda", "cos x"]),
        controls: names(&["u", "2nd \"input\"\\"]),
        form,
        dt: 0.05,
        readings: None,
        terms: names(&[
            "1",
            "θ̇",
            "sin(3*lambda)*cos_x^2",
            "-(θ̇ - lambda)^3/(2 + u^2)",
            "exp(-abs(θ̇))*tanh(_2nd__input__)",
            "sqrt(abs(cos_x))*sign(u)*log(3 + u)",
            "tan(0.1*lambda)*(u^2 + 1)^-1",
            "cos(lambda)",
        ]),
        equations: vec![
            vec![Entry::new(1, 1.0), Entry::new(2, -0.25), Entry::new(4, 1.0 / 3.0)],
            vec![
                Entry::new(0, -0.1),
                Entry::new(3, 1e-3),
                Entry::new(5, 0.7),
                Entry::new(6, -2.5),
                Entry::new(7, std::f64::consts::PI),
                Entry::new(2, 123_456.789e-6),
                Entry::new(1, -1.0),
            ],
            vec![],
        ],
        kinematic: vec![false; 3],
        offsets: vec![0.0; 3],
        n_features: 8,
    })
    .expect("a model")
}

#[test]
fn every_form_steps_as_the_model_does() {
    let forms = [
        Form::Discrete,
        Form::Increment,
        Form::Continuous(Scheme::Euler),
        Form::Continuous(Scheme::Rk4 { substeps: 1 }),
        Form::Continuous(Scheme::Rk4 { substeps: 3 }),
    ];
    let mut rng = Seed::new(7).numpy();
    for form in forms {
        let model = model(form);
        let module = python(&System::from(&model), &names(&["a \"note\" with \\ in it"])).expect("a system");
        let (x, u) = (random(100, 3, &mut rng), random(100, 2, &mut rng));
        let next = x.iter().zip(&u).map(|(x, u)| {
            let mut next = vec![0.0; 3];
            model.step(x, u, &mut Seed::new(0).numpy(), &mut next).expect("it stays finite");
            next
        });
        let next: Vec<Vec<f64>> = next.collect();
        agree(&evaluate(&module, "step(x, u)", &x, &u), &next);
        // Any leading axes, and one input for all of them.
        agree(&evaluate(&module, "step(x.reshape(4, 5, 5, 3), u.reshape(4, 5, 5, 2)).reshape(100, 3)", &x, &u), &next);
        agree(&evaluate(&module, "step(x, u[0])[:1]", &x, &u), &next[..1]);
        agree(&evaluate(&module, "np.array([step(a, b) for a, b in zip(x, u)])", &x, &u), &next);
    }
}

#[test]
fn names_survive_and_wrong_shapes_are_refused() {
    let module = python(&System::from(&model(Form::Increment)), &[]).expect("a system");
    let program = format!(
        "{module}\nassert STATES == ('θ̇', 'lambda', 'cos x'), STATES\nassert INPUTS[1] == '2nd \"input\"\\\\', INPUTS\n\
         for x, u in [(np.zeros(2), np.zeros(2)), (np.zeros(3), np.zeros(3)), (0.0, np.zeros(2))]:\n    try:\n        \
         step(x, u)\n    except ValueError as e:\n        print(e)\n"
    );
    let refusals = run(&program);
    let expected = [
        "x must have shape (..., 3), got (2,)",
        "u must have shape (..., 2), got (3,)",
        "x must have shape (..., 3), got ()",
    ];
    assert_eq!(refusals.lines().collect::<Vec<_>>(), expected);
}

#[test]
fn a_system_without_inputs_needs_none() {
    let system = System {
        states: names(&["x"]),
        controls: vec![],
        dt: 0.1,
        terms: vec![parse("x", &names(&["x"])).expect("a term")],
        equations: vec![vec![Entry { term: 0, coefficient: -2.0, rate: None }]],
        stepping: Stepping::Euler,
        text: names(&["ẋ = −2 x"]),
    };
    let module = python(&system, &[]).expect("a system");
    let x = vec![vec![1.0], vec![-3.0]];
    agree(&evaluate(&module, "step(x)", &x, &[]), &[vec![0.8], vec![-2.4]]);
    agree(&evaluate(&module, "rhs(x)", &x, &[]), &[vec![-2.0], vec![6.0]]);
}

/// Gymnasium's pole on a cart, as two equations that hold each other's accelerations.
#[test]
fn rates_on_the_right_are_solved_for() {
    let (total, half_length, gravity, pole) = (1.1, 0.5, 9.8, 0.1);
    let variables = names(&["x", "θ", "v", "ω", "F"]);
    let term = |text: &str| parse(text, &variables).expect("a term");
    let entry = |term, coefficient, rate| Entry { term, coefficient, rate };
    let a = pole * half_length / total;
    let (b1, b2) = (gravity / (half_length * 4.0 / 3.0), -1.0 / (half_length * 4.0 / 3.0));
    let system = System {
        states: names(&["x", "θ", "v", "ω"]),
        controls: names(&["F"]),
        dt: 0.02,
        terms: ["v", "ω", "F", "ω^2*sin(θ)", "cos(θ)", "sin(θ)"].map(term).into(),
        equations: vec![
            vec![entry(0, 1.0, None)],
            vec![entry(1, 1.0, None)],
            vec![entry(2, 1.0 / total, None), entry(3, a, None), entry(4, -a, Some(3))],
            vec![entry(5, b1, None), entry(4, b2, Some(2))],
        ],
        stepping: Stepping::Euler,
        text: names(&["", "", "", ""]),
    };
    let truth = |x: &Vec<f64>, u: &Vec<f64>| {
        let (sin, cos) = x[1].sin_cos();
        let temp = (u[0] + pole * half_length * x[3] * x[3] * sin) / total;
        let turn = (gravity * sin - cos * temp) / (half_length * (4.0 / 3.0 - pole * cos * cos / total));
        vec![x[2], x[3], temp - pole * half_length * turn * cos / total, turn]
    };
    let mut rng = Seed::new(3).numpy();
    let (x, u) = (random(100, 4, &mut rng), random(100, 1, &mut rng));
    let rates: Vec<Vec<f64>> = x.iter().zip(&u).map(|(x, u)| truth(x, u)).collect();
    let module = python(&system, &[]).expect("a system");
    agree(&evaluate(&module, "rhs(x, u)", &x, &u), &rates);
    agree(&evaluate(&module, "rhs(x.reshape(10, 10, 4), u.reshape(10, 10, 1)).reshape(100, 4)", &x, &u), &rates);
    agree(&evaluate(&module, "np.array([rhs(a, b) for a, b in zip(x, u)])", &x, &u), &rates);
}

/// Gymnasium's pendulum: the rate first, then the angle by the new rate.
#[test]
fn semi_implicit_steps_move_positions_by_their_new_rates() {
    let variables = names(&["θ", "ω", "u"]);
    let term = |text: &str| parse(text, &variables).expect("a term");
    let entry = |term, coefficient| Entry { term, coefficient, rate: None };
    let system = System {
        states: names(&["θ", "ω"]),
        controls: names(&["u"]),
        dt: 0.05,
        terms: ["ω", "sin(θ)", "u"].map(term).into(),
        equations: vec![vec![entry(0, 1.0)], vec![entry(1, 15.0), entry(2, 3.0)]],
        stepping: Stepping::SemiImplicitEuler { positions: vec![0], substeps: 1 },
        text: names(&["", ""]),
    };
    let mut rng = Seed::new(3).numpy();
    let (x, u) = (random(100, 2, &mut rng), random(100, 1, &mut rng));
    let truth = |(x, u): (&Vec<f64>, &Vec<f64>)| {
        let rate = x[1] + 0.05 * (15.0 * x[0].sin() + 3.0 * u[0]);
        vec![x[0] + 0.05 * rate, rate]
    };
    let next: Vec<Vec<f64>> = x.iter().zip(&u).map(truth).collect();
    agree(&evaluate(&python(&system, &[]).expect("a system"), "step(x, u)", &x, &u), &next);
}

/// A tilted pole on a cart, as the default target finds such systems: rates on the right, an offset, both kinds of steps.
#[test]
fn implicit_equations_with_an_offset_step_as_the_model_does() {
    let coupled = |term, coefficient, rate| Entry { term, coefficient, rate: Some(rate) };
    let mut rng = Seed::new(4).numpy();
    for form in [Form::SemiImplicit { substeps: 3 }, Form::Continuous(Scheme::Rk4 { substeps: 2 })] {
        let model = Model::new(ModelParts {
            states: names(&["x", "θ", "v", "ω"]),
            controls: names(&["F"]),
            form,
            dt: 0.02,
            readings: None,
            terms: names(&["v", "ω", "F", "ω^2*sin(θ)", "cos(θ)", "sin(θ)"]),
            equations: vec![
                vec![Entry::new(0, 1.0)],
                vec![Entry::new(1, 1.0)],
                vec![Entry::new(2, 0.9), Entry::new(3, 0.045), coupled(4, -0.045, 3)],
                vec![Entry::new(5, 14.7), coupled(4, -1.5, 2)],
            ],
            kinematic: vec![true, true, false, false],
            offsets: vec![0.0, 0.1, 0.0, 0.0],
            n_features: 6,
        })
        .expect("a model");
        let (x, u) = (random(100, 4, &mut rng), random(100, 1, &mut rng));
        let next = x.iter().zip(&u).map(|(x, u)| {
            let mut next = vec![0.0; 4];
            model.step(x, u, &mut Seed::new(0).numpy(), &mut next).expect("it stays finite");
            next
        });
        let module = python(&System::from(&model), &[]).expect("a system");
        agree(&evaluate(&module, "step(x, u)", &x, &u), &next.collect::<Vec<_>>());
    }
}

#[test]
fn lists_that_do_not_fit_are_refused() {
    let good = System::from(&model(Form::Increment));
    type Break = fn(&mut System);
    let breaks: [Break; 5] = [
        |s| drop(s.equations.pop()),
        |s| drop(s.terms.pop()),
        |s| drop(s.controls.pop()),
        |s| s.equations[0][0].rate = Some(3),
        |s| s.equations[0][0].coefficient = f64::NAN,
    ];
    for (i, apply) in breaks.into_iter().enumerate() {
        let mut system = good.clone();
        apply(&mut system);
        assert!(python(&system, &[]).is_err(), "break {i}");
    }
}
