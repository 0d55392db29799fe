//! The commands of docs/tutorial.md, and that they print what it shows.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;

use common::{command, parts};
use sindyna_rl::Isa;

/// Fences of `page` as (language, text), in order.
fn fences(page: &str) -> Vec<(&str, &str)> {
    page.split("```").skip(1).step_by(2).map(|fence| fence.split_once('\n').unwrap()).collect()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_file() {
            fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
}

#[test]
fn the_tutorial_shows_what_is_printed() {
    // Portable instructions round otherwise.
    if Isa::Avx2.checked().is_err() {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let temp = tempfile::tempdir().unwrap();
    for folder in ["examples/logs", "examples/spring"] {
        copy(&root.join(folder), &temp.path().join(folder));
    }
    let page = fs::read_to_string(root.join("docs/tutorial.md")).unwrap();
    let (mut printed, mut run, mut shown) = (String::new(), 0, 0);
    for (language, text) in fences(&page) {
        match language {
            "sh" => {
                let args: Vec<&str> = text.trim().strip_prefix("sindyna ").unwrap().split_whitespace().collect();
                let (code, stdout, stderr) = parts(&command(temp.path(), &args).output().unwrap());
                assert_eq!(code, 0, "{text}{stderr}");
                (printed, run) = (stdout, run + 1);
            }
            "text" => {
                assert!(printed.contains(text.trim_end()), "{text}\nis not in\n{printed}");
                shown += 1;
            }
            other => panic!("a fence of {other}"),
        }
    }
    assert!(run >= 6 && shown >= 8, "{run} commands, {shown} outputs");
    assert!(temp.path().join("models/lorenz/report.html").exists());

    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let (_, equations) = fences(&readme).into_iter().find(|(_, text)| text.starts_with("equations: adequate")).unwrap();
    let args = ["identify", "examples/logs/lorenz.csv", "--no-report", "--out", "models/readme"];
    let (_, stdout, _) = parts(&command(temp.path(), &args).output().unwrap());
    assert!(stdout.contains(equations.trim_end()), "{stdout}");
}
