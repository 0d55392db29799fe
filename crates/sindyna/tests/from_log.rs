//! Log in, controller out: no simulator anywhere. And equations in a task file: a simulator whose truth nobody is told.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use common::{json, parts, sindyna};
use sindyna::problem::{OwnSystem, Problem as _, TaskBuilder, ode};
use sindyna_core::Seed;
use sindyna_dyna::evaluate;
use sindyna_rl::SavedPolicy;

fn example(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/spring").join(name);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A directory with the files of the example.
fn workplace() -> tempfile::TempDir {
    let temp = tempfile::tempdir().unwrap();
    for name in ["spring.csv", "spring.toml", "ground_truth.toml"] {
        fs::write(temp.path().join(name), example(name)).unwrap();
    }
    temp
}

fn succeeds(directory: &Path, args: &[&str]) -> String {
    let (code, stdout, stderr) = parts(&sindyna(directory, args));
    assert_eq!(code, 0, "{args:?}: {stdout}{stderr}");
    stdout
}

/// Mean return of the policy in `run` on the system that the log is of, which no run ever saw.
fn on_the_system(run: &Path) -> f64 {
    let task = TaskBuilder::new("spring", 0.05)
        .state("x", "m", (-0.5, 0.5))
        .rate("v", "m/s", "x", (0.0, 0.0))
        .input("F", "N", -1.0, 1.0)
        .reward(|_, _, next| -((next[0] - 0.3).powi(2) + 0.02 * next[1].powi(2)))
        .max_steps(100)
        .build()
        .unwrap();
    let rates = |x: &[f64], u: &[f64], rate: &mut [f64]| rate.copy_from_slice(&[x[1], u[0] - 2.0 * x[0] - 0.3 * x[1]]);
    let system = OwnSystem::simulated(task, ode(0.05, rates)).unwrap();
    let policy = SavedPolicy::from_safetensors(&fs::read(run.join("policy.safetensors")).unwrap()).unwrap();
    let mut systems: Vec<_> = (0..100).map(|_| system.environment().unwrap()).collect();
    let returns = evaluate(&mut systems, &policy, 100, Seed::new(7), "a system never seen").unwrap();
    returns.iter().sum::<f64>() / returns.len() as f64
}

/// Every file of `run` but those with times.
fn files(run: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = fs::read_dir(run).unwrap().map(|entry| entry.unwrap().path());
    let kept =
        entries.filter(|path| !["timing.json", "report.html"].contains(&path.file_name().unwrap().to_str().unwrap()));
    kept.map(|path| (path.file_name().unwrap().into(), fs::read(&path).unwrap())).collect()
}

#[test]
fn a_controller_from_a_log_does_on_the_system_what_is_predicted() {
    let temp = workplace();
    let args = ["train", "--task-file", "spring.toml", "--data", "spring.csv", "--quiet", "--isa", "portable"];
    let text = succeeds(temp.path(), &[&args[..], &["--out", "run"]].concat());
    assert!(text.contains("v\u{307} = ") && text.contains("not evaluated: there is no system"), "{text}");
    assert!(text.contains("one action takes") && text.contains("  x "), "{text}");
    let run = temp.path().join("run");
    let summary = json(&run.join("summary.json"));
    assert_eq!((&summary["real_steps"], &summary["evaluation"]), (&399.into(), &serde_json::Value::Null));
    let terms = summary["identification"]["coefficients"][1].as_array().unwrap();
    for (term, truth) in [("x", -2.0), ("v", -0.3), ("F", 1.0)] {
        let found = terms.iter().find(|t| t["term"] == term).unwrap();
        let (value, error) = (found["coefficient"].as_f64().unwrap(), found["standard_error"].as_f64().unwrap());
        assert!((value - truth).abs() < 4.0 * error && error < 0.01, "{found}");
    }
    let prediction = &summary["training"]["prediction"];
    let (low, high) = (prediction["low"].as_f64().unwrap(), prediction["high"].as_f64().unwrap());
    let real = on_the_system(&run);
    // A hundred start states drawn otherwise are no part of the interval's claim: half of it on either side.
    let slack = 0.5 * (high - low);
    assert!(real > low - slack && real < high + slack && real > -3.5, "{real} is not in {low} to {high}");
    let coverage = &summary["training"]["coverage"];
    assert!(coverage["share_outside"].as_f64().unwrap() < 0.05, "{coverage}");
    assert_eq!((&coverage["states"][0]["channel"], &coverage["controls"][0]["channel"]), (&"x".into(), &"F".into()));
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(page.contains("the data are a log") && page.contains("beyond the data"));

    // The originals are not needed any more, and the same is done again.
    fs::remove_file(temp.path().join("spring.csv")).unwrap();
    let whole = files(&run);
    for name in ["summary.json", "policy.safetensors", "model.json"] {
        fs::remove_file(run.join(name)).unwrap();
    }
    succeeds(temp.path(), &["train", "--resume", "run", "--quiet"]);
    assert_eq!(files(&run), whole);
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["evaluate", "run"]));
    assert!(code == 2 && stderr.contains("there is no system to evaluate its policy on"), "{stderr}");

    // An earlier version kept no equations with the log: they are found in it again.
    let config = fs::read_to_string(run.join("config.toml")).unwrap();
    assert!(config.contains("models = \"posterior.bin\"\n"), "{config}");
    fs::write(run.join("config.toml"), config.replace("models = \"posterior.bin\"\n", "")).unwrap();
    fs::remove_file(run.join("posterior.bin")).unwrap();
    let again = ["train", "--config", "run/config.toml", "--max-updates", "200", "--quiet", "--out", "again"];
    // So few updates leave no policy, which exit code 1 says.
    assert_eq!(parts(&sindyna(temp.path(), &again)).0, 1);
    assert_eq!(files(&temp.path().join("again"))[Path::new("model.json")], whole[Path::new("model.json")]);
}

