//! Steps with dry friction in every language, executed: a joint that stops, sticks and is pushed again, and two that are coupled by their rates, are where the
//! model has them after each of 300 steps. Python is that of `.venv`, or of the environment `SINDYNA_MUJOCO_VENV`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use sindyna_core::{Dynamics as _, Scheme, Seed};
use sindyna_export::{Contents, Interface, Language, Names, Program, program};
use sindyna_sindy::export::System;
use sindyna_sindy::{Entry, Form, Model, ModelParts};

const STEPS: usize = 300;

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(ToString::to_string).collect()
}

fn rk4(substeps: usize) -> Form {
    Form::Continuous(Scheme::Rk4 { substeps })
}

/// A mass on a spring, rubbed the harder the farther it is out; its friction is sought in two halves of a step.
fn one() -> Model {
    Model::new(ModelParts {
        states: names(&["x", "v"]),
        controls: names(&["u"]),
        form: rk4(2),
        dt: 0.05,
        readings: None,
        terms: names(&["v", "x", "sign(v)", "u", "-sign(v)*abs(x)/2"]),
        equations: vec![
            vec![Entry::new(0, 1.0)],
            vec![Entry::new(1, -9.0), Entry::new(2, -1.5), Entry::new(3, 1.0), Entry::new(4, 0.8)],
        ],
        kinematic: vec![true, false],
        offsets: vec![0.1, 0.0],
        n_features: 5,
    })
    .unwrap()
}

/// Two links on springs with friction in both joints, each of which the other's acceleration drives.
fn two() -> Model {
    let coupled = |term, coefficient, rate| Entry { term, coefficient, rate: Some(rate) };
    Model::new(ModelParts {
        states: names(&["a", "b", "v", "w"]),
        controls: names(&["u"]),
        form: rk4(1),
        dt: 0.04,
        readings: None,
        terms: names(&["v", "w", "sin(a)", "sin(b)", "u", "sign(v)", "sign(w)", "cos(a-b)", "w^2*sin(a-b)"]),
        equations: vec![
            vec![Entry::new(0, 1.0)],
            vec![Entry::new(1, 1.0)],
            vec![
                Entry::new(2, -5.0),
                Entry::new(4, 2.0),
                Entry::new(5, -1.2),
                coupled(7, -0.4, 3),
                Entry::new(8, -0.4),
            ],
            vec![Entry::new(3, -7.0), Entry::new(6, -0.9), coupled(7, -0.7, 2)],
        ],
        kinematic: vec![true, true, false, false],
        offsets: vec![0.0; 4],
        n_features: 9,
    })
    .unwrap()
}

/// The models with where they begin and their speeds.
fn models() -> [(&'static str, Model, Vec<f64>, Vec<usize>); 2] {
    [("one", one(), vec![1.0, 0.3], vec![1]), ("two", two(), vec![0.6, -0.4, 0.0, 0.5], vec![2, 3])]
}

/// Left alone, pushed harder and harder, left alone again.
fn input(t: usize) -> f64 {
    let t = t as f64;
    if (100.0..220.0).contains(&t) { 5.0 * (0.021 * (t - 100.0)).sin() } else { 0.0 }
}

/// All states after the first, step by step.
fn expected(model: &Model, x0: &[f64], speeds: &[usize]) -> Vec<f64> {
    let (mut x, mut all) = (x0.to_vec(), Vec::new());
    for t in 0..STEPS {
        let mut next = vec![0.0; x.len()];
        model.step(&x, &[input(t)], &mut Seed::new(0).numpy(), &mut next).unwrap();
        all.extend(&next);
        x = next;
    }
    for i in speeds {
        let rests: Vec<bool> = all.chunks(x0.len()).map(|x| x[*i] == 0.0).collect();
        let starts = rests.windows(2).filter(|pair| pair[0] && !pair[1]).count();
        let count = rests.iter().filter(|r| **r).count();
        assert!(starts >= 1 && (20..280).contains(&count), "speed {i}: {starts} starts, {count} steps at rest");
    }
    all
}

/// What `program` prints in `directory`; `None` if it is not here, which fails where `SINDYNA_MUJOCO_VENV` says that all is.
fn run(directory: &Path, program: &Path, args: &[&str]) -> Option<Vec<f64>> {
    let output = match Command::new(program).current_dir(directory).args(args).output() {
        Ok(output) => output,
        Err(e) => {
            assert!(std::env::var_os("SINDYNA_MUJOCO_VENV").is_none(), "there is no {}: {e}", program.display());
            std::io::stderr().write_all(format!("not run: there is no {}\n", program.display()).as_bytes()).unwrap();
            return None;
        }
    };
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{} {args:?}: {errors}", program.display());
    let text = String::from_utf8(output.stdout).unwrap();
    let parts = text.split(|c: char| c.is_whitespace() || ",[]".contains(c)).filter(|w| !w.is_empty());
    Some(parts.map(|w| w.parse().unwrap_or_else(|_| panic!("{w}"))).collect())
}

/// What `script` prints in the Python of `.venv`; `None` if it has no `package`.
fn python(directory: &Path, package: &str, script: &str) -> Option<Vec<f64>> {
    let venv = std::env::var_os("SINDYNA_MUJOCO_VENV");
    let venv = venv.map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.venv"), PathBuf::from);
    let at = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };
    let interpreter = std::path::absolute(venv.join(at)).unwrap();
    let has = format!("import importlib.util; print(int(importlib.util.find_spec('{package}') is not None))");
    if run(directory, &interpreter, &["-c", &has])? == [0.0] {
        assert!(std::env::var_os("SINDYNA_MUJOCO_VENV").is_none(), "there is no {package}");
        std::io::stderr().write_all(format!("not run: there is no package {package}\n").as_bytes()).unwrap();
        return None;
    }
    run(directory, &interpreter, &["-X", "utf8", "-c", script])
}

