//! Comparisons as the user meets them: what is left, what is refused, and that it goes on where it was cut off.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use common::{command, json, parts, sindyna};
use rand::RngExt as _;
use sindyna_core::Seed;

const QUICK: [&str; 6] = ["compare", "--tasks", "pendulum,cart-pole", "--methods", "lqr,expert,random", "--quiet"];

fn compare(directory: &Path, more: &[&str]) -> (i32, String, String) {
    parts(&sindyna(directory, &[&QUICK[..], more].concat()))
}

/// Files that tell how long something took.
const TIMED: [&str; 4] = ["timing.json", "timing.csv", "report.html", "figures/wall-time-"];

/// Every file below `root` but those with times, with its contents.
fn files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![root.to_owned()];
    while let Some(directory) = open.pop() {
        for entry in fs::read_dir(directory).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if !TIMED.iter().any(|part| path.to_string_lossy().contains(part)) {
                let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
                found.insert(name, fs::read(path).unwrap());
            }
        }
    }
    found
}

#[test]
fn a_comparison_goes_on_where_it_was_cut_off_with_the_same_bytes() {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = compare(temp.path(), &["--seeds", "2", "--out", "whole"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    let whole = files(&temp.path().join("whole"));
    // A controller for both tasks, a regulator for one, random actions for both: two seeds each; settings of the regulator's
    // data. Settings, what was asked, settings of all methods, summary and table of all; six files of the digest; the curves of two tasks,
    // all and from the threshold up, and two profiles, twice each.
    assert_eq!(whole.len(), 2 * 5 + 1 + 5 + 6 + 2 * 6, "{:?}", whole.keys());
    let summary = json(&temp.path().join("whole/summary.json"));
    let expert =
        summary.as_array().unwrap().iter().find(|g| g["task"] == "cart-pole" && g["method"] == "expert").unwrap();
    assert_eq!(
        (&expert["solved"], &expert["runs"], &expert["steps"]),
        (&2.into(), &2.into(), &serde_json::Value::Null)
    );

    let (code, _, stderr) = compare(temp.path(), &["--seeds", "2", "--out", "cut", "--threads", "1"]);
    assert_eq!(code, 0, "{stderr}");
    fs::remove_file(temp.path().join("cut/runs/pendulum/expert/seed-1.json")).unwrap();
    fs::write(temp.path().join("cut/runs/cart-pole/lqr/seed-0.json"), "{\"task\": ").unwrap();
    assert_eq!(compare(temp.path(), &["--seeds", "2", "--out", "cut"]).0, 0);
    assert_eq!(files(&temp.path().join("cut")), whole);
}

/// All methods on all tasks, with too few real steps for most to solve anything.
#[test]
fn every_method_comes_to_an_end_on_every_task() {
    // Tasks, methods, real steps, and how many of them come after the random ones of `sac` and of `mbpo`. Ensembles take longest, on the task with the most steps minutes.
    let all = "sindy,mbpo,mbpo-paper,sac,sac20,oracle,lqr,expert,random";
    let budgets = [
        ("cart-pole,pendulum", all, 260, 160, Some(10)),
        ("inverted-pendulum", "sindy,mbpo,sac,sac20,oracle,lqr,expert,random", 260, 160, Some(10)),
        ("mountain-car", "sindy,sac,sac20,oracle,lqr,expert,random", 1_010, 10, None),
    ];
    let temp = tempfile::tempdir().unwrap();
    for (number, (tasks, methods, budget, sac, mbpo)) in budgets.into_iter().enumerate() {
        let (out, steps) = (format!("to-{number}"), budget.to_string());
        let args = ["compare", "--tasks", tasks, "--methods", methods, "--seeds", "1", "--quiet"];
        let args = [&args[..], &["--budget", &steps, "--out", &out]].concat();
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
        assert_eq!(code, 0, "{stdout}{stderr}");
        for task in tasks.split(',') {
            let outcome = |method: &str| json(&temp.path().join(format!("{out}/runs/{task}/{method}/seed-0.json")));
            let sindy = outcome("sindy");
            assert_eq!((&sindy["solved_after"], &sindy["failure"]), (&10.into(), &serde_json::Value::Null), "{task}");
            let mut updates = vec![("sac", sac), ("sac20", 20 * sac)];
            updates.extend(mbpo.into_iter().flat_map(|steps| [("mbpo", 10 * steps), ("mbpo-paper", 10 * steps)]));
            for (method, updates) in updates.into_iter().filter(|(method, _)| methods.split(',').any(|m| m == *method))
            {
                let run = outcome(method);
                assert_eq!(run["failure"], serde_json::Value::Null, "{task} {method}");
                assert_eq!((&run["real_steps"], &run["updates"]), (&budget.into(), &updates.into()), "{task} {method}");
                assert_eq!(run["returns"].as_array().unwrap().len(), 100);
            }
            // One round of branching, a hundred imagined steps for each of 250 real ones; none from states that end the task.
            if mbpo.is_some() {
                let imagined = outcome("mbpo")["model_steps"].as_u64().unwrap();
                assert!((20_000..=25_000).contains(&imagined), "{task}: {imagined}");
            }
        }
    }
}

#[test]
fn a_comparison_killed_ten_times_leaves_the_same_bytes() {
    let temp = tempfile::tempdir().unwrap();
    let args = ["compare", "--tasks", "pendulum,cart-pole", "--methods", "sindy,lqr,expert,random", "--seeds", "2"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &[&args[..], &["--out", "whole"]].concat()));
    assert_eq!(code, 0, "{stdout}{stderr}");
    let broken = [&args[..], &["--out", "broken"]].concat();
    let mut rng = Seed::new(0).stream("kills", 0);
    for _ in 0..10 {
        let mut process = command(temp.path(), &broken).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        sleep(Duration::from_millis(rng.random_range(0..700)));
        // Unix sends SIGKILL: nothing can be tidied up.
        process.kill().unwrap();
        process.wait().unwrap();
    }
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &broken));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert_eq!(files(&temp.path().join("broken")), files(&temp.path().join("whole")));
}