/// The log of the spring with other rows and columns: `keep` says which rows, `change` makes a row (t, x, v, F) another.
fn log_of(
    keep: impl Fn(usize, &[Vec<f64>]) -> bool,
    change: impl Fn(usize, &[Vec<f64>]) -> Vec<f64>,
    header: &str,
) -> String {
    let text = example("spring.csv");
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let kept = (0..rows.len()).filter(|i| keep(*i, &rows)).map(|i| change(i, &rows));
    let lines = kept.map(|row| row.iter().map(ToString::to_string).collect::<Vec<_>>().join(","));
    std::iter::once(header.to_owned()).chain(lines).map(|line| line + "\n").collect()
}

#[test]
fn a_log_is_identified_for_training_as_it_is_by_itself() {
    let temp = workplace();
    let write = |name: &str, text: String| fs::write(temp.path().join(name), text).unwrap();
    let (all, whole) = (|_: usize, _: &[Vec<f64>]| true, "t,x,v,F");
    // Inputs that act two rows late, samples at uneven times, positions alone.
    let late = |i: usize, rows: &[Vec<f64>]| [&rows[i][..3], &[rows[(i + 2).min(rows.len() - 1)][3]]].concat();
    write("late.csv", log_of(all, late, whole));
    // Where an input changes, its row has to be there.
    let kept = |i: usize, rows: &[Vec<f64>]| i % 7 != 3 && i % 11 != 5 || i == 0 || rows[i][3] != rows[i - 1][3];
    write("uneven.csv", log_of(kept, |i, rows| rows[i].clone(), whole));
    write("positions.csv", log_of(all, |i, rows| vec![rows[i][0], rows[i][1], rows[i][3]], "t,x,F"));
    let quick = ["--quiet", "--isa", "portable", "--max-updates", "2000"];
    let train = |log: &str, out: &str, more: &[&str]| {
        let args = ["train", "--task-file", "spring.toml", "--data", log, "--out", out];
        parts(&sindyna(temp.path(), &[&args[..], more].concat()))
    };
    let (code, stdout, stderr) = train("late.csv", "late", &quick);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert_eq!(json(&temp.path().join("late").join("summary.json"))["input_delay_seconds"], 0.1, "{stdout}{stderr}");
    let (code, stdout, stderr) = train("spring.csv", "prompt", &[&quick[..], &["--delay", "0"]].concat());
    assert_eq!(code, 0, "{stdout}{stderr}");

    for (log, columns) in [("uneven.csv", "x,v"), ("positions.csv", "x")] {
        let (run, model) = (format!("run-{log}"), format!("model-{log}"));
        let (code, stdout, stderr) = train(log, &run, &quick);
        assert_eq!(code, 0, "{stdout}{stderr}");
        let mut args = vec!["identify", log, "--states", columns, "--inputs", "F", "--quiet", "--out", &model];
        args.extend(if columns == "x" { &["--unmeasured", "v=x"][..] } else { &["--rates", "v=x"] });
        succeeds(temp.path(), &args);
        let read = |directory: &str, name: &str| fs::read_to_string(temp.path().join(directory).join(name)).unwrap();
        assert_eq!(read(&run, "model.json"), read(&model, "model.json"), "{log}");
        assert_eq!(read(&run, "data.csv"), read(&model, "data.csv"), "{log}");
        let terms = json(&temp.path().join(&run).join("summary.json"))["identification"]["coefficients"][1].clone();
        for (term, truth) in [("x", -2.0), ("v", -0.3), ("F", 1.0)] {
            let found = terms.as_array().unwrap().iter().find(|t| t["term"] == term).unwrap();
            let (value, error) = (found["coefficient"].as_f64().unwrap(), found["standard_error"].as_f64().unwrap());
            assert!((value - truth).abs() < 4.0 * error && error < 0.05, "{log}: {found}");
        }
        // The record alone is enough.
        fs::remove_file(temp.path().join(&run).join("summary.json")).unwrap();
        succeeds(temp.path(), &["train", "--resume", &run, "--quiet"]);
    }
    let text = example("spring.toml");
    let tables: Vec<&str> = text.split("[[state]]").collect();
    let control = tables[2].split_once("[[control]]").unwrap().1;
    let lone = format!("{}[[state]]{}[[control]]{control}", tables[0], tables[1]);
    write("lone.toml", lone.replace("next_v", "next_x"));
    let args = ["train", "--task-file", "lone.toml", "--data", "positions.csv", "--quiet", "--out", "lone"];
    let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
    assert!(code == 2 && stderr.contains("declare it as the last [[state]], with `rate_of`"), "{stderr}");
    for (args, says) in [
        (&["train", "pendulum", "--delay", "0"][..], "require --data"),
        (
            &["train", "--task-file", "spring.toml", "--model", "model-uneven.csv", "--library", "paper"],
            "which is identified already",
        ),
        (&["train", "--config", "run-uneven.csv/config.toml", "--library", "paper"], "were identified before"),
    ] {
        let (code, _, stderr) = parts(&sindyna(temp.path(), args));
        assert!(code == 2 && stderr.contains(says) && stderr.contains("hint: "), "{args:?}: {stderr}");
    }
}

