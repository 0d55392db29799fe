//! How logs are read: columns, times, units, angles, rates.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use super::common::{COLUMNS, example, identify, json, parts, sindyna};
use super::{at_uneven_times, rows};

#[test]
fn without_options_names_tell_what_columns_are_or_the_call_is_shown() {
    let temp = tempfile::tempdir().unwrap();
    let (code, stdout, _) = identify(temp.path(), &example(), &[]);
    let told = "note: recognised by their names: states th, w; inputs u; --states and --inputs change this";
    assert!(code == 0 && stdout.contains(told) && stdout.contains("15 sin th + 3 u"), "{stdout}");
    let (code, stdout, stderr) = identify(temp.path(), "cos θ,v,reward\n1,2,3\n", &[]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    assert!(
        stderr.contains("which of the columns `cos θ`, `v`, `reward` are states, and which are inputs?"),
        "{stderr}"
    );
    assert!(stderr.contains("--states 'cos θ,v' --dt SECONDS"), "{stderr}");
}

#[test]
fn without_inputs_all_columns_are_states() {
    let temp = tempfile::tempdir().unwrap();
    let rows: String = (0..60)
        .map(|k| 0.1 * f64::from(k))
        .fold(String::new(), |rows, t| rows + &format!("{t},{:.9},{:.9}\n", (-0.5 * t).exp(), 3.0 * (-0.2 * t).exp()));
    let (code, stdout, stderr) = identify(temp.path(), &format!("t,a,b\n{rows}"), &["--inputs", "none"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("states: a, b; inputs: none"), "{stdout}");
    assert!(stdout.contains(" = −0.5 a\n"), "{stdout}");
}

#[test]
fn samples_are_taken_at_their_own_times_from_several_logs() {
    let temp = tempfile::tempdir().unwrap();
    for (name, start) in [("a.csv", 2.0), ("b.csv", -1.0)] {
        fs::write(temp.path().join(name), "time,th,w,u\n".to_owned() + &at_uneven_times(start, 150)).unwrap();
    }
    let args = ["identify", "a.csv", "b.csv", "--angles", "th", "--holdout", "0.2", "--out", "model"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stderr}");
    for says in [
        "log: a.csv, b.csv, 300 rows in 2 trajectories, sampling interval about 0.02",
        "note: time: column time, in milliseconds (one state is then the rate of another); --time-column and --units",
        "note: the sampling interval varies from 0.02 to 0.023 s",
    ] {
        assert!(stdout.contains(says), "{says:?} is missing in {stdout}");
    }
    let account = json(&temp.path().join("model/identify.json"));
    let terms = account["equations"][1]["terms"].as_array().unwrap();
    assert_eq!(terms.len(), 3, "{stdout}");
    for (term, truth) in [("sin th", -15.0), ("w", -0.5), ("u", 3.0)] {
        let found = terms.iter().find(|t| t["term"] == term).unwrap_or_else(|| panic!("{stdout}"));
        assert!((found["coefficient"].as_f64().unwrap() - truth).abs() < 1e-3, "{term}: {stdout}");
    }
    let ahead = account["held_out"]["predictions"][4]["fit_percent"][0][1].as_f64().unwrap();
    assert!(ahead > 99.9, "{ahead}");
    let data = fs::read_to_string(temp.path().join("model/data.csv")).unwrap();
    let second: Vec<&str> = data.lines().nth(2).unwrap().split(',').collect();
    assert_eq!(second[..2], ["0", "0.02"], "as stamped, since the first sample");
}

#[test]
fn rates_are_recognised_declared_or_left_alone() {
    let temp = tempfile::tempdir().unwrap();
    for (option, says) in [
        (&[][..], "w [rad/s] (rate of th); inputs"),
        (&["--rates", "w=th"], "w [rad/s] (rate of th); inputs"),
        (&["--rates", "none"], "th [rad] (angle), w [rad/s]; inputs"),
    ] {
        let (code, stdout, stderr) = identify(temp.path(), &example(), &[&COLUMNS[..], option].concat());
        assert_eq!(code, 0, "{stderr}");
        assert!(stdout.contains(says), "{stdout}");
        assert_eq!(stdout.contains("note: w is used"), option.is_empty());
    }
}

#[test]
fn an_angle_given_as_cosine_and_sine_is_recognised() {
    let temp = tempfile::tempdir().unwrap();
    let turned = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let th: f64 = cells[1].parse().unwrap();
        format!("{},{},{},{},{}\n", cells[0], th.sin(), th.cos(), cells[2], cells[3])
    };
    let log = rows(2.0, 100, |i| 0.05 * i as f64).lines().map(turned).collect::<String>();
    let log = format!("t,sin_th,cos_th,w,u\n{log}");
    let (code, stdout, stderr) = identify(temp.path(), &log, &["--states", "sin_th,cos_th,w", "--inputs", "u"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    for line in [
        "note: cos_th and sin_th are used as cosine and sine of one angle, th",
        "note: w is used as the rate of th",
        "  w\u{307} = 15 sin th + 3 u\n",
    ] {
        assert!(stdout.contains(line), "{line:?} is missing in {stdout}");
    }
    // Nothing explains these steps of Euler; how else they may be read is of no interest here.
    let raw = ["--states", "sin_th,cos_th,w", "--inputs", "u", "--circles", "none"];
    let plain = ["--delay", "0", "--intersample", "zoh", "--unmeasured", "none"];
    let (code, stdout, stderr) = identify(temp.path(), &log, &[&raw[..], &plain].concat());
    assert!(code == 0 && stdout.contains("dcos_th/dt ="), "{stdout}{stderr}");
}

#[test]
fn a_rate_that_is_none_is_doubted() {
    let temp = tempfile::tempdir().unwrap();
    let args = [&COLUMNS[..], &["--rates", "th=w"]].concat();
    let (code, stdout, stderr) = identify(temp.path(), &example(), &args);
    assert!(code == 0 && stdout.contains("as declared, but w deviates"), "{stdout}{stderr}");
}

#[test]
fn rollouts_folded_angles_and_uneven_stamps_are_put_right() {
    let temp = tempfile::tempdir().unwrap();
    let header = "t,th,w,u\n";
    let found = |log: &str, args: &[&str], says: &[&str]| {
        let (code, stdout, stderr) = identify(temp.path(), log, &[&COLUMNS[..], args].concat());
        assert_eq!(code, 0, "{stderr}");
        says.iter().for_each(|s| assert!(stdout.contains(s), "{s:?} is missing in {stdout}"));
    };
    let exact = "w\u{307} = 15 sin th + 3 u";
    // Two rollouts, the last input of each missing, an unused column of words.
    let mut log = String::from("trajectory,t,th,w,u,remark\n");
    for (label, start) in [("a", 3.0), ("b", 2.0)] {
        let rows = rows(start, 30, |i| i as f64 * 0.05);
        let last = rows.trim_end().rfind(',').unwrap();
        log.extend(format!("{},", &rows[..last]).lines().map(|row| format!("{label},{row},fine\n")));
    }
    found(&log, &[], &["in 2 trajectories", "steps used: 58", "`remark` is not used", exact]);
    // No stamps, but an interval.
    let bare: String = rows(3.0, 40, |_| 0.0).lines().map(|r| r.trim_start_matches("0,").to_owned() + "\n").collect();
    found(&("th,w,u\n".to_owned() + &bare), &["--dt", "0.05"], &["sampling interval 0.05 s", exact]);
    // An angle that goes over the top, folded into one turn.
    let folded: String = rows(0.3, 60, |i| i as f64 * 0.05)
        .lines()
        .map(|row| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            let th: f64 = cells[1].parse().unwrap();
            cells[1] = (th - TAU * (th / TAU).round()).to_string();
            cells.join(",") + "\n"
        })
        .collect();
    found(&(header.to_owned() + &folded), &["--angles", "th"], &["unwrapped at 2 jumps of a whole turn", exact]);
    // Stamps that jitter, taken as even or resampled.
    let jittery = header.to_owned() + &rows(3.0, 60, |i| i as f64 * 0.05 + 0.004 * (i % 3) as f64);
    found(&jittery, &["--dt", "0.05"], &["the time stamps agree except for jitter", exact]);
    found(&jittery, &["--resample", "0.05"], &["resampled every 0.05 s"]);
}

#[test]
fn a_log_may_come_from_standard_input_with_other_cells_and_time() {
    use std::io::Write as _;
    let temp = tempfile::tempdir().unwrap();
    let log = example().replace(',', ";").replacen("t [s];", "seconds [s];", 1).replacen("t;", "seconds;", 1);
    assert!(log.starts_with("seconds"), "{}", &log[..40]);
    let args = [&["identify", "-"], &COLUMNS[..], &["--angles", "th", "--delimiter", ";", "--time-column", "seconds"]];
    let mut process = super::common::command(temp.path(), &args.concat())
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    process.stdin.take().unwrap().write_all(log.as_bytes()).unwrap();
    let (code, stdout, stderr) = parts(&process.wait_with_output().unwrap());
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stdout.contains("log: standard input, 101 rows") && stdout.contains("w\u{307} = 15 sin th + 3 u"),
        "{stdout}"
    );
    assert!(temp.path().join("models/log/model.json").is_file());
}

#[test]
fn logs_of_several_formats_are_one() {
    let temp = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../logs/tests/data");
    for name in ["energy_shaping.csv", "formats/log.npz", "formats/struct.mat", "formats/record.npy"] {
        let path = data.join(name);
        fs::copy(&path, temp.path().join(path.file_name().unwrap())).unwrap();
    }
    let args = ["inspect", "energy_shaping.csv", "log.npz", "struct.mat", "record.npy"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert!(code == 0 && stdout.contains("240 rows in 4 trajectories"), "{stdout}{stderr}");
    let (code, _, stderr) = parts(&sindyna(temp.path(), &["inspect", "log.npz", "--states", "position,speed"]));
    assert!(code == 2 && stderr.contains("log.npz has no column named `speed`"), "{stderr}");
}
