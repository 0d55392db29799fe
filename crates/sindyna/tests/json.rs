//! What `--json` prints: one object that holds what docs/json.md says, and nothing else on stdout.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use common::{COLUMNS, example, parts, sindyna};
use serde_json::{Value, json};
use sindyna_record::identification::Account;
use sindyna_record::run::{Evaluation, Summary, Timing};

/// The object that `sindyna ARGS --json` prints in `directory`, whose exit code must be the one it tells.
fn object(directory: &Path, args: &[&str]) -> Value {
    let (code, stdout, stderr) = parts(&sindyna(directory, &[args, &["--json"]].concat()));
    let object: Value = serde_json::from_str(&stdout).unwrap_or_else(|e| panic!("{args:?}: {e}: {stdout}{stderr}"));
    assert_eq!((&object["format"], &object["exit_code"]), (&1.into(), &code.into()), "{stderr}");
    assert!(!stderr.contains("error:"), "errors are in the object: {stderr}");
    object
}

const TRAIN: [&str; 6] = ["train", "pendulum", "--max-updates", "400", "--episodes", "3"];

#[test]
fn a_run_is_what_its_files_say() {
    let temp = tempfile::tempdir().unwrap();
    let trained = object(temp.path(), &[&TRAIN[..], &["--out", "run", "--isa", "portable"]].concat());
    assert_eq!((&trained["command"], &trained["exit_code"]), (&"train".into(), &1.into()));
    let result = &trained["result"];
    assert_eq!((&result["record"], &result["report"]), (&"run".into(), &"run/report.html".into()));
    let summary: Summary = serde_json::from_value(result["summary"].clone()).unwrap();
    let file = fs::read_to_string(temp.path().join("run/summary.json")).unwrap();
    assert_eq!(summary, Summary::from_json(&file).unwrap());
    let timing: Timing = serde_json::from_value(result["timing"].clone()).unwrap();
    assert!(timing.wall_seconds > 0.0);

    let again = object(temp.path(), &["evaluate", "run"]);
    let evaluation: Evaluation = serde_json::from_value(again["result"]["evaluation"].clone()).unwrap();
    assert_eq!(Some(evaluation), summary.evaluation);
    assert_eq!((&again["result"]["task"], &again["result"]["threshold"]), (&"pendulum".into(), &json!(-180.0)));

    let shown = object(temp.path(), &["show", "run"]);
    assert_eq!((&shown["result"]["kind"], &shown["exit_code"]), (&"run".into(), &0.into()));
    assert_eq!(shown["result"]["summary"], result["summary"]);
    let text = parts(&sindyna(temp.path(), &["show", "run"])).1;
    assert!(text.contains("ω\u{307} = 15 sin θ + 3 u") && text.contains("real steps: 10 in 1 episode"), "{text}");
    assert!(text.contains("record: run\nreport: run/report.html\n"), "{text}");

    let finished = object(temp.path(), &["train", "--resume", "run"]);
    assert_eq!((&finished["result"]["timing"], &finished["exit_code"]), (&Value::Null, &1.into()));
    let report = object(temp.path(), &["report", "run"]);
    assert_eq!(report["result"], json!({"record": "run", "report": "run/report.html"}));
}

#[test]
fn an_identification_is_what_its_files_say() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), example()).unwrap();
    let args = [&["identify", "log.csv"], &COLUMNS[..], &["--angles", "th", "--out", "model"]].concat();
    let result = object(temp.path(), &args)["result"].clone();
    assert_eq!((&result["rows"], &result["trajectories"]), (&101.into(), &1.into()));
    assert_eq!(result["equations"], json!(["dth/dt = w", "w\u{307} = 15 sin th + 3 u"]));
    assert!(result["notes"][0].as_str().unwrap().contains("w is used as the rate of th"));
    let account: Account = serde_json::from_value(result["identification"].clone()).unwrap();
    assert_eq!((account.rows, account.explained), (100, Some(true)));

    let shown = object(temp.path(), &["show", "model"])["result"].clone();
    assert_eq!(shown["kind"], "identification");
    assert_eq!(serde_json::from_value::<Account>(shown["identification"].clone()).unwrap().rows, 100);
    let shown = object(temp.path(), &["show", "model/model.json"])["result"].clone();
    assert_eq!((&shown["kind"], &shown["equations"]), (&"model".into(), &result["equations"]));

    let exported = object(temp.path(), &["export", "model", "--to", "python", "--out", "-"])["result"].clone();
    let program = parts(&sindyna(temp.path(), &["export", "model", "--to", "python", "--out", "-"])).1;
    assert_eq!((&exported["written"], exported["program"].as_str()), (&Value::Null, Some(program.as_str())));
}