/// Writes `model` in `language` to `file` of `directory`.
fn write(directory: &Path, model: &Model, language: &str, file: &str) {
    match program(model, None, Names::default(), language).unwrap().contents {
        Contents::Text(text) => fs::write(directory.join(file), text).unwrap(),
        Contents::Bytes(bytes) => fs::write(directory.join(file), bytes).unwrap(),
    }
}

fn same(what: &str, found: Option<Vec<f64>>, expected: &[f64]) {
    let Some(found) = found else { return };
    assert_eq!(found.len(), expected.len(), "{what}");
    let errors = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    let (at, worst) = errors.enumerate().fold((0, 0.0), |worst, error| if error.1 <= worst.1 { worst } else { error });
    assert!(worst <= 1e-12, "{what}: off by {worst:e} at number {at}");
}

/// Runs `of` for each model in a directory of its own, with its inputs as a list and what is to come.
fn each(of: impl Fn(&Path, &str, &Model, &str, (&[f64], &[f64]))) {
    for (name, model, x0, speeds) in models() {
        let temp = tempfile::tempdir().unwrap();
        let inputs: Vec<String> = (0..STEPS).map(|t| format!("{:?}", input(t))).collect();
        of(temp.path(), name, &model, &inputs.join(", "), (&x0, &expected(&model, &x0, &speeds)));
    }
}

fn list(x: &[f64]) -> String {
    x.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(", ")
}

#[test]
fn c() {
    each(|directory, name, model, inputs, (x0, expected)| {
        write(directory, model, "c", "model.c");
        let main = format!(
            "#include <stdio.h>\n#include \"model.c\"\nint main(void)\n{{\n    const double u[{STEPS}] = {{{inputs}}};\n    \
             double x[STATES] = {{{}}}, next[STATES];\n    int t, i;\n    for (t = 0; t < {STEPS}; t++) {{\n        \
             sindyna_step(x, u + t, next);\n        for (i = 0; i < STATES; i++) printf(\"%.17g \", x[i] = next[i]);\n    }}\n    return 0;\n}}\n",
            list(x0)
        );
        fs::write(directory.join("main.c"), main).unwrap();
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "main.c", "-o", "main", "-lm"];
        let found = run(directory, Path::new("cc"), &flags).and_then(|_| run(directory, &directory.join("main"), &[]));
        same(&format!("{name} in C"), found, expected);
    });
}

#[test]
fn javascript() {
    each(|directory, name, model, inputs, (x0, expected)| {
        write(directory, model, "javascript", "model.mjs");
        let main = format!(
            "import {{ step }} from './model.mjs';\nlet x = [{}];\nfor (const u of [{inputs}]) {{\n    x = step(x, [u]);\n    console.log(x.join(' '));\n}}\n",
            list(x0)
        );
        fs::write(directory.join("main.mjs"), main).unwrap();
        same(&format!("{name} in JavaScript"), run(directory, Path::new("node"), &["main.mjs"]), expected);
    });
}

#[test]
fn page() {
    each(|directory, name, model, inputs, (x0, expected)| {
        let interface = Interface::without_policy(
            name.to_owned(),
            model.states().to_vec(),
            vec![x0.to_vec()],
            (vec![(-5.0, 5.0)], vec![0.0]),
        );
        let equations = Program::new(System::from(model), Vec::new()).with_interface(Some(interface));
        let Contents::Text(page) = Language::Html.write(&equations).unwrap().contents else { panic!("no text") };
        let script = page.split_once("<script id=\"model\">").unwrap().1.split_once("</script>").unwrap().0;
        let main = format!(
            "{script}\nlet x = [{}];\nfor (const u of [{inputs}]) {{\n    x = next(x, [u]);\n    console.log(x.join(' '));\n}}\n",
            list(x0)
        );
        fs::write(directory.join("main.js"), main).unwrap();
        same(&format!("{name} in a page"), run(directory, Path::new("node"), &["main.js"]), expected);
    });
}

