//! What the command prints, word for word: every help text, an error of each kind, results of fixed seeds, and what README says of them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;

use common::{command, example, parts};
use insta::assert_snapshot;
use sindyna_rl::Isa;

/// Exit code, stdout and stderr of `sindyna ARGS` in `directory`, as on a terminal of a hundred columns.
fn sindyna(directory: &Path, args: &[&str]) -> (i32, String, String) {
    parts(&command(directory, args).env_remove("COLUMNS").env("NO_COLOR", "1").output().unwrap())
}

/// `text` without the lines that have times in them, and with what rounding leaves as one and the same: it differs from processor to processor.
fn timeless(text: &str) -> String {
    let is_rounding =
        |word: &str| word.replace('−', "-").parse::<f64>().is_ok_and(|value| value != 0.0 && value.abs() < 1e-13);
    let shown = |line: &str| {
        let words = line.split(' ').map(|word| if is_rounding(word) { "<rounding>" } else { word });
        words.collect::<Vec<_>>().join(" ") + "\n"
    };
    let is_time = |line: &str| line.starts_with("seconds: ") || line.starts_with("one action takes ");
    text.lines().filter(|line| !is_time(line)).map(shown).collect()
}

const COMMANDS: [&str; 12] = [
    "train",
    "identify",
    "inspect",
    "export",
    "evaluate",
    "compare",
    "show",
    "report",
    "tasks",
    "doctor",
    "completions",
    "man",
];

#[test]
fn help_is_what_it_was() {
    let temp = tempfile::tempdir().unwrap();
    let (code, all, _) = sindyna(temp.path(), &["--help"]);
    assert_eq!(code, 0);
    assert_snapshot!("help", all);
    for name in COMMANDS {
        assert!(all.contains(&format!("\n  {name} ")), "{name} is not in the list");
        let (code, text, _) = sindyna(temp.path(), &[name, "--help"]);
        assert_eq!(code, 0);
        assert_snapshot!(format!("help-{name}"), text);
    }
}

#[test]
fn errors_are_what_they_were() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), "t,x\n0,1\n1,inf\n").unwrap();
    fs::write(temp.path().join("names.csv"), "t,oil\n0,1\n1,2\n").unwrap();
    fs::write(temp.path().join("semicolons.csv"), "t;x\n0;1\n1;one\n").unwrap();
    fs::write(temp.path().join("task.toml"), "name = 1\n").unwrap();
    let errors: Vec<String> = [
        &["train", "pendulm"][..],
        &["trian"],
        &["train", "--sed", "1"],
        &["train", "pendulum", "--solver", "stlqs"],
        &["train", "pendulum", "--set", "polyac=1"],
        &["train", "pendulum", "--set", "sac.polyak=much"],
        &["train", "pendulum", "--discount", "2"],
        &["train", "pendulum", "--term", "sin(phi)"],
        &["train", "--task-file", "task.toml"],
        &["identify", "log.csv", "--states", "x"],
        &["identify", "names.csv"],
        &["identify", "semicolons.csv", "--states", "x"],
        &["identify", "log.csv", "--states", "x", "--delimiter", "ab"],
        &["identify", "log.csv", "--states", "x", "--time-column", "time"],
        &["compare", "--seeds", "9-3"],
        &["compare", "--variant", "stlsq"],
        &["evaluate", "nowhere"],
        &["export", "nowhere", "--to", "python"],
        &["report", "nowhere"],
        &["show", "nowhere"],
    ]
    .iter()
    .map(|args| {
        let (code, stdout, stderr) = sindyna(temp.path(), args);
        assert_eq!((code, stdout.as_str()), (2, ""), "{args:?}: {stderr}");
        format!("$ sindyna {}\n{stderr}", args.join(" "))
    })
    .collect();
    assert_snapshot!("errors", errors.join("\n"));
}