#[test]
fn a_model_identified_before_is_trained_in() {
    let temp = workplace();
    let columns = ["identify", "spring.csv", "--states", "x,v", "--inputs", "F", "--quiet", "--out", "model"];
    succeeds(temp.path(), &columns);
    fs::remove_file(temp.path().join("spring.csv")).unwrap();
    let quick = ["--max-updates", "500", "--quiet", "--isa", "portable", "--out", "run"];
    let text =
        succeeds(temp.path(), &[&["train", "--task-file", "spring.toml", "--model", "model"][..], &quick].concat());
    assert!(text.contains("predicted mean return on the system"), "{text}");
    let run = temp.path().join("run");
    let model = |directory: &str| fs::read_to_string(temp.path().join(directory).join("model.json")).unwrap();
    assert_eq!(model("run"), model("model"));
    assert_eq!(json(&run.join("summary.json"))["training"]["updates"], 500);

    for (from, to, says) in [
        ("name = \"v\"", "name = \"w\"", "no column named `w`"),
        (
            "max_steps = 100",
            "max_steps = 100\ndt = 0.12",
            "its `dt` is 0.12 s, which is no multiple of the sampling interval of the log, 0.05 s",
        ),
        ("max_steps = 100", "max_steps = 100\ndt = 1e6", "no trajectory of the log is as long"),
    ] {
        fs::write(temp.path().join("other.toml"), example("spring.toml").replace(from, to).replace("next_v", "next_x"))
            .unwrap();
        let args = ["train", "--task-file", "other.toml", "--model", "model", "--out", "other"];
        let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
        assert!(code == 2 && stderr.contains(says) && !temp.path().join("other").exists(), "{stderr}");
    }
    // Controls of the log may be larger than those of the task.
    fs::write(temp.path().join("weak.toml"), example("spring.toml").replace("low = -1.0", "low = -0.1")).unwrap();
    let weak = ["train", "--task-file", "weak.toml", "--model", "model", "--controller", "lqr", "--out", "weak"];
    assert!(succeeds(temp.path(), &weak).contains("predicted mean return on the system"));
    let path = temp.path().join("model/posterior.bin");
    let mut bytes = fs::read(&path).unwrap();
    for (damage, says) in [(40, "is damaged"), (3, "was not written by `sindyna identify`")] {
        let at = if damage == 40 { bytes.len() - 40 } else { damage };
        bytes[at] ^= 1;
        fs::write(&path, &bytes).unwrap();
        let args = ["train", "--task-file", "spring.toml", "--model", "model", "--out", "other"];
        let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
        assert!(code == 2 && stderr.contains(says), "{stderr}");
    }
    for (args, says) in [
        (&["--task-file", "spring.toml"][..], "neither a `model` nor [equations]"),
        (&["--task-file", "spring.toml", "--model", "run"], "not that of an identification"),
        (&["--task-file", "spring.toml", "--model", "nowhere"], "cannot read nowhere/config.toml"),
        (&["--task-file", "ground_truth.toml", "--model", "model"], "its task file has a simulator"),
        (&["--task-file", "spring.toml", "--data", "log.csv", "--real-steps", "20"], "do not apply to a log"),
        (&["pendulum", "--data", "log.csv"], "--task-file"),
    ] {
        let (code, _, stderr) = parts(&sindyna(temp.path(), &[&["train"], args].concat()));
        assert!(code == 2 && stderr.contains(says) && stderr.contains("hint: "), "{args:?}: {stderr}");
    }
}