#[test]
fn rust() {
    each(|directory, name, model, inputs, (x0, expected)| {
        write(directory, model, "rust", "model.rs");
        let main = format!(
            "mod model;\nfn main() {{\n    let mut x = [{}];\n    for u in [{inputs}] {{\n        x = model::step(&x, &[u]);\n        println!(\"{{x:?}}\");\n    }}\n}}\n",
            list(x0)
        );
        fs::write(directory.join("main.rs"), main).unwrap();
        let flags = ["--edition", "2024", "-A", "dead_code", "-D", "warnings", "main.rs", "-o", "rusty"];
        let found =
            run(directory, Path::new("rustc"), &flags).and_then(|_| run(directory, &directory.join("rusty"), &[]));
        same(&format!("{name} in Rust"), found, expected);
    });
}

/// One after the other, and all at once, where some rest and some move.
#[test]
fn numpy() {
    each(|directory, name, model, inputs, (x0, expected)| {
        write(directory, model, "python", "model.py");
        let script = format!(
            "import model, numpy as np\nx = np.array([{}])\nu = np.array([{inputs}])[:, np.newaxis]\nall = [x]\nfor t in range({STEPS}):\n    \
             all.append(model.step(all[-1], u[t]))\n    print(all[-1].tolist())\nall = np.array(all)\n\
             n = all.shape[1]\ntogether = model.step(all[:-1].reshape(10, 30, n), u.reshape(10, 30, 1)).reshape({STEPS}, n)\n\
             assert np.abs(together - all[1:]).max() < 1e-12\nassert model.step(all[:0], u[:0]).shape == (0, n)\n\
             assert model.step(all[:4], u[120]).shape == (4, n)\n",
            list(x0)
        );
        same(&format!("{name} in NumPy"), python(directory, "numpy", &script), expected);
    });
}

#[test]
fn casadi() {
    each(|directory, name, model, inputs, (x0, expected)| {
        write(directory, model, "casadi", "model.py");
        let script = format!(
            "from model import F\nx = [{}]\nfor u in [{inputs}]:\n    x = F(x, u)\n    print(x.full().ravel().tolist())\n\
             import casadi as ca\nx, u = ca.MX.sym('x', F.size1_in(0)), ca.MX.sym('u')\n\
             J = ca.Function('J', [x, u], [ca.jacobian(F(x, u), ca.vertcat(x, u))])\n\
             assert J([{}], 0.1).is_regular(), J([{}], 0.1)\n",
            list(x0),
            list(x0),
            list(x0)
        );
        same(&format!("{name} in CasADi"), python(directory, "casadi", &script), expected);
    });
}

#[test]
fn onnx() {
    each(|directory, name, model, inputs, (x0, expected)| {
        write(directory, model, "onnx", "model.onnx");
        let script = format!(
            "import numpy as np, onnxruntime as ort\nstep = ort.InferenceSession('model.onnx')\nu = np.array([{inputs}])[:, np.newaxis]\n\
             all = np.array([[{}]])\nfor t in range({STEPS}):\n    x, = step.run(['next'], {{'x': all[-1:], 'u': u[t:t + 1]}})\n    \
             all = np.concatenate([all, x])\n    print(x.ravel().tolist())\n\
             together, = step.run(['next'], {{'x': all[:-1], 'u': u}})\nassert np.abs(together - all[1:]).max() < 1e-12\n",
            list(x0)
        );
        same(&format!("{name} in ONNX Runtime"), python(directory, "onnxruntime", &script), expected);
    });
}

#[test]
fn fmu() {
    if run(&std::env::temp_dir(), Path::new("cc"), &["-dumpversion"]).is_none() {
        return;
    }
    each(|directory, name, model, inputs, (x0, expected)| {
        write(directory, model, "fmu", "model.fmu");
        let dt = model.dt();
        let script = format!(
            "from fmpy import extract, read_model_description\nfrom fmpy.fmi2 import FMU2Slave\nx = [{}]\nn = len(x)\n\
             about = read_model_description('model.fmu')\nfmu = FMU2Slave(guid=about.guid, unzipDirectory=extract('model.fmu'), \
             modelIdentifier=about.coSimulation.modelIdentifier, instanceName='i')\nfmu.instantiate()\nfmu.setupExperiment(startTime=0.0)\n\
             fmu.enterInitializationMode()\nfmu.setReal(range(n), x)\nfmu.exitInitializationMode()\n\
             for t, u in enumerate([{inputs}]):\n    fmu.setReal([n], [u])\n    fmu.doStep(t * {dt:?}, {dt:?})\n    print(fmu.getReal(range(n)))\n",
            list(x0)
        );
        same(&format!("{name} as an FMU"), python(directory, "fmpy", &script), expected);
    });
}