#[test]
fn results_are_what_they_were() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), example()).unwrap();
    let args = "identify log.csv --states th,w --inputs u --angles th --out model";
    let (code, identified, progress) = sindyna(temp.path(), &args.split(' ').collect::<Vec<_>>());
    assert_eq!((code, progress.as_str()), (0, "read: 101 rows, 100 steps; searching for equations\n"));
    assert_snapshot!("identify", timeless(&identified));
    // The same on every machine.
    let args = "train pendulum --isa portable --seed 1 --max-updates 600 --episodes 10 --out run";
    let (code, trained, progress) = sindyna(temp.path(), &args.split(' ').collect::<Vec<_>>());
    assert_eq!(code, 1, "{progress}");
    assert_snapshot!("train", timeless(&trained));
    assert_snapshot!("train-progress", progress);
    let (code, shown, _) = sindyna(temp.path(), &["show", "run"]);
    assert_eq!((code, shown), (0, trained));
}

/// The text after the first fence ```` ```text ```` behind `marker`.
fn fenced<'a>(page: &'a str, marker: &str) -> &'a str {
    let text = page.split_once(marker).unwrap().1.split_once("```text\n").unwrap().1;
    text.split_once("```").unwrap().0
}

#[test]
fn pages_show_what_is_printed() {
    // Portable instructions round otherwise.
    if Isa::Avx2.checked().is_err() {
        return;
    }
    let temp = tempfile::tempdir().unwrap();
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md")).unwrap();
    let (code, printed, _) = sindyna(temp.path(), &["train", "pendulum"]);
    assert_eq!((code, timeless(&printed)), (0, timeless(fenced(&page, "sindyna train pendulum"))));

    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/logs.md")).unwrap();
    fs::create_dir_all(temp.path().join("examples/logs")).unwrap();
    fs::write(temp.path().join("examples/logs/pendulum.csv"), example()).unwrap();
    let args = "identify examples/logs/pendulum.csv --states th,w --inputs u --angles th";
    let (code, printed, _) = sindyna(temp.path(), &args.split(' ').collect::<Vec<_>>());
    assert_eq!((code, timeless(&printed)), (0, timeless(fenced(&page, args))));
}

#[test]
fn pages_name_no_option_that_there_is_not() {
    let temp = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages = vec![root.join("README.md"), root.join("examples/logs/README.md")];
    pages.extend(fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path()));
    let mut named = 0;
    for page in pages.iter().filter(|page| page.extension().is_some_and(|end| end == "md")) {
        let text = fs::read_to_string(page).unwrap();
        for call in calls(&text) {
            let mut words = call.split_whitespace();
            let name = words.next().unwrap_or_default();
            if !COMMANDS.contains(&name) {
                continue;
            }
            let (_, help, _) = sindyna(temp.path(), &[name, "--help"]);
            for option in words.filter(|word| word.starts_with("--") && word.len() > 2) {
                let option = option.split('=').next().unwrap().trim_end_matches(|c: char| !c.is_ascii_alphanumeric());
                let known = help.split(|c: char| c.is_whitespace() || c == ',').any(|word| word == option);
                assert!(known, "{}: `sindyna {call}` has no {option}", page.display());
                named += 1;
            }
        }
    }
    assert!(named >= 25, "only {named} options were looked at");
}

/// What follows `sindyna` in the code of a page: in its shell fences and between backticks, lines joined that end in `\`.
fn calls(page: &str) -> Vec<String> {
    let joined = page.replace("\\\n", " ");
    let mut found = Vec::new();
    for (i, part) in joined.split("```").enumerate() {
        let pieces: Vec<&str> = match i % 2 {
            // Fences.
            1 => part.lines().collect(),
            _ => part.split('`').skip(1).step_by(2).collect(),
        };
        let code = pieces.into_iter().map(|line| line.trim_start_matches(['$', ' ']));
        found.extend(
            code.filter_map(|code| code.strip_prefix("sindyna "))
                .map(|rest| rest.split(['|', '#', '>', ';']).next().unwrap_or_default().to_owned()),
        );
    }
    found
}
