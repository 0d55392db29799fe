//! What `sindyna export` writes of a run, executed: policies in CasADi and ONNX Runtime, equations and policy as one loop, and an FMU within its limits.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::programs::{export, numbers, python_with, run, same};
use common::{parts, python, sindyna};
use sindyna_core::{Dynamics as _, Mode, Observe as _, Policy as _, Precision, Seed, Sensors, Space, Spec};
use sindyna_rl::SavedPolicy;
use sindyna_sindy::Model;
use sindyna_training::problem;

/// A short run of a task, and what is known of it.
struct Run {
    directory: PathBuf,
    spec: Spec,
    sensors: Sensors,
    model: Model,
    policy: SavedPolicy,
}

/// A pendulum whose policy sees formulas of its state, too.
const SEEN: &str = r#"
name = "seen"
dt = 0.05
max_steps = 50
observation = ["cos a", "sin a", "w", "clip(w, -far, far)", "atan2(sin(a), 2 + cos(a))", "max(w, 0)*sign(bend)", "bend^2/(1 + w^2)", "far"]
[parameters]
far = 1.5
[let]
bend = "min(w, tan(a/4))"
[equations]
w = "-2*sin(a) - 0.3*w + 3*u"
[[state]]
name = "a"
kind = "angle"
start = [-1.0, 1.0]
[[state]]
name = "w"
rate_of = "a"
[[control]]
name = "u"
low = -2.0
high = 2.0
[task]
reward = "cos(a) - 0.1*w^2"
"#;

fn trained(temp: &Path, task: &str) -> Run {
    fs::write(temp.join("seen.toml"), SEEN).unwrap();
    let which: &[&str] = if task == "seen" { &["--task-file", "seen.toml"] } else { &[task] };
    let args = ["--max-updates", "400", "--episodes", "2", "--quiet", "--out", task];
    let (code, _, stderr) = parts(&sindyna(temp, &[&["train"][..], which, &args].concat()));
    assert!(code <= 1, "{stderr}");
    let directory = temp.join(task);
    let problem =
        if task == "seen" { problem::of_file(&temp.join("seen.toml")) } else { problem::named(task) }.unwrap();
    Run {
        spec: problem.spec().clone(),
        sensors: problem.sensors(),
        model: Model::from_json(&fs::read_to_string(directory.join("model.json")).unwrap()).unwrap(),
        policy: SavedPolicy::from_safetensors(&fs::read(directory.join("policy.safetensors")).unwrap()).unwrap(),
        directory,
    }
}

impl Run {
    /// States within the declared bounds and beyond.
    fn states(&self) -> Vec<Vec<f64>> {
        let n = self.spec.state_dim();
        let size = |j: usize| 1.5 * self.spec.state[j].prior.bounds.1.min(3.0 * self.spec.state[j].prior.scale);
        (0..60).map(|i| (0..n).map(|j| size(j) * (1.3 * f64::from(i) + 2.1 * j as f64).sin()).collect()).collect()
    }

    fn action(&self, o: &[f64]) -> f64 {
        let mut action = [0.0];
        self.policy.act(o, Mode::Exploit, &mut Seed::new(0).numpy(), &mut action);
        action[0]
    }

    fn observed(&self, x: &[f64]) -> Vec<f64> {
        let mut o = vec![0.0; self.spec.observation_dim()];
        self.sensors.observe(x, &mut Seed::new(0).numpy(), &mut o);
        o
    }

    /// Holds what a program printed of every state, its observation and the state one step of the loop later, against ours.
    fn compare(&self, what: &str, printed: &str) {
        let found = numbers(printed);
        let width = self.spec.observation_dim() + self.spec.state_dim();
        assert_eq!(found.len(), width * self.states().len(), "{what}");
        for (x, found) in self.states().iter().zip(found.chunks(width)) {
            let o = self.observed(x);
            // CasADi's numbers are not rounded to single precision.
            let close = if self.spec.precision == Precision::F32 && what.ends_with("CasADi") { 1e-6 } else { 1e-12 };
            same(&format!("observations of {what}"), &found[..o.len()], &o, close);
            same(what, &found[o.len()..], &self.next(x, self.action(&o)), 1e-6);
        }
    }

    /// The state that the action `a` leads to, within the declared bounds.
    fn next(&self, x: &[f64], a: f64) -> Vec<f64> {
        let (mut u, mut next) = ([0.0], vec![0.0; x.len()]);
        assert!(self.spec.action_space.control_into(&[a], &mut u));
        self.model.step(x, &u, &mut Seed::new(0).numpy(), &mut next).unwrap();
        next.iter()
            .zip(&self.spec.state)
            .map(|(value, channel)| value.clamp(channel.prior.bounds.0, channel.prior.bounds.1))
            .collect()
    }
}