#[test]
fn a_policy_that_acts_every_other_row_is_judged_on_equations_of_another_log() {
    let temp = workplace();
    let identified = |log: &str, out: &str| {
        let columns = ["--states", "x,v", "--inputs", "F", "--quiet", "--out", out];
        succeeds(temp.path(), &[&["identify", log][..], &columns].concat());
    };
    identified("spring.csv", "model");
    // The other log is of the same system: the second half of the same recording.
    let text = example("spring.csv");
    let rows: Vec<&str> = text.lines().collect();
    let half = [&rows[..1], &rows[rows.len() / 2..]].concat().join("\n");
    fs::write(temp.path().join("half.csv"), half).unwrap();
    identified("half.csv", "twin");
    let slow = example("spring.toml").replace("max_steps = 100", "max_steps = 50\ndt = 0.1");
    fs::write(temp.path().join("slow.toml"), slow).unwrap();
    let train = ["train", "--task-file", "slow.toml", "--model", "model", "--controller", "ilqr", "--out", "run"];
    succeeds(temp.path(), &train);
    let run = temp.path().join("run");
    let model = json(&run.join("model.json"));
    assert_eq!(model["dt"], 0.1, "{model}");
    assert!(succeeds(temp.path(), &["evaluate", "run", "--model", "twin"]).contains("in the equations of twin"));
    let answer = succeeds(temp.path(), &["evaluate", "run", "--model", "twin", "--json"]);
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    let earned = answer["result"]["evaluation"]["mean_return"].as_f64().unwrap();
    assert_eq!(answer["result"]["model"], "twin");
    // Half of the log tells nearly the same equations.
    let same = succeeds(temp.path(), &["evaluate", "run", "--model", "model", "--json"]);
    let same: serde_json::Value = serde_json::from_str(&same).unwrap();
    let of_model = same["result"]["evaluation"]["mean_return"].as_f64().unwrap();
    assert!((earned - of_model).abs() < 0.05 * of_model.abs(), "{earned} {of_model}");
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["evaluate", "run"]));
    assert!(code == 2 && stderr.contains("--model DIR"), "{stderr}");
}

#[test]
fn equations_in_a_task_file_are_a_simulator() {
    let temp = workplace();
    let args = ["train", "--task-file", "ground_truth.toml", "--quiet", "--out", "run", "--isa", "portable"];
    let text = succeeds(temp.path(), &args);
    assert!(text.contains("dv/dt = (F - k*x - c*v)/m") && text.contains(": solved (≥ −4)"), "{text}");
    let summary = json(&temp.path().join("run/summary.json"));
    assert_eq!((&summary["real_steps"], &summary["task"]), (&10.into(), &"spring-equations".into()));
    for (term, truth) in [("x", -2.0), ("v", -0.3), ("F", 1.0)] {
        let terms = summary["identification"]["coefficients"][1].as_array().unwrap();
        let found = terms.iter().find(|t| t["term"] == term).unwrap()["coefficient"].as_f64().unwrap();
        assert!((found - truth).abs() < 1e-6, "{term}: {found}");
    }
    // Its own record is enough.
    fs::rename(temp.path().join("ground_truth.toml"), temp.path().join("moved.toml")).unwrap();
    let again = succeeds(temp.path(), &["evaluate", "run"]);
    assert!(text.contains(again.trim_end()), "{again}");

    let compare =
        ["compare", "--tasks", "moved.toml", "--methods", "random,lqr", "--seeds", "2", "--out", "c", "--quiet"];
    let table = succeeds(temp.path(), &compare);
    assert!(table.contains("spring-equations   random") && !table.contains("lqr"), "{table}");
    let summary = fs::read(temp.path().join("c/summary.json")).unwrap();
    succeeds(temp.path(), &["report", "c"]);
    assert_eq!(fs::read(temp.path().join("c/summary.json")).unwrap(), summary);
    let changed = example("ground_truth.toml").replace("k = 2.0", "k = 3.0");
    fs::write(temp.path().join("moved.toml"), changed).unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &compare));
    assert!(code == 2 && stderr.contains("is another task of that name"), "{stderr}");

    for (from, to, says) in [
        ("v = \"(F", "w = \"(F", "no state named `w`"),
        ("(F - k*x", "(F - q*x", "no variable named `q`"),
        ("k = 2.0", "x = 2.0", "the name `x` is used twice"),
        ("dt = 0.05", "", "[equations] need `dt`"),
        ("dt = 0.05", "dt = -1.0", "above 0"),
        ("dt = 0.05", "dt = 0.05\nframe_skip = 2", "`frame_skip` requires a `model`"),
        ("rate_of = \"x\"", "", "[equations] lack one for `x`"),
        ("spring-equations", "pendulum", "like a built-in task"),
    ] {
        fs::write(temp.path().join("other.toml"), example("ground_truth.toml").replacen(from, to, 1)).unwrap();
        let args = ["compare", "--tasks", "other.toml", "--methods", "random", "--seeds", "1", "--out", "other"];
        let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
        assert!(code == 2 && stderr.contains(says), "{from} → {to}: {stderr}");
    }
}

