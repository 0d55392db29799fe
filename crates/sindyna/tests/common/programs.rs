//! Programs that `sindyna export` writes, and the tools that run them.

use std::io::Write as _;
use std::panic::Location;
use std::path::Path;
use std::process::Command;

use super::{parts, python, sindyna};

/// A model of two states and one control with these terms, equations, form, and more of its fields.
pub(crate) fn model(form: &str, terms: &str, equations: &str, kinematic: &str) -> String {
    format!(
        r#"{{"format": 2, {form}, "dt": 0.1, "states": ["x", "v"], "controls": ["u"], "terms": {terms}, "equations": {equations},
           "kinematic": {kinematic}, "n_features": 9}}"#
    )
}

/// Models of every form, with every function, powers, implicit equations, and names that want to be code.
pub(crate) fn models() -> Vec<(&'static str, String)> {
    let terms = r#"["v", "sin(x)*v^2", "max(x-0.3,0)", "sign(v)*abs(x)", "u/(2+cos(x))", "x^-2", "exp(-x^2)", "sqrt(abs(v))", "tanh(3*x)", "1", "log(2+x^2)", "atan(5*v)"]"#;
    let many = r#"[[{"term": 0, "coefficient": 1.0}],
        [{"term": 1, "coefficient": -0.7}, {"term": 2, "coefficient": 3.1}, {"term": 3, "coefficient": -1e-9}, {"term": 4, "coefficient": 2.5},
         {"term": 5, "coefficient": 1e-3}, {"term": 6, "coefficient": -0.25}, {"term": 7, "coefficient": 0.125}, {"term": 8, "coefficient": -0.4},
         {"term": 9, "coefficient": 0.01}, {"term": 10, "coefficient": -1.5}, {"term": 11, "coefficient": 0.6}]]"#;
    let implicit = r#"[[{"term": 0, "coefficient": 1.0}, {"term": 1, "coefficient": 0.2, "rate": 1}],
        [{"term": 4, "coefficient": -2.0}, {"term": 8, "coefficient": 0.3, "rate": 0}, {"term": 6, "coefficient": 0.4, "rate": 1}]]"#;
    let free = "[false, false]";
    let mut all = vec![
        ("map", model(r#""form": "discrete""#, terms, many, free)),
        ("increment", model(r#""form": "increment""#, terms, many, free)),
        ("euler", model(r#""form": "continuous", "scheme": "euler""#, terms, many, free)),
        ("rk4", model(r#""form": "continuous", "scheme": {"rk4": {"substeps": 3}}"#, terms, many, "[true, false]")),
        (
            "semi-implicit",
            model(
                r#""form": "semi_implicit", "scheme": {"semi_implicit_euler": {"substeps": 2}}"#,
                terms,
                many,
                "[true, false]",
            ),
        ),
        ("implicit", model(r#""form": "continuous", "scheme": {"rk4": {"substeps": 2}}"#, terms, implicit, free)),
    ];
    let names = r#""states": ["*/ exit(1); /*", "\"\n'''\"\"\"\\ import os; os.abort() //"], "controls": ["class"]"#;
    let hostile = model(
        r#""form": "continuous", "scheme": "euler""#,
        r#"["1"]"#,
        r#"[[{"term": 0, "coefficient": 1.5}], []]"#,
        free,
    );
    all.push(("hostile", hostile.replace(r#""states": ["x", "v"], "controls": ["u"]"#, names)));
    // Words of the languages, markup, and names that are the same once only letters are left.
    let names = r#""states": ["time", "]]> <x y=\"&\"/> {} c0"], "controls": ["]]> <x y=\"?\"/> {} c0"]"#;
    all.push(("markup", hostile.replace(r#""states": ["x", "v"], "controls": ["u"]"#, names)));
    all
}

/// States and controls at which programs are compared.
pub(crate) fn points() -> Vec<[f64; 3]> {
    (0..40).map(|i| [1.0, 1.7, 2.3].map(|k| 2.0 * (k * f64::from(i) + 0.3).sin())).collect()
}

pub(crate) fn export(directory: &Path, language: &str, out: &str) {
    let (code, stdout, stderr) = parts(&sindyna(directory, &["export", ".", "--to", language, "--out", out]));
    assert_eq!(code, 0, "{stdout}{stderr}");
}

/// What `program` prints in `directory`; `None` if there is no such program here.
#[track_caller]
pub(crate) fn run(directory: &Path, program: &str, args: &[&str]) -> Option<String> {
    let output = match Command::new(program).current_dir(directory).args(args).output() {
        Ok(output) => output,
        Err(e) => {
            missing(&format!("{program} ({e})"));
            return None;
        }
    };
    assert!(output.status.success(), "{program} {args:?}: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

/// What `script` prints in `directory`, run by the Python of `.venv`; `None` if it has no `package`.
#[track_caller]
pub(crate) fn python_with(directory: &Path, package: &str, script: &str) -> Option<String> {
    let has = format!("import importlib.util; print(importlib.util.find_spec('{package}') is not None)");
    if python(directory, &has).trim() != "True" {
        missing(&format!("package {package} (scripts/mujoco_install)"));
        return None;
    }
    Some(python(directory, script))
}

/// Says on stderr, which the harness does not hold back, that a test was not run for want of `what`; fails where `SINDYNA_MUJOCO_VENV` names
/// an environment, in which everything must be there.
#[track_caller]
fn missing(what: &str) {
    assert!(std::env::var_os("SINDYNA_MUJOCO_VENV").is_none(), "there is no {what}");
    let line = format!("not run, as there is no {what}: {}\n", Location::caller());
    std::io::stderr().write_all(line.as_bytes()).unwrap();
}

/// Numbers between white space.
pub(crate) fn numbers(text: &str) -> Vec<f64> {
    text.split(|c: char| c.is_whitespace() || ",[]".contains(c))
        .filter(|w| !w.is_empty())
        .map(|w| w.parse().unwrap())
        .collect()
}

pub(crate) fn same(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{what}, number {i}: {a} is not {b}");
    }
}
