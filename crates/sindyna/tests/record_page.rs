//! `report.html` of runs and identifications.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use common::{COLUMNS, example, identify, json, parts, sindyna};

/// Bytes that a page may have.
const MOST: usize = 300_000;

/// Every drawing and every equation of a page as a tree: what is no valid XML fails.
fn elements<'a>(page: &'a str, name: &str) -> Vec<roxmltree::Document<'a>> {
    let (open, close) = (format!("<{name}"), format!("</{name}>"));
    let mut found = Vec::new();
    let mut rest = page;
    while let Some(start) = rest.find(&open) {
        let end = start + rest[start..].find(&close).expect("it is closed") + close.len();
        let text = &rest[start..end];
        found.push(roxmltree::Document::parse(text).unwrap_or_else(|e| panic!("{e}: {text}")));
        rest = &rest[end..];
    }
    found
}

/// Checks what every page has: valid drawings and equations, nothing from outside, a bounded size.
fn check(page: &Path) -> String {
    let text = fs::read_to_string(page).unwrap();
    assert!(!elements(&text, "svg").is_empty(), "no drawing");
    assert!(text.len() < MOST, "{} bytes", text.len());
    for outside in ["http", "src=", "@import", "url("] {
        assert!(!text.contains(outside), "{outside}");
    }
    for tag in ["section", "table", "div", "main", "figure", "p", "math", "svg"] {
        let close = format!("</{tag}>");
        let open = text.matches(&format!("<{tag}>")).count() + text.matches(&format!("<{tag} ")).count();
        assert_eq!(open, text.matches(&close).count(), "{tag}");
    }
    text
}

/// Points of the lines of a class in a page, over all drawings.
fn points(page: &str, class: &str) -> usize {
    let count = |d: &roxmltree::Document<'_>| -> usize {
        let lines = d.descendants().filter(|n| n.has_tag_name("polyline") && n.attribute("class") == Some(class));
        lines.filter_map(|n| n.attribute("points")).map(|p| p.split(' ').count()).sum()
    };
    elements(page, "svg").iter().map(count).sum()
}

fn look_at(page: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/report_screenshots.py");
    let output = Command::new("python3").arg(script).arg(page).output().expect("python3 is needed by other tests too");
    let (code, stdout, stderr) = parts(&output);
    assert_eq!(code, 0, "{stdout}{stderr}");
}

#[test]
fn an_identification_has_a_page_with_its_equations_and_all_samples() {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = identify(temp.path(), &example(), &[&COLUMNS[..], &["--angles", "th"]].concat());
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("report: models/log/report.html"), "{stdout}");
    let model = temp.path().join("models/log");
    let text = check(&model.join("report.html"));
    for wanted in
        ["Identification of log.csv", "Adequate: the residuals of all equations", "Measured and predicted", "Coverage"]
    {
        assert!(text.contains(wanted), "{wanted}");
    }
    // The coefficients of identify.json stand in the page.
    let account = json(&model.join("identify.json"));
    for term in account["equations"][1]["terms"].as_array().unwrap() {
        let shown = sindyna_core::number::coefficient(term["coefficient"].as_f64().unwrap().abs());
        assert!(text.contains(&format!("<mn>{shown}</mn>")), "{shown} of {term}");
    }
    let rows = fs::read_to_string(model.join("prediction.csv")).unwrap().lines().count() - 1;
    assert_eq!(rows, example().lines().filter(|l| !l.starts_with('#')).count() - 1, "every sample is there");
    // Samples on a straight line between others are left out.
    let drawn = points(&text, "measured");
    assert!((rows..=2 * rows).contains(&drawn), "{drawn} points of {rows} samples of both states");
    assert!(text.contains("free run: fit [%]") && text.contains("<td>1.0000</td>"), "R² of exact equations is 1");
    assert!(!elements(&text, "math").is_empty());
    look_at(&model.join("report.html"));

    // The same again from the record, and from another run.
    fs::remove_file(model.join("report.html")).unwrap();
    let (code, stdout, _) = parts(&sindyna(temp.path(), &["report", "models/log"]));
    assert_eq!((code, stdout.trim()), (0, "report: models/log/report.html"));
    assert_eq!(fs::read_to_string(model.join("report.html")).unwrap(), text);
    fs::remove_file(model.join("prediction.csv")).unwrap();
    sindyna(temp.path(), &["report", "models/log"]);
    let older = fs::read_to_string(model.join("report.html")).unwrap();
    assert!(older.contains("Left out: the record has no prediction.csv"), "{older}");

    let without = [&COLUMNS[..], &["--angles", "th", "--no-report", "--out", "without"]].concat();
    let (code, stdout, _) = identify(temp.path(), &example(), &without);
    assert!(code == 0 && !stdout.contains("report:") && !temp.path().join("without/report.html").exists());
}