#[test]
fn tasks_with_and_without_noise_stand_side_by_side() {
    let temp = tempfile::tempdir().unwrap();
    let of = |noise: &str, out: &str| {
        let (code, stdout, stderr) = compare(temp.path(), &["--noise", noise, "--seeds", "2", "--out", out]);
        assert_eq!(code, 0, "{stderr}");
        (stdout, json(&temp.path().join(out).join("summary.json")))
    };
    let ((table, both), (_, quiet), (_, noisy)) = (of("0,0.2", "both"), of("0", "quiet"), of("0.2", "noisy"));
    assert!(table.contains("pendulum+noise-0.2"), "{table}");
    // Each is what it is alone; noise is seen by a controller and changes nothing for who looks at no sensor.
    let all = both.as_array().unwrap();
    let alone = [quiet.as_array().unwrap(), noisy.as_array().unwrap()];
    assert_eq!(all.len(), alone[0].len() + alone[1].len());
    let earned = |groups: &[serde_json::Value], task: &str, method: &str| {
        groups.iter().find(|g| g["task"] == task && g["method"] == method).unwrap()["returns"].clone()
    };
    for (task, method) in [("pendulum", "expert"), ("pendulum", "random")] {
        let noisy_task = format!("{task}+noise-0.2");
        let (without, with) = (earned(all, task, method), earned(all, &noisy_task, method));
        assert_eq!(without, earned(alone[0], task, method));
        assert_eq!(with, earned(alone[1], &noisy_task, method));
        assert_eq!(without == with, method == "random", "{task} {method}: {without} {with}");
    }
    // The digest tells as much.
    let again = parts(&sindyna(temp.path(), &["report", "both/digest"]));
    assert_eq!((again.0, again.1.contains("cart-pole+noise-0.2")), (0, true), "{}", again.2);
}

#[test]
fn a_part_of_a_comparison_leaves_the_report_on_the_rest_as_it_is() {
    let temp = tempfile::tempdir().unwrap();
    assert_eq!(compare(temp.path(), &["--seeds", "2", "--out", "all"]).0, 0);
    let whole = files(&temp.path().join("all"));
    let part = ["compare", "--tasks", "pendulum", "--methods", "lqr,random", "--seeds", "1", "--out", "all"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &part));
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stderr.contains("note: lqr does not apply to pendulum") && stderr.contains("1 run, 1 of them done before"),
        "{stderr}"
    );
    assert!(stdout.contains("cart-pole") && stdout.contains("2 of 2"), "{stdout}");
    assert_eq!(files(&temp.path().join("all")), whole);
}

