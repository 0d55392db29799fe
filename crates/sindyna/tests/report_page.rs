//! The page of a comparison as a browser shows it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{parts, sindyna};

/// Runs the script that looks at a page; it says so and succeeds where there is no browser.
fn look_at(page: &Path) -> (i32, String) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/report_screenshots.py");
    let output = Command::new("python3").arg(script).arg(page).output().expect("python3 is needed by other tests too");
    let (code, stdout, stderr) = parts(&output);
    (code, stdout + &stderr)
}

#[test]
fn a_page_has_all_its_sections_and_looks_well_in_a_browser() {
    let temp = tempfile::tempdir().unwrap();
    let methods = "sindy,oracle,lqr,expert,random";
    let args =
        ["compare", "--tasks", "pendulum,cart-pole", "--methods", methods, "--seeds", "2", "--out", "all", "--quiet"];
    let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stderr}");
    let page = temp.path().join("all/report.html");
    let text = fs::read_to_string(&page).unwrap();
    for wanted in [
        "<h2>Learning curves</h2>",
        "<h2>Real steps until solved</h2>",
        "<h2>Returns at the end</h2>",
        "<h2>All tasks on one scale</h2>",
        "<h2>Equations found</h2>",
        "<h2>Phase portraits</h2>",
        "<h2>Table 1 of the paper</h2>",
        "<h2>Models and costs</h2>",
        "<h2>Findings</h2>",
        "<a href=\"settings.toml\">",
        "the expert acts",
        "2 of 2",
        "ω\u{307} = 15 sin θ + 3 u",
        "lqr does not apply to pendulum",
        "<h2>Real steps and wall-clock time</h2>",
    ] {
        assert!(text.contains(wanted), "{wanted} is missing");
    }
    let (code, said) = look_at(&page);
    assert_eq!(code, 0, "{said}");
    println!("{said}");
}

#[test]
fn what_is_wrong_with_a_page_is_seen() {
    let temp = tempfile::tempdir().unwrap();
    let page = temp.path().join("bad.html");
    let figure = "<figure><svg viewBox='0 0 460 320' width='460' aria-label='it'><text x='455' y='20'>cut off</text></svg></figure>";
    let script = "<script>console.error('no')</script><img src='https://example.invalid/a.png'>";
    fs::write(&page, format!("<meta name='viewport' content='width=device-width'><main>{figure}{script}<p style='width:600px'>wide</p></main>"))
        .unwrap();
    let (code, said) = look_at(&page);
    if said.starts_with("skipped") {
        println!("{said}");
        return;
    }
    assert_eq!(code, 1, "{said}");
    for wanted in ["\"cut off\" is cut off", "console:", "asks for https://example.invalid", "pixels wide"] {
        assert!(said.contains(wanted), "{wanted}: {said}");
    }
}