#[test]
fn a_comparison_is_what_its_files_say() {
    let temp = tempfile::tempdir().unwrap();
    let args = ["compare", "--tasks", "cart-pole", "--methods", "expert,random", "--seeds", "2-3", "--out", "c"];
    let result = object(temp.path(), &args)["result"].clone();
    assert_eq!((&result["runs"], &result["done_before"], &result["missing"]), (&4.into(), &0.into(), &Value::Null));
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(temp.path().join("c/summary.json")).unwrap()).unwrap();
    assert_eq!((&result["groups"], result["groups"].as_array().unwrap().len()), (&summary, 2));
    assert!(temp.path().join("c/runs/cart-pole/expert/seed-3.json").is_file());
    for args in [["show", "c"], ["report", "c"], ["show", "c/digest"]] {
        assert_eq!(object(temp.path(), &args)["result"]["groups"], summary, "{args:?}");
    }
    assert_eq!(object(temp.path(), &args)["result"]["done_before"], 4);
}

#[test]
fn tasks_pages_completions_and_the_installation_are_told() {
    let temp = tempfile::tempdir().unwrap();
    let tasks = object(temp.path(), &["tasks"])["result"]["tasks"].clone();
    assert!(tasks.as_array().unwrap().iter().any(|task| task["name"] == "pendulum"));
    let task = object(temp.path(), &["tasks", "pendulum"])["result"].clone();
    assert_eq!((&task["threshold"], &task["dt"], &task["max_steps"]), (&json!(-180.0), &json!(0.05), &200.into()));
    assert_eq!(task["actions"], json!({"kind": "box", "low": [-2.0], "high": [2.0]}));
    assert_eq!(task["state"][1], json!({"name": "ω", "unit": "rad/s", "low": -8.0, "high": 8.0}));
    let task = object(temp.path(), &["tasks", "cart-pole"])["result"].clone();
    assert_eq!(task["actions"], json!({"kind": "discrete", "controls": [[-10.0], [10.0]]}));

    let doctor = object(temp.path(), &["doctor"])["result"].clone();
    let write = doctor["checks"].as_array().unwrap().iter().find(|check| check["name"] == "write access").unwrap();
    assert_eq!((&doctor["broken"], &write["state"]), (&false.into(), &"ok".into()));
    let broken = object(temp.path(), &["doctor", "nowhere"]);
    assert_eq!((&broken["exit_code"], &broken["result"]["broken"]), (&1.into(), &true.into()));

    let script = object(temp.path(), &["completions", "bash"])["result"]["script"].clone();
    assert!(script.as_str().unwrap().contains("_sindyna()"));
    assert!(object(temp.path(), &["man"])["result"]["page"].as_str().unwrap().starts_with(".ie"));
    let pages = object(temp.path(), &["man", "pages"])["result"]["written"].clone();
    assert!(pages.as_array().unwrap().contains(&"pages/sindyna-train.1".into()), "{pages}");
    assert!(fs::read_to_string(temp.path().join("pages/sindyna-train.1")).unwrap().contains("sindyna\\-train"));
}

#[test]
fn errors_are_objects_with_the_exit_code_of_old() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), "t,x\n0,1\n1,nan\n").unwrap();
    fs::write(temp.path().join("task.toml"), "name = 1").unwrap();
    for (args, command, kind, message, hint) in [
        (&["train", "pendulm"][..], "train", "name", "no task named `pendulm`", Some("did you mean `pendulum`?")),
        (&["train", "--polcy"], "train", "usage", "unexpected argument '--polcy'", None),
        (&["trian"], "sindyna", "usage", "unrecognized subcommand 'trian'", Some("did you mean `train`?")),
        (&["train", "pendulum", "--solver", "stlqs"], "train", "usage", "stlqs", Some("did you mean `stlsq`?")),
        (&["train", "pendulum", "--set", "polyac=1"], "train", "name", "no setting", Some("did you mean `polyak`?")),
        (&["train", "pendulum", "--discount", "2"], "train", "setting", "sac.discount", Some("--discount 0.999")),
        (&["identify", "log.csv", "--states", "x"], "identify", "log", "line 3", Some("it ends a trajectory")),
        (&["train", "--task-file", "task.toml"], "train", "task-file", "task.toml", Some("docs/task-files.md")),
        (&["show", "nowhere"], "show", "input", "nowhere: no such file or directory", Some("sindyna train")),
        (&["report", "nowhere"], "report", "record", "nowhere", Some("comparison")),
        (
            &["export", "nowhere", "--to", "python"],
            "export",
            "io",
            "cannot read nowhere",
            Some("DIR is an output directory"),
        ),
    ] {
        let told = object(temp.path(), args);
        let error = &told["error"];
        assert_eq!(
            (&told["command"], &told["exit_code"], &error["kind"]),
            (&command.into(), &2.into(), &kind.into()),
            "{args:?} {error}"
        );
        assert!(error["message"].as_str().unwrap().contains(message), "{args:?} {error}");
        assert!(hint.is_none_or(|hint| error["hint"].as_str().unwrap().contains(hint)), "{args:?} {error}");
        assert!(told["result"].is_null());
    }
}