#[test]
fn a_digest_tells_all_that_its_comparison_does() {
    let temp = tempfile::tempdir().unwrap();
    assert_eq!(compare(temp.path(), &["--seeds", "2", "--out", "all"]).0, 0);
    let (whole, digest) = (files(&temp.path().join("all")), temp.path().join("all/digest"));
    let told = |args: &[&str]| {
        let (code, _, stderr) = parts(&sindyna(temp.path(), args));
        assert_eq!(code, 0, "{stderr}");
    };
    told(&["report", "all"]);
    assert_eq!(files(&temp.path().join("all")), whole, "the comparison tells the same again");
    fs::rename(&digest, temp.path().join("kept")).unwrap();
    told(&["report", "kept"]);
    let kept = files(&temp.path().join("kept"));
    for name in ["summary.json", "table.md", "figures/curves-pendulum.svg", "figures/profile.png"] {
        assert_eq!(kept[name], whole[name], "{name}");
    }
    told(&["report", "kept", "--markdown", "page.md"]);
    let page = fs::read_to_string(temp.path().join("page.md")).unwrap();
    let figures: Vec<&str> = page.lines().filter_map(|l| l.strip_prefix("![")?.split(['(', ')']).nth(1)).collect();
    // Two of learning curves and one of times for each task, two profiles.
    assert_eq!(figures.len(), 2 * 3 + 2, "{page}");
    for figure in figures {
        assert!(temp.path().join(figure).is_file(), "{figure} is missing");
    }
    told(&["report", "kept", "--markdown", "page.md"]);
    fs::write(temp.path().join("README.md"), "# Mine\n").unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["report", "kept", "--markdown", "README.md"]));
    assert!(code == 2 && stderr.contains("README.md exists and is not a report"), "{stderr}");
    assert_eq!(fs::read_to_string(temp.path().join("README.md")).unwrap(), "# Mine\n");
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["report", "all/runs"]));
    assert!(code == 2 && stderr.contains("holds no record"), "{stderr}");
}

#[test]
fn a_report_waits_for_a_comparison_at_work_unless_it_goes_elsewhere() {
    let temp = tempfile::tempdir().unwrap();
    let all = temp.path().join("all");
    assert_eq!(compare(temp.path(), &["--seeds", "1", "--out", "all"]).0, 0);
    fs::remove_dir_all(all.join("digest")).unwrap();
    fs::write(all.join(".unfinished-x"), "half a").unwrap();
    let before = files(&all);
    let at_work = fs::File::open(&all).unwrap();
    at_work.try_lock().unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["report", "all"]));
    assert!(
        code == 2 && stderr.contains("all is in use by another sindyna process") && stderr.contains("--markdown"),
        "{stderr}"
    );
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["report", "all", "--markdown", "page.md"]));
    assert!(code == 0 && temp.path().join("page.md").exists(), "{stderr}");
    assert_eq!(files(&all), before, "a report elsewhere writes nothing here");
    drop(at_work);
    assert_eq!(parts(&sindyna(temp.path(), &["report", "all"])).0, 0);
    assert!(all.join("digest/runs.csv").exists() && !all.join(".unfinished-x").exists());
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let temp = tempfile::tempdir().unwrap();
    for (args, says) in [
        (&["--methods", "magic"][..], "no method named `magic`"),
        (&["--tasks", "pendulums"], "did you mean `pendulum`?"),
        (&["--tasks", "pendulum", "--methods", "lqr"], "none of these methods applies"),
        (&["--seeds", "0"], "--seeds"),
        (&["--methods", "sac,"], "a name in the list is empty"),
        (&["--noise", "0,1e-300"], "between 1e-12 and 1"),
        (&["--noise", "0,nan"], "between 1e-12 and 1"),
    ] {
        let (code, _, stderr) = parts(&sindyna(temp.path(), &[&["compare", "--out", "new"], args].concat()));
        assert!(code == 2 && stderr.contains(says), "{args:?}: {stderr}");
    }
    assert!(!temp.path().join("new").exists());
    // A directory of something else stays as it is.
    fs::create_dir(temp.path().join("run")).unwrap();
    fs::write(temp.path().join("run/summary.json"), "mine").unwrap();
    let (code, _, stderr) = compare(temp.path(), &["--out", "run"]);
    assert!(code == 2 && stderr.contains("is not the directory of a comparison"), "{stderr}");
    assert_eq!(fs::read(temp.path().join("run/summary.json")).unwrap(), b"mine");
}