#[test]
fn a_run_has_a_page_that_plays_an_episode() {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["train", "pendulum", "--seed", "3", "--quiet"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.contains("report: runs/pendulum-seed3/report.html"), "{stdout}");
    let run = temp.path().join("runs/pendulum-seed3");
    let text = check(&run.join("report.html"));
    for wanted in
        ["Solved: mean return", "<th scope=\"col\">true</th>", "class=\"animation\"", "Training curve", "<mn>15</mn>"]
    {
        assert!(text.contains(wanted), "{wanted}");
    }
    // The episode is the evaluation's first.
    let episode = fs::read_to_string(run.join("episode.csv")).unwrap();
    let rewards: f64 = episode.lines().skip(1).filter_map(|l| l.rsplit(',').next()?.parse::<f64>().ok()).sum();
    let first = json(&run.join("summary.json"))["evaluation"]["returns"][0].as_f64().unwrap();
    assert!((rewards - first).abs() < 1e-9, "{rewards} and {first}");
    assert_eq!(episode.lines().count(), 1 + 201);
    // The equations are exact, so the model goes where the pendulum goes.
    let worst = |line: &str| {
        let v: Vec<f64> = line.split(',').filter_map(|f| f.parse().ok()).collect();
        if v.len() == 9 { (v[2].sin() - v[5].sin()).abs().max((v[3] - v[6]).abs()) } else { 0.0 }
    };
    assert!(episode.lines().skip(1).map(worst).fold(0.0, f64::max) < 1e-3);
    look_at(&run.join("report.html"));
    let page = fs::read(run.join("report.html")).unwrap();
    sindyna(temp.path(), &["report", "runs/pendulum-seed3"]);
    assert!(page == fs::read(run.join("report.html")).unwrap(), "the page follows from the record");
    // A record of before there were these files has a page too.
    for name in ["episode.csv", "prediction.csv", "identify.json"] {
        fs::remove_file(run.join(name)).unwrap();
    }
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["report", "runs/pendulum-seed3"]));
    assert_eq!(code, 0, "{stderr}");
    let older = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(older.contains("Left out: the record has no episode.csv, identify.json"), "{older}");
}

#[test]
fn names_from_a_log_mean_nothing_in_a_page() {
    let temp = tempfile::tempdir().unwrap();
    let names = ["<script>alert(1)</script>", "\u{202e}]]>&\"'"];
    let mut log = format!("t,{},\"{}\"\n", names[0], names[1].replace('"', "\"\""));
    for i in 0..200 {
        let t = 0.05 * f64::from(i);
        let _ = writeln!(log, "{t},{},{}", t.cos(), -t.sin());
    }
    fs::write(temp.path().join("<b>.csv"), log).unwrap();
    let states = format!("{},{}", names[0], names[1]);
    let (code, stdout, stderr) = parts(&sindyna(
        temp.path(),
        &["identify", "<b>.csv", "--states", &states, "--circles", "none", "--out", "m", "--quiet"],
    ));
    if code == 2 {
        // Names that are refused do not come into a page.
        assert!(stderr.contains("error:"), "{stdout}{stderr}");
        return;
    }
    let text = check(&temp.path().join("m/report.html"));
    for bad in ["<script>alert", "\u{202e}", "]]>&\"", "of <b>"] {
        assert!(!text.contains(bad), "{bad}");
    }
    assert!(text.contains("&lt;script&gt;alert(1)"), "the name is shown");
}

#[test]
fn the_page_of_a_long_log_is_small() {
    let temp = tempfile::tempdir().unwrap();
    let mut log = String::from("t,x,v\n");
    for i in 0..100_000 {
        let t = 0.01 * f64::from(i);
        let _ = writeln!(log, "{t:.2},{:.9},{:.9}", t.cos(), -t.sin());
    }
    let (code, stdout, stderr) = identify(temp.path(), &log, &["--states", "x,v", "--quiet"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let text = check(&temp.path().join("models/log/report.html"));
    assert!(text.contains("The first 600 samples are drawn."));
    let rows = fs::read_to_string(temp.path().join("models/log/prediction.csv")).unwrap().lines().count();
    assert!((1_000..=1_501).contains(&rows), "{rows}");
}