#[test]
fn colours_are_there_where_they_are_asked_for() {
    let temp = tempfile::tempdir().unwrap();
    for (args, colours) in [
        (&["tasks", "x"][..], false),
        (&["tasks", "x", "--color", "always"], true),
        (&["--color=always", "tasks", "--what"], true),
        (&["tasks", "x", "--color", "never"], false),
    ] {
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), args));
        assert_eq!((code, stdout.as_str(), stderr.contains('\u{1b}')), (2, "", colours), "{args:?}: {stderr}");
    }
}

/// Names of all fields in `value`, however deep.
fn fields(value: &Value, into: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(name, value)| {
            into.insert(name.clone());
            fields(value, into);
        }),
        Value::Array(list) => list.iter().for_each(|value| fields(value, into)),
        _ => {}
    }
}

#[test]
fn every_field_and_column_of_a_record_is_documented() {
    let temp = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/spring");
    for name in ["spring.csv", "spring.toml"] {
        fs::copy(examples.join(name), temp.path().join(name)).unwrap();
    }
    let run = |line: &str| {
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &line.split(' ').collect::<Vec<_>>()));
        assert!(code <= 1, "{line}: {stdout}{stderr}");
    };
    run("train pendulum --noise 0.001 --max-updates 400 --episodes 3 --max-real-steps 200 --out run --quiet");
    run("identify spring.csv --states x,v --inputs F --holdout 0.2 --out model --quiet");
    run("train --task-file spring.toml --model model --max-updates 300 --out log --quiet");
    run("compare --tasks pendulum --methods sindy-lqr,random,sac --budget 250 --seeds 2 --out c --quiet");
    let mut names = BTreeSet::new();
    for file in [
        "run/model.json",
        "run/identify.json",
        "run/summary.json",
        "run/timing.json",
        "model/identify.json",
        "log/summary.json",
        "log/timing.json",
        "c/summary.json",
        "c/runs/pendulum/random/seed-0.json",
        "c/runs/pendulum/random/seed-0.timing.json",
        "c/runs/pendulum/sac/seed-1.json",
    ] {
        fields(&serde_json::from_str(&fs::read_to_string(temp.path().join(file)).unwrap()).unwrap(), &mut names);
    }
    for line in fs::read_to_string(temp.path().join("run/events.jsonl")).unwrap().lines() {
        let event: Value = serde_json::from_str(line).unwrap();
        names.insert(event["event"].as_str().unwrap().to_owned());
    }
    for file in ["run/config.toml", "log/config.toml", "c/compare.toml"] {
        let text = fs::read_to_string(temp.path().join(file)).unwrap();
        names.extend(text.parse::<toml::Table>().unwrap().keys().cloned());
    }
    for file in ["c/asked.csv", "c/digest/checksums.csv"] {
        let text = fs::read_to_string(temp.path().join(file)).unwrap();
        names.extend(text.lines().next().unwrap().split(',').map(String::from));
    }
    for directory in ["run", "model", "log", "c", "c/digest"] {
        let entries = fs::read_dir(temp.path().join(directory)).unwrap();
        names.extend(
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).filter(|name| name != "runs"),
        );
    }
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/formats.md")).unwrap();
    let missing: Vec<&String> = names.iter().filter(|name| !page.contains(&format!("`{name}`"))).collect();
    assert!(
        missing.is_empty() && names.len() > 100,
        "{} names, of which docs/formats.md lacks {missing:?}",
        names.len()
    );
}
