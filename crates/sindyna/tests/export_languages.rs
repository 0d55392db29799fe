//! Programs that `sindyna export` writes, executed: equal to the model and to the policy in every language there is a tool for.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fmt::Write as _;
use std::fs;

use common::programs::{export, model, models, numbers, points, run, same};
use common::{parts, python, sindyna};
use sindyna_core::{Dynamics as _, Mode, Policy as _, Seed};
use sindyna_rl::SavedPolicy;
use sindyna_sindy::Model;

#[test]
fn equations_are_the_same_in_every_language() {
    let list = |of: &dyn Fn(&[f64; 3]) -> String| points().iter().map(of).collect::<Vec<_>>().join(", ");
    for (name, text) in models() {
        let temp = tempfile::tempdir().unwrap();
        let directory = temp.path();
        fs::write(directory.join("model.json"), &text).unwrap();
        let model = Model::from_json(&text).unwrap();
        let expected: Vec<f64> = points()
            .iter()
            .flat_map(|z| {
                let mut next = [0.0; 2];
                model.step(&z[..2], &z[2..], &mut Seed::new(0).numpy(), &mut next).unwrap();
                next
            })
            .collect();

        export(directory, "c", "model.c");
        let rows = list(&|z| format!("{{{:?}, {:?}, {:?}}}", z[0], z[1], z[2]));
        let main = format!(
            "#include <stdio.h>\n#include \"model.c\"\nint main(void)\n{{\n    const double z[40][3] = {{{rows}}};\n    int i;\n    \
             for (i = 0; i < 40; i++) {{\n        double next[2];\n        sindyna_step(z[i], z[i] + 2, next);\n        \
             printf(\"%.17g %.17g\\n\", next[0], next[1]);\n    }}\n    return 0;\n}}\n"
        );
        fs::write(directory.join("main.c"), main).unwrap();
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "main.c", "-o", "main", "-lm"];
        if run(directory, "cc", &flags).is_some() {
            let program = directory.join("main").display().to_string();
            same(&format!("{name} in C"), &numbers(&run(directory, &program, &[]).unwrap()), &expected, 1e-12);
        }

        export(directory, "javascript", "model.mjs");
        let rows = list(&|z| format!("[{:?}, {:?}, {:?}]", z[0], z[1], z[2]));
        let script = format!(
            "import {{ step }} from './model.mjs';\nfor (const z of [{rows}]) console.log(step(z.slice(0, 2), z.slice(2)).join(' '));\n"
        );
        fs::write(directory.join("main.mjs"), script).unwrap();
        if let Some(printed) = run(directory, "node", &["main.mjs"]) {
            same(&format!("{name} in JavaScript"), &numbers(&printed), &expected, 1e-12);
        }

        export(directory, "python", "model.py");
        let script = format!(
            "import model, numpy as np\nz = np.array([{rows}])\nprint(model.step(z[:, :2], z[:, 2:]).tolist())\n"
        );
        same(&format!("{name} in Python"), &numbers(&python(directory, &script)), &expected, 1e-12);

        export(directory, "rust", "model.rs");
        let main = format!(
            "mod model;\nfn main() {{\n    for z in [{rows}] {{\n        let [a, b] = model::step(&[z[0], z[1]], &[z[2]]);\n        \
             println!(\"{{a:?}} {{b:?}}\");\n    }}\n}}\n"
        );
        fs::write(directory.join("main.rs"), main).unwrap();
        let flags = ["--edition", "2024", "-A", "dead_code", "-D", "warnings", "main.rs", "-o", "rusty"];
        if run(directory, "rustc", &flags).is_some() {
            let program = directory.join("rusty").display().to_string();
            same(&format!("{name} in Rust"), &numbers(&run(directory, &program, &[]).unwrap()), &expected, 1e-12);
        }

        export(directory, "latex", "model.tex");
        let formulas = fs::read_to_string(directory.join("model.tex")).unwrap();
        let code: String = formulas.lines().filter(|line| !line.starts_with('%')).collect();
        assert_eq!(code.matches('{').count(), code.matches('}').count(), "{formulas}");
        assert_eq!(code.matches("\\left").count(), code.matches("\\right").count(), "{formulas}");
        assert_eq!(code.matches("&=").count(), 2, "{formulas}");
        if name == "implicit" {
            assert!(
                code.contains("\\dot{x} &= v + 0.2 \\, \\sin\\left(x\\right) \\, \\left(v\\right)^{2} \\, \\dot{v}"),
                "{code}"
            );
        }
    }
}

