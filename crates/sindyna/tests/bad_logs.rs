//! Logs and options that `identify` refuses, and what it says of them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;

use common::{COLUMNS, example, identify, parts, sindyna};

/// Expects exit code 2, nothing on stdout and in the directory, and all of `words` on stderr.
fn refuses(log: &str, args: &[&str], words: &[&str]) {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = identify(temp.path(), log, args);
    assert_eq!((code, stdout.as_str()), (2, ""), "{args:?}: {stderr}");
    words.iter().for_each(|w| assert!(stderr.contains(w), "{args:?} should say {w:?}: {stderr}"));
    assert!(!stderr.contains("panicked"), "{stderr}");
    assert_eq!(fs::read_dir(temp.path()).unwrap().count(), 1, "only the log is there");
}

#[test]
fn bad_logs_are_named_by_line_column_value_and_bound() {
    let rows = ["0,3,0,1", "0.1,3.1,0.2,1", "0.2,3.2,0.4,1", "0.3,3.3,0.5,1", "0.4,3.4,0.5,1", "0.5,3.3,0.2,1"];
    let log = |line: usize, row: &str| {
        let mut rows = rows.map(str::to_owned);
        rows[line - 2] = row.to_owned();
        format!("t,th,w,u\n{}\n", rows.join("\n"))
    };
    refuses("", &COLUMNS, &["log.csv is empty"]);
    refuses("t,th,w,u\n", &COLUMNS, &["no rows"]);
    refuses(&log(4, "0.2,inf,0.4,1"), &COLUMNS, &["line 4: column `th`: `inf` is not a finite number"]);
    refuses(&log(4, "0.2,3.2,0.4,inf"), &COLUMNS, &["line 4: column `u`: `inf`"]);
    refuses("t,th,w,u\n0,3,,1\n1,,3,1\n", &COLUMNS, &["line 2: column `w`: an empty cell is not a number"]);
    refuses(&log(4, "0.2,3.2,o.4,1"), &COLUMNS, &["line 4: column `w`: `o.4` is not a number"]);
    refuses(&log(4, "0.2,3.2,0.4"), &COLUMNS, &["line 4: 3 cells where the header names 4 columns"]);
    refuses(&log(4, "0.05,3.2,0.4,1"), &COLUMNS, &["line 4: the time must increase: t = 0.05 follows 0.1 (line 3)"]);
    refuses(&log(4, "0.1,3.2,0.4,1"), &COLUMNS, &["line 4: the time must increase: t = 0.1 follows 0.1"]);
    refuses(log(7, "0.5,3.3").trim_end(), &COLUMNS, &["line 7: cut off (`0.5,3.3`)"]);
    refuses("t,th,w,th\n0,1,2,3\n", &COLUMNS, &["line 1: columns 2 and 4 are both named `th`"]);
    refuses("t,th,w,u\n0,3,0,1\n0.1,3,0,1\n", &COLUMNS, &["2 rows make 1 step, too few", "at least 4"]);
    refuses("t,th,w,u\n0,3,0,1\n", &COLUMNS, &["two rows"]);
    refuses("trajectory,t,th,w,u\na,0,3,0,1\nb,0,3,0,1\na,1,3,0,1\n", &COLUMNS, &["line 4: trajectory `a` goes on"]);
    let angle = [&COLUMNS[..], &["--angles", "th"]].concat();
    refuses("t,th [m],w,u\n0,3,0,1\n0.1,3,0,1\n", &angle, &["`th` is in `m`", "radians", "--units"]);
    refuses("t [furlong],th,w,u\n0,3,0,1\n0.1,3,0,1\n", &COLUMNS, &["`t` is in `furlong`", "s, ms, us, ns, min or h"]);
    refuses("t,th,w,u\n0,3,0,1\n", &[&COLUMNS[..], &["--units", "v=m"]].concat(), &["no column named `v`"]);
    refuses("th,w,u\n3,0,1\n", &COLUMNS, &["no time column", "--time-column", "--dt"]);
    refuses(
        "th,w,u\n1e200,0,1\n2e200,0,1\n3,1e200,2\n4,1,0\n5,2,3\n",
        &[&COLUMNS[..], &["--dt", "1"]].concat(),
        &["error:"],
    );
}

#[test]
fn logs_without_equations_say_what_is_odd_about_them() {
    let of = |scale: f64, still: &str| {
        let row = |line: &str| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            format!("{},{:e},{:e},{:e},{still}\n", cells[0], scale * cells[1], scale * cells[2], cells[3])
        };
        "t,th,w,u,z\n".to_owned() + &example().lines().skip(1).map(row).collect::<String>()
    };
    refuses(
        &of(1.0, "0"),
        &["--states", "th,w,z", "--inputs", "u"],
        &["no equations in log.csv", "`z` is 0 in every row: leave this column out"],
    );
    refuses(&of(1e-150, "0"), &COLUMNS, &["`w` reaches", "e−150: use another unit"]);
    refuses(
        &example(),
        &[&COLUMNS[..], &["--dt", "1e-300"]].concat(),
        &["given as 1e−300 s, but the samples are 0.05", "--time-column none"],
    );
    refuses(&example(), &[&COLUMNS[..], &["--dt", "0.1"]].concat(), &["the sampling interval was given as 0.1 s"]);
    refuses(
        &example(),
        &[&COLUMNS[..], &["--dt", "0.0503"]].concat(),
        &["the sampling interval was given as 0.0503 s"],
    );
    refuses(
        &example(),
        &[&COLUMNS[..], &["--dt", "1e-300", "--time-column", "none"]].concat(),
        &["the sampling interval is 1e−300 s"],
    );
    refuses(&example(), &[&COLUMNS[..], &["--limits", "th=100:101"]].concat(), &["the --limits of `th`"]);
    let many: Vec<String> = (0..2_500).map(|i| format!("--term=sin({i}.5*th)")).collect();
    let many: Vec<&str> = COLUMNS.iter().copied().chain(many.iter().map(String::as_str)).collect();
    refuses(&example(), &many, &["more than the maximum of 2000", "fewer --term"]);
}

