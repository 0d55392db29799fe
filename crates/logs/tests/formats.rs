//! A log is the same in every format, and what no format allows is refused with its reason.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::PathBuf;

use sindyna_logs::{Log, LogError, LogOptions, Note};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn read(name: &str, options: &LogOptions) -> Result<Log, LogError> {
    Log::read(data("formats").join(name), options)
}

/// Reads `name` and compares it with the text it was made of, to the bit.
fn check(name: &str, options: &LogOptions) {
    let text = Log::read(data("energy_shaping.csv"), &LogOptions::default()).unwrap();
    let log = read(name, options).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!((log.rows, log.data.n_steps()), (text.rows, text.data.n_steps()), "{name}");
    let values = |log: &Log| -> Vec<u64> {
        log.data
            .rollouts()
            .flat_map(|r| [r.observations.to_owned(), r.controls.to_owned()])
            .flatten()
            .map(f64::to_bits)
            .collect()
    };
    assert_eq!(values(&log), values(&text), "{name}");
    assert!((log.spec.dt - text.spec.dt).abs() < 1e-9, "{name}: {}", log.spec.dt);
    let kinds = |log: &Log| log.spec.state.iter().map(|s| s.kind).collect::<Vec<_>>();
    assert_eq!((kinds(&log), log.spec.precision), (kinds(&text), text.spec.precision), "{name}");
    let decided =
        |log: &Log| log.notes.iter().filter(|n| matches!(n, Note::Lattice { .. } | Note::Gaps { .. })).count();
    assert_eq!(decided(&log), decided(&text), "{name}: {:?}", log.notes);
}

fn check_refused(name: &str, options: &LogOptions, says: &[&str]) {
    let failure = read(name, options).map(drop).unwrap_err().to_string();
    assert!(failure.contains(name), "{failure}");
    assert!(says.iter().all(|says| failure.contains(says)), "{name}: {failure}");
}

/// The names of the columns where they are not those of the text.
fn named(states: [&str; 2], input: &str) -> LogOptions {
    LogOptions::new(states).with_inputs([input])
}

#[test]
fn arrays_of_numpy_and_matlab_are_the_log_they_were_made_of() {
    for name in ["log.npz", "packed.npz", "short-input.npz", "big-endian.npz", "record.npy", "log.mat", "struct.mat"] {
        check(name, &LogOptions::default());
    }
    check("across.npz", &named(["q1", "q2"], "u"));
    let columns = LogOptions { time: Some("matrix1".into()), ..named(["matrix2", "matrix3"], "matrix4") };
    check("matrix.npy", &columns);
    let notes: Vec<String> =
        read("struct.mat", &LogOptions::default()).unwrap().notes.iter().map(ToString::to_string).collect();
    assert!(notes.contains(&"left out: `note` is text, `fs` is one number".to_owned()), "{notes:?}");
}

#[test]
fn what_is_no_table_is_refused_with_its_reason() {
    let options = LogOptions::default();
    check_refused("objects.npy", &options, &["pickled objects, which may run code"]);
    check_refused("objects.npz", &options, &["`a` cannot be read: it holds pickled objects"]);
    check_refused("huge.npy", &options, &["16 bytes of data where its header declares 8000000000000"]);
    check_refused("empty.npz", &options, &["without arrays of NumPy"]);
    check_refused("deep.npz", &options, &["`q` has 3 dimensions", "`fs` is one number"]);
    check_refused("no-archive.npz", &options, &["it does not begin like one"]);
    check_refused("nan.npz", &options, &["row 1: column `position`: an empty cell is not a number"]);
    check_refused("infinite.npz", &options, &["row 8: column `velocity`: `inf` is not a finite number"]);
    let speed = LogOptions::new(["position", "speed"]);
    check_refused("log.npz", &speed, &["no column named `speed`; known: `time`, `position`"]);
    let robot = LogOptions::new(["position"]).with_inputs(["fs"]);
    check_refused("log.npz", &robot, &["`fs` of", "is not a column: is one number"]);
}

/// Beginnings of files and files of which bytes were changed are read or refused; nothing else happens.
#[test]
fn damaged_files_are_read_or_refused() {
    let mut files = vec!["record.npy", "packed.npz", "log.npz", "log.mat", "struct.mat"];
    if cfg!(feature = "mcap") {
        files.extend(["joints.mcap", "joints-lz4.mcap", "state.mcap"]);
    }
    if cfg!(feature = "parquet") {
        files.extend(["log.parquet", "lists.parquet"]);
    }
    if cfg!(feature = "hdf5") {
        files.extend(["v73.mat", "log.h5"]);
    }
    let (mut read, mut refused) = (0, 0);
    let mut look = |bytes: &[u8]| match Log::read_from("log", bytes, &LogOptions::default()) {
        Ok(_) => read += 1,
        Err(_) => refused += 1,
    };
    // Any numbers do; these are the same everywhere.
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for name in files {
        let whole = std::fs::read(data("formats").join(name)).unwrap();
        (0..60).for_each(|i| look(&whole[..i * whole.len() / 60]));
        for _ in 0..400 {
            let mut bytes = whole.clone();
            for _ in 0..=next(3) {
                let at = next(bytes.len());
                bytes[at] = [0, 0xff, 0x7f, 0x80, next(256) as u8][next(5)];
            }
            look(&bytes);
        }
    }
    assert!(read > 100 && refused > 100, "{read} read, {refused} refused");
}

#[cfg(not(feature = "mcap"))]
#[test]
fn a_build_without_a_format_says_so() {
    check_refused("joints.mcap", &LogOptions::default(), &["MCAP, which this build does not read (feature `mcap`)"]);
}

#[cfg(feature = "mcap")]
#[test]
fn topics_of_ros_are_logs() {
    let joints = named(["position_rod", "velocity_rod"], "effort_rod");
    for name in ["joints.mcap", "joints-lz4.mcap"] {
        check(name, &joints);
        check(name, &LogOptions::default());
    }
    // By the clock of who recorded it, in nanoseconds since 1970.
    check("state.mcap", &LogOptions::default());
    check("joints.mcap", &LogOptions { time: Some("log_time".into()), ..joints.clone() });
    check_refused("both.mcap", &joints, &["several topics: `/joint_states`, `/state`"]);
    check("both.mcap", &LogOptions { topic: Some("/joint_states".into()), ..joints.clone() });
    let missing = LogOptions { topic: Some("/joints".into()), ..joints.clone() };
    check_refused("both.mcap", &missing, &["no topic `/joints` that can be read; known: `/joint_states`, `/state`"]);
    check_refused("chatter.mcap", &joints, &["`/chatter` has std_msgs/msg/String in cdr"]);
}

#[cfg(feature = "parquet")]
#[test]
fn columns_of_parquet_are_a_log() {
    check("log.parquet", &LogOptions::default());
    check("lists.parquet", &named(["q1", "q2"], "u"));
}

#[cfg(feature = "hdf5")]
#[test]
fn data_sets_of_hdf5_are_a_log() {
    check("v73.mat", &LogOptions::default());
    check("log.h5", &LogOptions::default());
}