#[test]
fn a_log_in_hours_is_trained_on() {
    use std::fmt::Write as _;
    let temp = tempfile::tempdir().unwrap();
    // dT/dt = −0.4 T + 2 P per hour, sampled every quarter of an hour.
    let (mut log, mut t) = (String::from("time [h],T [degC],P [kW]\n"), 3.0_f64);
    for row in 0..120_u32 {
        let p = f64::from((row / 4) * 37 % 11) / 10.0;
        writeln!(log, "{},{t},{p}", 0.25 * f64::from(row)).unwrap();
        let decay = (-0.1_f64).exp();
        t = t * decay + 5.0 * p * (1.0 - decay);
    }
    fs::write(temp.path().join("room.csv"), log).unwrap();
    let task = "name = \"room\"\nmax_steps = 20\n[[state]]\nname = \"T\"\nunit = \"degC\"\nstart = [1.0, 4.0]\n\
                [[control]]\nname = \"P\"\nunit = \"kW\"\nlow = 0.0\nhigh = 1.0\n[task]\nreward = \"-(next_T - 3)^2\"\n";
    fs::write(temp.path().join("room.toml"), task).unwrap();
    let args = ["train", "--task-file", "room.toml", "--data", "room.csv", "--controller", "lqr", "--quiet"];
    succeeds(temp.path(), &[&args[..], &["--out", "run"]].concat());
    let summary = json(&temp.path().join("run/summary.json"));
    let terms = summary["identification"]["coefficients"][0].as_array().unwrap();
    for (term, per_hour) in [("T", -0.4), ("P", 2.0)] {
        let found = terms.iter().find(|t| t["term"] == term).unwrap()["coefficient"].as_f64().unwrap();
        assert!((3600.0 * found / per_hour - 1.0).abs() < 1e-6, "{term}: {found}");
    }
}

#[test]
fn a_task_in_degrees_is_refused_for_a_log_that_is_read_in_radians() {
    use std::fmt::Write as _;
    let temp = tempfile::tempdir().unwrap();
    let mut log = String::from("t,heading [rad],steer [deg]\n");
    for row in 0..40_u32 {
        writeln!(log, "{},{},{}", 0.1 * f64::from(row), (0.2 * f64::from(row)).sin(), row % 7).unwrap();
    }
    fs::write(temp.path().join("bike.csv"), log).unwrap();
    let task = "name = \"bike\"\nmax_steps = 20\n[[state]]\nname = \"heading\"\nunit = \"rad\"\nstart = [-0.5, 0.5]\n\
                [[control]]\nname = \"steer\"\nunit = \"deg\"\nlow = -25.0\nhigh = 25.0\n[task]\nreward = \"-heading^2\"\n";
    fs::write(temp.path().join("bike.toml"), task).unwrap();
    let args = ["train", "--task-file", "bike.toml", "--data", "bike.csv", "--quiet", "--out", "run"];
    let (code, _, said) = parts(&sindyna(temp.path(), &args));
    assert!(code == 2 && said.contains("the task declares steer in deg"), "{code}: {said}");
    assert!(!temp.path().join("run").exists());
}