#[test]
fn bad_options_are_named() {
    let log = example();
    let with = |args: &[&'static str]| [&COLUMNS[..], args].concat();
    refuses(&log, &["--states", "th,v"], &["no column named `v`; known: `t`, `th`, `w`, `u`"]);
    refuses(&log, &["--states", "th,t"], &["`t` is the column of the time"]);
    refuses(&log, &["--states", "th,th"], &["`th` is named twice"]);
    refuses(&log, &["--states", "th,w", "--inputs", "w"], &["`w` is named twice"]);
    refuses(&log, &with(&["--angles", "u"]), &["no state for `angles` named `u`"]);
    refuses(&log, &with(&["--rates", "w"]), &["RATE=OF"]);
    refuses(&log, &with(&["--rates", "w=w"]), &["its own rate"]);
    refuses(
        &log,
        &with(&["--rates", "w=th,th=w"]),
        &["`th` as the rate of `w` closes a circle", "leave one of the pairs"],
    );
    refuses(&log, &with(&["--circles", "th"]), &["COS=SIN"]);
    refuses(&log, &with(&["--circles", "th=th"]), &["`th` and `th`", "one pair"]);
    refuses(&log, &with(&["--circles", "th=w"]), &["`th` and `w`", "do not add up to 1"]);
    refuses(&log, &with(&["--noise", "th=-1"]), &["SIGMA above 0", "th=-1"]);
    refuses(&log, &with(&["--noise", "v=1"]), &["no state for `noise` named `v`"]);
    refuses(&log, &with(&["--limits", "w=8:-8"]), &["LOW below HIGH", "w=8:-8"]);
    refuses(&log, &with(&["--limits", "v=0:1"]), &["no state for `limits` named `v`"]);
    refuses(&log, &with(&["--angles", "w"]), &["column `w` is in `rad/s`", "radians"]);
    let bare = log.replace(" [rad/s]", "");
    refuses(&bare, &with(&["--rates", "w=th", "--angles", "w"]), &["`w` cannot be both an angle and the rate of `th`"]);
    refuses(&log, &with(&["--dt", "0"]), &["above 0"]);
    refuses(&log, &with(&["--dt", "nan"]), &["above 0"]);
    refuses(&log, &with(&["--resample", "1e-9"]), &["--resample", "10000000"]);
    refuses(&log, &with(&["--precision", "f16"]), &["f16"]);
    refuses(&log, &with(&["--term", "sin(phi)"]), &["phi"]);
    refuses(&log, &with(&["--solver", "stlsq", "--threshold", "-1"]), &["threshold", "-1"]);
    let temp = tempfile::tempdir().unwrap();
    for (args, says) in [
        (&["identify", "missing.csv"][..], "cannot read missing.csv"),
        (&["identify", "."], "cannot read ."),
        (&["export", "missing", "--to", "python"], "cannot read missing"),
        (&["export", "missing", "--to", "pyton"], "did you mean `python`?"),
    ] {
        let (code, _, stderr) = parts(&sindyna(temp.path(), args));
        assert!(code == 2 && stderr.contains(says), "{args:?}: {stderr}");
    }
    fs::write(temp.path().join("model.json"), "{}").unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["export", ".", "--to", "python"]));
    assert!(code == 2 && stderr.contains("./model.json is not a model"), "{stderr}");
}

#[test]
fn whatever_the_bytes_there_is_an_answer() {
    let temp = tempfile::tempdir().unwrap();
    let whole = example().into_bytes();
    let mut damaged: Vec<Vec<u8>> = (0..12).map(|i| whole[..whole.len() * i / 12 + i].to_vec()).collect();
    for (i, byte) in b"\0\xff\",\n\r-e9;\t ".iter().enumerate() {
        let mut bytes = whole.clone();
        bytes[31 + 97 * i] = *byte;
        damaged.push(bytes);
    }
    for (i, bytes) in damaged.iter().enumerate() {
        fs::write(temp.path().join("log.csv"), bytes).unwrap();
        let (code, _, stderr) = parts(&sindyna(temp.path(), &[&["identify", "log.csv"][..], &COLUMNS].concat()));
        assert!(code == 0 || (code == 2 && stderr.contains("error: ")), "{i}: {code} {stderr}");
        assert!(!stderr.contains("panicked"), "{i}: {stderr}");
    }
}
