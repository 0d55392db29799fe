//! Pieces of logs of real machines are read as they are.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::PathBuf;

use sindyna_core::Kind;
use sindyna_logs::{Log, LogOptions, Note, held_out};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

#[test]
fn a_pendulum_is_read_with_nothing_but_its_name() {
    let log = Log::read(data("energy_shaping.csv"), &LogOptions::default()).unwrap();
    let names: Vec<&str> = log.spec.state.iter().chain(&log.spec.control).map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["position", "velocity", "torque"]);
    assert_eq!((log.rows, log.data.n_rollouts(), log.data.n_steps()), (60, 1, 59));
    assert!((log.spec.dt - 0.005).abs() < 1e-6, "{}", log.spec.dt);
    let told: Vec<String> = log.notes.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|n| n == "time: column time, in seconds"), "{told:?}");
    assert!(told.iter().any(|n| n.contains("states position, velocity; inputs torque")), "{told:?}");
}

#[test]
fn a_gap_begins_another_trajectory_and_jitter_stays() {
    let log = Log::read(data("sac.csv"), &LogOptions::default()).unwrap();
    let gap = log
        .notes
        .iter()
        .find_map(|n| if let Note::Gaps { longest, row, .. } = n { Some((*longest, row.row.number)) } else { None });
    assert!(gap.is_some_and(|(longest, line)| (longest - 0.022).abs() < 1e-3 && line == 3), "{gap:?}");
    assert_eq!((log.data.n_rollouts(), log.data.n_steps()), (1, 38), "the one row before the gap has no step");
    let whole = Log::read(data("sac.csv"), &LogOptions { gap: Some(f64::INFINITY), ..LogOptions::default() }).unwrap();
    assert_eq!(whole.data.n_steps(), 39);
    let times = &whole.times.as_ref().unwrap()[0];
    assert_eq!((times[0], times[1]), (0.0, 0.022_057_294_845_581_055));
    let (first, last) = held_out(&whole, 0.25).unwrap();
    assert_eq!((first.data.n_steps(), last.data.n_steps()), (29, 10));
    assert_eq!(last.times.unwrap()[0][3], times[32] - times[29]);
}

#[test]
fn several_logs_are_trajectories_of_one_machine() {
    let options =
        LogOptions::new(["pos_meas1", "pos_meas2", "vel_meas1", "vel_meas2"]).with_inputs(["tau_meas1", "tau_meas2"]);
    let one = Log::read(data("c1_143601.csv"), &options).unwrap();
    assert!(one.times.is_none() && one.data.n_rollouts() == 1, "these 60 rows are evenly spaced");
    let two = Log::read_all(&[data("c1_143601.csv"), data("c1_143601.csv")], &options).unwrap();
    assert_eq!((two.rows, two.data.n_rollouts()), (2 * one.rows, 2));
    let rates: Vec<Kind> = two.spec.state.iter().map(|s| s.kind).collect();
    assert_eq!(rates[2..], [Kind::RateOf(0), Kind::RateOf(1)]);
    let other = Log::read_all(&[data("c1_143601.csv"), data("sac.csv")], &options).unwrap_err().to_string();
    assert!(other.contains("sac.csv has no column named `pos_meas1`"), "{other}");
}

#[test]
fn encoders_show_their_lattice_and_continuous_angles_their_turns() {
    let log = Log::read(data("energy_shaping.csv"), &LogOptions::default()).unwrap();
    let step = |state: &str| {
        log.notes.iter().find_map(|n| match n {
            Note::Lattice { state: s, step } if s == state => Some(*step),
            _ => None,
        })
    };
    // Positions of ±95.5 rad in 16 bits, velocities of ±45 rad/s in 12.
    assert!(step("position").is_some_and(|s| (s / (191.0 / 65535.0) - 1.0).abs() < 1e-4), "{:?}", step("position"));
    assert!(step("velocity").is_some_and(|s| (s / (90.0 / 4095.0) - 1.0).abs() < 1e-4), "{:?}", step("velocity"));
    let turning = "t,th [deg],w [deg/s],u\n".to_owned()
        + &(0..50).map(|i| format!("{},{},{},0\n", 0.1 * f64::from(i), 9.37 * f64::from(i), 93.7)).collect::<String>();
    let log = Log::parse("turning.csv", turning, &LogOptions::default()).unwrap();
    let notes: Vec<String> = log.notes.iter().map(ToString::to_string).collect();
    for says in [
        "th is converted from deg to radians",
        "th spans 1.3 turns and is used as an angle",
        "w is used as the rate of th",
    ] {
        assert!(notes.iter().any(|n| n.contains(says)), "{says:?} is missing in {notes:?}");
    }
    let last = log.data.rollouts().next().unwrap().observations[[49, 0]];
    assert!((last - (9.37 * 49.0_f64).to_radians()).abs() < 1e-12 && log.spec.state[0].unit == "rad");
}

#[test]
fn missing_values_are_borders() {
    let row = |i: usize, x: &str, u: &str| format!("{};{x};{u}\n", i as f64 * 0.1).replace('.', ",");
    let rows: String = (0..20)
        .map(|i| {
            let (x, u) = (format!("{}", (i as f64 * 0.3).sin()), "1.5");
            match i {
                7 => row(i, "NaN", u),
                13 => row(i, &x, ""),
                _ => row(i, &x, u),
            }
        })
        .collect();
    let options = LogOptions::new(["x"]).with_inputs(["u"]);
    let log = Log::parse("log.csv", format!("t;x;u\n{rows}"), &options).unwrap();
    let lengths: Vec<usize> = log.data.rollouts().map(|r| r.observations.nrows()).collect();
    assert_eq!(lengths, [7, 6, 6]);
    let notes: Vec<String> = log.notes.iter().map(ToString::to_string).collect();
    for says in ["cells are separated by `;`, decimals by a comma", "2 rows with a missing value (first: x in line 9)"]
    {
        assert!(notes.iter().any(|n| n.contains(says)), "{says:?} is missing in {notes:?}");
    }
    let nothing = Log::parse("log.csv", "t;x;u\n0;;1\n1;;1\n".into(), &options).unwrap_err().to_string();
    assert!(nothing.contains("line 2: column `x`: an empty cell is not a number"), "{nothing}");
}