#[test]
fn with_its_whole_budget_a_method_goes_on_after_it_has_solved_the_task() {
    let temp = tempfile::tempdir().unwrap();
    let args = ["compare", "--tasks", "cart-pole", "--methods", "sac", "--seeds", "4", "--budget", "2000", "--quiet"];
    for more in [&["--out", "short"][..], &["--out", "whole", "--whole-budget"]] {
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &[&args[..], more].concat()));
        assert_eq!(code, 0, "{stdout}{stderr}");
    }
    let outcome = |out: &str, seed| json(&temp.path().join(format!("{out}/runs/cart-pole/sac/seed-{seed}.json")));
    let mut ended = 0;
    for seed in 0..4 {
        let (short, whole) = (outcome("short", seed), outcome("whole", seed));
        assert_eq!((&short["solved_after"], &whole["real_steps"]), (&whole["solved_after"], &2_000.into()), "{seed}");
        ended += usize::from(short["real_steps"].as_u64() < Some(2_000));
    }
    assert!(ended > 0, "of four seeds one solves it");
    let (code, _, stderr) = parts(&sindyna(temp.path(), &[&args[..], &["--out", "whole"]].concat()));
    assert!(code == 2 && stderr.contains("other settings: whole_budget true there, none here"), "{stderr}");
}

#[test]
fn a_task_or_method_named_twice_counts_once() {
    let temp = tempfile::tempdir().unwrap();
    let args = ["compare", "--tasks", "pendulum,pendulum", "--methods", "expert,expert", "--seeds", "1", "--quiet"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert!(code == 0 && stdout.contains("1 of 1"), "{stdout}{stderr}");
}

#[test]
fn variants_and_seeds_of_ones_own_stand_beside_the_methods() {
    let temp = tempfile::tempdir().unwrap();
    let variant = "short: max_updates=400,solver=stlsq,threshold=0.1";
    let args = ["compare", "--tasks", "pendulum", "--methods", "random", "--variant", variant, "--quiet"];
    let run = |more: &[&str]| parts(&sindyna(temp.path(), &[&args[..], more].concat()));
    let (code, stdout, stderr) = run(&["--seeds", "0-0,7-7", "--out", "c"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("sindy+short"), "{stdout}");
    for seed in [0, 7] {
        let outcome = json(&temp.path().join(format!("c/runs/pendulum/sindy+short/seed-{seed}.json")));
        assert_eq!((&outcome["method"], &outcome["updates"]), (&"sindy+short".into(), &400.into()));
    }
    let settings = fs::read_to_string(temp.path().join("c/runs/pendulum/sindy+short/settings.toml")).unwrap();
    assert!(settings.contains("solver = \"stlsq\"") && settings.contains("max_updates = 400"), "{settings}");
    assert_eq!(
        fs::read_to_string(temp.path().join("c/digest/asked.csv")).unwrap(),
        "task,method,seeds\npendulum,random,\"0-0,7-7\"\npendulum,sindy+short,\"0-0,7-7\"\n"
    );
    let whole = files(&temp.path().join("c"));
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["report", "c"]));
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(files(&temp.path().join("c")), whole, "the report tells the same again");

    let other = ["compare", "--tasks", "pendulum", "--methods", "random", "--variant", "short: max_updates=500"];
    let (code, _, stderr) = parts(&sindyna(temp.path(), &[&other[..], &["--out", "c"]].concat()));
    assert!(code == 2 && stderr.contains("a variant `sindy+short` with other settings"), "{stderr}");
    for (variant, says) in [
        ("a: polyac=1", "did you mean `polyak`?"),
        ("a: rollout_len=1", "`imagination.rollout_len` or `warmup.rollout_len`"),
        ("a: discount=2", "sac.discount must be"),
        ("../a: discount=0.5", "letters, digits"),
    ] {
        let args = ["compare", "--tasks", "pendulum", "--variant", variant, "--out", "d"];
        let (code, _, stderr) = parts(&sindyna(temp.path(), &args));
        assert!(code == 2 && stderr.contains(says) && !temp.path().join("d").exists(), "{variant}: {stderr}");
    }
}