#[test]
fn policies_are_the_same_in_every_language() {
    for task in ["pendulum", "cart-pole"] {
        let temp = tempfile::tempdir().unwrap();
        let args = ["train", task, "--max-updates", "400", "--episodes", "2", "--quiet", "--out", "run"];
        let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
        assert!(code <= 1, "{stderr}");
        let directory = temp.path().join("run");
        let policy = SavedPolicy::from_safetensors(&fs::read(directory.join("policy.safetensors")).unwrap()).unwrap();
        let m = policy.observation_dim();
        let observations: Vec<Vec<f64>> =
            (0..60).map(|i| (0..m).map(|j| 1.5 * (1.3 * f64::from(i) + 2.1 * j as f64).sin()).collect()).collect();
        let expected: Vec<f64> = observations
            .iter()
            .map(|o| {
                let mut action = [0.0];
                policy.act(o, Mode::Exploit, &mut Seed::new(0).numpy(), &mut action);
                action[0]
            })
            .collect();
        assert!(expected.iter().any(|a| (a - expected[0]).abs() > 0.1), "{task}: always the same action");
        // Of a range of −2 to 2, of numbers 0 and 1.
        let tolerance = 1e-6;

        let rows = observations.iter().fold(String::new(), |mut rows, o| {
            write!(rows, "{o:?}, ").unwrap();
            rows
        });
        export(&directory, "c", "model.c");
        let c_rows = rows.replace('[', "{").replace(']', "}");
        let main = format!(
            "#include <stdio.h>\n#include \"model.c\"\nint main(void)\n{{\n    const double o[60][{m}] = {{{c_rows}}};\n    int i;\n    \
             for (i = 0; i < 60; i++) {{\n        double action[1];\n        sindyna_act(o[i], action);\n        printf(\"%.17g\\n\", action[0]);\n    \
             }}\n    return 0;\n}}\n"
        );
        fs::write(directory.join("main.c"), main).unwrap();
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "main.c", "-o", "main", "-lm"];
        if run(&directory, "cc", &flags).is_some() {
            let program = directory.join("main").display().to_string();
            same(&format!("{task} in C"), &numbers(&run(&directory, &program, &[]).unwrap()), &expected, tolerance);
        }
        export(&directory, "javascript", "model.mjs");
        let script =
            format!("import {{ act }} from './model.mjs';\nfor (const o of [{rows}]) console.log(act(o)[0]);\n");
        fs::write(directory.join("main.mjs"), script).unwrap();
        if let Some(printed) = run(&directory, "node", &["main.mjs"]) {
            same(&format!("{task} in JavaScript"), &numbers(&printed), &expected, tolerance);
        }
        export(&directory, "python", "model.py");
        let script = format!(
            "import model, numpy as np\no = np.array([{rows}])\nprint(model.act(o)[:, 0].tolist())\nassert model.act(o[3]).shape == (1,)\n"
        );
        same(&format!("{task} in Python"), &numbers(&python(&directory, &script)), &expected, tolerance);
        export(&directory, "rust", "model.rs");
        let main = format!(
            "mod model;\nfn main() {{\n    for o in [{rows}] {{\n        println!(\"{{:?}}\", model::act(&o)[0]);\n    }}\n}}\n"
        );
        fs::write(directory.join("main.rs"), main).unwrap();
        let flags = ["--edition", "2024", "-A", "dead_code", "-D", "warnings", "main.rs", "-o", "rusty"];
        if run(&directory, "rustc", &flags).is_some() {
            let program = directory.join("rusty").display().to_string();
            same(&format!("{task} in Rust"), &numbers(&run(&directory, &program, &[]).unwrap()), &expected, tolerance);
        }
        export(&directory, "latex", "model.tex");
        assert!(fs::read_to_string(directory.join("model.tex")).unwrap().contains("\\pi(o) = "));
    }
}