#[test]
fn equations_and_policy_are_one_loop_in_every_language() {
    for task in ["pendulum", "cart-pole", "seen"] {
        let temp = tempfile::tempdir().unwrap();
        let of = trained(temp.path(), task);
        let (directory, states) = (&of.directory, of.states());
        let check = |language: &str, printed: &str| of.compare(&format!("{task} in {language}"), printed);
        let rows = format!("{states:?}");
        let m = of.spec.observation_dim();

        export(directory, "c", "model.c");
        let main = format!(
            "#include <stdio.h>\n#include \"model.c\"\nint main(void)\n{{\n    static const double x[60][STATES] = {};\n    int i, j;\n    \
             for (i = 0; i < 60; i++) {{\n        double o[{m}], action[1], u[1], next[STATES];\n        sindyna_observe(x[i], o);\n        \
             sindyna_act(o, action);\n        sindyna_control(action, u);\n        sindyna_step(x[i], u, next);\n        sindyna_clip(next);\n        \
             for (j = 0; j < {m}; j++) printf(\"%.17g\\n\", o[j]);\n        \
             for (j = 0; j < STATES; j++) printf(\"%.17g\\n\", next[j]);\n    }}\n    return 0;\n}}\n",
            rows.replace('[', "{").replace(']', "}")
        );
        fs::write(directory.join("main.c"), main).unwrap();
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "main.c", "-o", "main", "-lm"];
        if run(directory, "cc", &flags).is_some() {
            check("C", &run(directory, &directory.join("main").display().to_string(), &[]).unwrap());
        }

        export(directory, "javascript", "model.mjs");
        let script = format!(
            "import {{ observe, act, control, step, clip }} from './model.mjs';\n\
             for (const x of {rows}) console.log([...observe(x), ...clip(step(x, control(act(observe(x)))))].join(' '));\n"
        );
        fs::write(directory.join("main.mjs"), script).unwrap();
        if let Some(printed) = run(directory, "node", &["main.mjs"]) {
            check("JavaScript", &printed);
        }

        export(directory, "python", "model.py");
        let script = format!(
            "from model import *\nx = np.array({rows})\nall = clip(step(x, control(act(observe(x)))))\n\
             print(np.concatenate([observe(x), all], axis=1).ravel().tolist())\n\
             one = clip(step(x[7], control(act(observe(x[7])))))\nassert np.abs(one - all[7]).max() < 1e-12\n"
        );
        check("Python", &python(directory, &script));

        export(directory, "rust", "model.rs");
        let main = format!(
            "mod model;\nuse model::{{observe, act, control, step, clip}};\nfn main() {{\n    for x in {rows} {{\n        \
             println!(\"{{:?}} {{:?}}\", observe(&x), clip(&step(&x, &control(&act(&observe(&x))))));\n    }}\n}}\n"
        );
        fs::write(directory.join("main.rs"), main).unwrap();
        let flags = ["--edition", "2024", "-A", "dead_code", "-D", "warnings", "main.rs", "-o", "rusty"];
        if run(directory, "rustc", &flags).is_some() {
            check("Rust", &run(directory, &directory.join("rusty").display().to_string(), &[]).unwrap());
        }

        policies(&of, task);
        fmu(&of, task);
    }
}

/// The policy in CasADi and ONNX Runtime.
fn policies(of: &Run, task: &str) {
    let observations: Vec<Vec<f64>> = of.states().iter().map(|x| of.observed(x)).collect();
    let expected: Vec<f64> = observations.iter().map(|o| of.action(o)).collect();
    assert!(expected.iter().any(|a| (a - expected[0]).abs() > 0.1), "{task}: always the same action");
    export(&of.directory, "casadi", "model_casadi.py");
    let script = format!("from model_casadi import policy\nfor o in {observations:?}:\n    print(float(policy(o)))\n");
    if let Some(printed) = python_with(&of.directory, "casadi", &script) {
        same(&format!("{task} in CasADi"), &numbers(&printed), &expected, 1e-6);
        let script = format!(
            "from model_casadi import *\nfor x in {:?}:\n    o = observe(x)\n    \
             print(*ca.vertcat(o, clip(F(x, control(policy(o))))).full().ravel())\n",
            of.states()
        );
        of.compare(&format!("{task} in CasADi"), &python_with(&of.directory, "casadi", &script).unwrap());
    }
    export(&of.directory, "onnx", "model.onnx");
    let script = format!(
        "import numpy as np, onnxruntime as ort\nsession = ort.InferenceSession('model.policy.onnx')\n\
         print(session.run(['action'], {{'o': np.array({observations:?})}})[0].ravel().tolist())\n"
    );
    if let Some(printed) = python_with(&of.directory, "onnxruntime", &script) {
        same(&format!("{task} in ONNX Runtime"), &numbers(&printed), &expected, 1e-6);
    }
}

/// The FMU, which keeps controls and states within their limits.
fn fmu(of: &Run, task: &str) {
    if run(&of.directory, "cc", &["--version"]).is_none() {
        return;
    }
    export(&of.directory, "fmu", "model.fmu");
    let n = of.spec.state_dim();
    let script = format!(
        "from fmpy import read_model_description, simulate_fmu\nimport numpy as np\n\
         names = [v.name for v in read_model_description('model.fmu').modelVariables]\nstates, control = names[:{n}], names[{n}]\n\
         for x in {:?}:\n    u = np.array([(0.0, 100.0)], dtype=[('time', float), (control, float)])\n    \
         result = simulate_fmu('model.fmu', start_values=dict(zip(states, x)), input=u, output=states, \
         stop_time={dt:?}, step_size={dt:?}, output_interval={dt:?})\n    print(*list(result[-1])[1:])\n",
        &of.states()[..5],
        dt = of.spec.dt
    );
    let Some(printed) = python_with(&of.directory, "fmpy", &script) else { return };
    // The largest control there is: the limit of real actions, the last of numbered ones.
    let largest = if matches!(of.spec.action_space, Space::Box { .. }) { 2.0 } else { 1.0 };
    let expected: Vec<f64> = of.states()[..5].iter().flat_map(|x| of.next(x, largest)).collect();
    same(&format!("{task} as an FMU"), &numbers(&printed), &expected, 1e-12);
}
