//! Equations that `sindyna export` writes for CasADi, ONNX Runtime and tools that read FMUs, executed: equal to the model.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;

use common::programs::{export, models, numbers, points, python_with, run, same};
use common::{parts, sindyna};
use sindyna_core::{Dynamics as _, Seed};
use sindyna_sindy::Model;

/// The models, each exported as `NAME<ending>`, with the states one step after [`points`].
fn exported(directory: &Path, language: &str, ending: &str) -> Vec<(&'static str, Model, Vec<f64>)> {
    let mut all = Vec::new();
    for (name, text) in models() {
        fs::write(directory.join("model.json"), &text).unwrap();
        export(directory, language, &format!("{}{ending}", name.replace('-', "_")));
        let model = Model::from_json(&text).unwrap();
        let next = points().iter().flat_map(|z| step(&model, z)).collect();
        all.push((name, model, next));
    }
    all
}

fn step(model: &Model, z: &[f64; 3]) -> [f64; 2] {
    let mut next = [0.0; 2];
    model.step(&z[..2], &z[2..], &mut Seed::new(0).numpy(), &mut next).unwrap();
    next
}

/// `z` and `names` for a script of Python.
fn given(all: &[(&'static str, Model, Vec<f64>)]) -> String {
    let names: Vec<String> = all.iter().map(|(name, ..)| name.replace('-', "_")).collect();
    format!("import numpy as np\nz = np.array({:?})\nnames = {names:?}\n", points())
}

/// Holds what a script printed, 80 numbers a model, against the models.
fn compare(language: &str, all: &[(&'static str, Model, Vec<f64>)], printed: &str) {
    let found = numbers(printed);
    assert_eq!(found.len(), 80 * all.len());
    for ((name, _, expected), found) in all.iter().zip(found.chunks(80)) {
        same(&format!("{name} in {language}"), found, expected, 1e-12);
    }
}

#[test]
fn casadi_computes_and_differentiates_the_equations() {
    let temp = tempfile::tempdir().unwrap();
    let all = exported(temp.path(), "casadi", ".py");
    let script = given(&all)
        + "import importlib, sys\nsys.path.insert(0, '.')\nfor name in names:\n    F = importlib.import_module(name).F\n    \
           for p in z:\n        print(*F(p[:2], p[2:]).full().ravel().tolist())\n";
    let Some(printed) = python_with(temp.path(), "casadi", &script) else { return };
    compare("CasADi", &all, &printed);

    let script = given(&all)
        + "import casadi as ca, importlib, sys\nsys.path.insert(0, '.')\nfor name in names:\n    \
           F = importlib.import_module(name).F\n    x, u = ca.MX.sym('x', 2), ca.MX.sym('u', 1)\n    \
           J = ca.Function('J', [x, u], [ca.jacobian(F(x, u), ca.vertcat(x, u))])\n    \
           print(*J([0.7, 0.4], [0.3]).full().ravel().tolist())\n";
    let found = numbers(&python_with(temp.path(), "casadi", &script).unwrap());
    for ((name, model, _), found) in all.iter().zip(found.chunks(6)) {
        let h = 1e-6;
        let mut expected = [0.0; 6];
        for j in 0..3 {
            let (mut low, mut high) = ([0.7, 0.4, 0.3], [0.7, 0.4, 0.3]);
            low[j] -= h;
            high[j] += h;
            let (low, high) = (step(model, &low), step(model, &high));
            (0..2).for_each(|i| expected[3 * i + j] = (high[i] - low[i]) / (2.0 * h));
        }
        same(&format!("derivatives of {name}"), found, &expected, 1e-7);
    }
}

#[test]
fn onnx_runtime_computes_the_equations() {
    let temp = tempfile::tempdir().unwrap();
    let all = exported(temp.path(), "onnx", ".onnx");
    let script = given(&all)
        + "import onnxruntime as ort\nfor name in names:\n    session = ort.InferenceSession(f'{name}.onnx')\n    \
           print(session.run(['next'], {'x': z[:, :2], 'u': z[:, 2:]})[0].ravel().tolist())\n    \
           assert session.run(['next'], {'x': z[:1, :2], 'u': z[:1, 2:]})[0].shape == (1, 2)\n";
    let Some(printed) = python_with(temp.path(), "onnxruntime", &script) else { return };
    compare("ONNX", &all, &printed);
}

#[test]
fn what_is_no_text_is_written_over_where_sindyna_wrote_it_alone() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("model.json"), &models()[0].1).unwrap();
    for (language, name) in [("onnx", "model.onnx"), ("fmu", "model.fmu")] {
        let file = temp.path().join(name);
        for _ in 0..2 {
            assert_eq!(parts(&sindyna(temp.path(), &["export", ".", "--to", language])).0, 0);
        }
        fs::write(&file, b"PK\x03\x04 of somebody else").unwrap();
        let (code, _, stderr) = parts(&sindyna(temp.path(), &["export", ".", "--to", language]));
        assert!(code == 2 && stderr.contains("exists and is not an export of sindyna"), "{stderr}");
        assert_eq!(fs::read(&file).unwrap(), b"PK\x03\x04 of somebody else");
        let (code, _, stderr) = parts(&sindyna(temp.path(), &["export", ".", "--to", language, "--out", "-"]));
        assert!(code == 2 && stderr.contains("is binary and not written to standard output"), "{stderr}");
    }
}

/// Steps of an FMU from each of `z`; the binary of this platform, or one that FMPy makes of the sources.
const SLAVE: &str = r#"
import contextlib, shutil, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

def slave(path):
    problems = validate_fmu(path)
    assert not problems, problems
    description = read_model_description(path)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=extract(path), modelIdentifier=description.coSimulation.modelIdentifier, instanceName="i")
    fmu.instantiate()
    return fmu, description

def stepped(fmu, values, *lengths):
    fmu.reset()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.setReal(range(len(values)), values)
    fmu.exitInitializationMode()
    at = 0.0
    for length in lengths:
        fmu.doStep(at, length)
        at += length
    return fmu.getReal([0, 1])
"#;

#[test]
fn fmus_compute_the_equations() {
    let temp = tempfile::tempdir().unwrap();
    if run(temp.path(), "cc", &["--version"]).is_none() {
        return;
    }
    let all = exported(temp.path(), "fmu", ".fmu");
    let script = given(&all)
        + SLAVE
        + "for name in names:\n    fmu, description = slave(f'{name}.fmu')\n    \
           assert [v.causality for v in description.modelVariables[:3]] == ['output', 'output', 'input']\n    \
           assert len({v.name for v in description.modelVariables}) == len(description.modelVariables)\n    \
           for p in z:\n        print(*stepped(fmu, p.tolist(), 0.1))\n";
    let Some(printed) = python_with(temp.path(), "fmpy", &script) else { return };
    compare("an FMU", &all, &printed);

    // Two steps as one, coefficients as parameters, states that are put back, a step that a map does not know; the same from the sources.
    let script = given(&all)
        + SLAVE
        + r"
fmu, description = slave('rk4.fmu')
p = z[0].tolist()
print(*stepped(fmu, p, 0.2), *stepped(fmu, p, 0.1, 0.1))
saved = fmu.getFMUState()
fmu.doStep(0.2, 0.1)
fmu.setFMUState(saved)
print(*fmu.getReal([0, 1]))
coefficients = [float(v.start) for v in description.modelVariables[3:]]
print(*stepped(fmu, p + [0.0] * len(coefficients), 0.1))
fmu, _ = slave('map.fmu')
refused = 0
with contextlib.redirect_stdout(sys.stderr):
    try:
        stepped(fmu, p, 0.15)
    except Exception:
        refused = 1
print(refused)
import os
from fmpy.build import build_platform_binary
unzipped = extract('rk4.fmu')
shutil.rmtree(os.path.join(unzipped, 'binaries'))
os.environ['PATH'] = os.path.dirname(sys.executable) + os.pathsep + os.environ['PATH']
printed = os.dup(1)
os.dup2(2, 1)
build_platform_binary(unzipped, all_warnings=True)
os.dup2(printed, 1)
fmu = FMU2Slave(guid=description.guid, unzipDirectory=unzipped, modelIdentifier='sindyna_model', instanceName='i')
fmu.instantiate()
print(*stepped(fmu, p, 0.2))
";
    let printed = numbers(&python_with(temp.path(), "fmpy", &script).unwrap());
    let rk4 = &all.iter().find(|(name, ..)| *name == "rk4").unwrap().1;
    let z = points()[0];
    let first = step(rk4, &z);
    let [x, v] = step(rk4, &[first[0], first[1], z[2]]);
    same("an FMU", &printed, &[x, v, x, v, x, v, z[0], z[1], 1.0, x, v], 1e-12);
}

#[test]
fn sources_of_an_fmu_have_no_warnings() {
    let temp = tempfile::tempdir().unwrap();
    let all = exported(temp.path(), "fmu", ".fmu");
    for (name, ..) in &all {
        // Nothing in the archive is compressed.
        let bytes = fs::read(temp.path().join(format!("{}.fmu", name.replace('-', "_")))).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let from = text.find("/* Written by sindyna export. */").unwrap();
        let end = "    return fmi2Discard;\n}\n";
        let to = from + text[from..].find("fmi2GetStringStatus").unwrap();
        let to = to + text[to..].find(end).unwrap() + end.len();
        fs::write(temp.path().join("model.c"), &text[from..to]).unwrap();
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-c", "model.c"];
        if run(temp.path(), "cc", &flags).is_none() {
            return;
        }
    }
}