/// The part of a page that holds equations and policy.
fn model_of(page: &str) -> &str {
    page.split_once("<script id=\"model\">").unwrap().1.split_once("</script>").unwrap().0
}

#[test]
fn the_page_moves_as_equations_and_policy_do() {
    let temp = tempfile::tempdir().unwrap();
    let args = ["train", "pendulum", "--episodes", "2", "--quiet", "--out", "run"];
    let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
    assert!(code <= 1, "{stderr}");
    let directory = temp.path().join("run");
    export(&directory, "html", "model.html");
    let page = fs::read_to_string(directory.join("model.html")).unwrap();
    assert!(page.len() < 1 << 20 && !page.contains("{{") && !page.contains("http"), "{} bytes", page.len());
    let script = format!(
        "{}\nlet x = [3.0, 0.5];\nfor (let t = 0; t < 1000; t++) {{ x = next(x, [2 * Math.sin(0.37 * t)]); console.log(x.join(' ')); }}\n\
         x = [3.0, 0.5];\nfor (let t = 0; t < 200; t++) {{ x = next(x, chosen(x)); console.log(x.join(' ')); }}\n",
        model_of(&page)
    );
    fs::write(directory.join("main.js"), script).unwrap();
    let Some(printed) = run(&directory, "node", &["main.js"]) else { return };
    let printed = numbers(&printed);

    let model = Model::from_json(&fs::read_to_string(directory.join("model.json")).unwrap()).unwrap();
    let policy = SavedPolicy::from_safetensors(&fs::read(directory.join("policy.safetensors")).unwrap()).unwrap();
    let mut rng = Seed::new(0).numpy();
    let mut moved = |steps: usize, control: &mut dyn FnMut(usize, &[f64]) -> f64| -> Vec<f64> {
        let (mut x, mut all) = ([3.0, 0.5], Vec::new());
        for t in 0..steps {
            let (u, mut next) = ([control(t, &x)], [0.0; 2]);
            model.step(&x, &u, &mut rng, &mut next).unwrap();
            x = [next[0], next[1].clamp(-8.0, 8.0)];
            all.extend(x);
        }
        all
    };
    let open = moved(1000, &mut |t, _| 2.0 * (0.37 * t as f64).sin());
    same("equations", &printed[..2000], &open, 1e-9);
    let closed = moved(200, &mut |_, x| {
        let mut action = [0.0];
        policy.act(&[x[0].cos(), x[0].sin(), x[1]], Mode::Exploit, &mut Seed::new(0).numpy(), &mut action);
        action[0]
    });
    same("with the policy", &printed[2000..], &closed, 1e-3);
}

#[test]
fn names_do_not_end_the_script_of_a_page() {
    let temp = tempfile::tempdir().unwrap();
    let name = r#"</script><script>alert(1)</script><!--"#;
    let text = model(
        r#""form": "continuous", "scheme": "euler""#,
        r#"["1"]"#,
        r#"[[{"term": 0, "coefficient": 1.5}], []]"#,
        "[false, false]",
    );
    fs::write(temp.path().join("model.json"), text.replace(r#""x", "v""#, &format!(r#""{name}", "v""#))).unwrap();
    fs::write(temp.path().join("data.csv"), format!("trajectory,t,{name},v,u\n0,0,1.0,2.0,0\n")).unwrap();
    export(temp.path(), "html", "model.html");
    let page = fs::read_to_string(temp.path().join("model.html")).unwrap();
    assert_eq!(
        (page.matches("<script").count(), page.matches("</script").count(), page.matches("<!--").count()),
        (2, 2, 1),
        "{page}"
    );
    assert!(page.contains("\"starts\":[[1.0,2.0]]"));
    fs::remove_file(temp.path().join("data.csv")).unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["export", ".", "--to", "html"]));
    assert!(code == 2 && stderr.contains("the start state is not known"), "{stderr}");
}
