//! `sindyna export` writes where it may, and nowhere else.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;

use common::{parts, sindyna};

/// A model, as `identify` leaves one.
const MODEL: &str = r#"{"format": 2, "form": "discrete", "dt": 1.0, "states": ["x"], "controls": ["u"], "terms": ["x*(1-x)", "u"],
    "equations": [[{"term": 0, "coefficient": 3.7}, {"term": 1, "coefficient": 0.5}]], "kinematic": [false], "n_features": 2}"#;

/// Exports the model in `directory` to `out`; exit code, stdout and stderr.
fn export(directory: &Path, out: &str) -> (i32, String, String) {
    fs::write(directory.join("model.json"), MODEL).unwrap();
    parts(&sindyna(directory, &["export", "model.json", "--to", "python", "--out", out]))
}

#[test]
fn a_file_that_no_export_wrote_is_never_written_over() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("mine.py"), "print('mine')\n").unwrap();
    fs::write(temp.path().join("model.py"), "print('mine')\n").unwrap();
    let (code, _, stderr) = export(temp.path(), "mine.py");
    assert!(code == 2 && stderr.contains("mine.py exists and is not an export of sindyna"), "{stderr}");
    assert!(stderr.contains("hint: name another file with --out"), "{stderr}");
    assert_eq!(export(temp.path(), "model.json").0, 2);
    assert_eq!(fs::read_to_string(temp.path().join("model.json")).unwrap(), MODEL);
    let (code, _, _) = parts(&sindyna(temp.path(), &["export", "model.json", "--to", "python"]));
    assert!(code == 2, "neither is a model.py of somebody else");
    for name in ["mine.py", "model.py"] {
        assert_eq!(fs::read_to_string(temp.path().join(name)).unwrap(), "print('mine')\n");
    }
    // What it wrote itself it writes again.
    assert_eq!((export(temp.path(), "new.py").0, export(temp.path(), "new.py").0), (0, 0));
}

#[test]
fn standard_output_holds_the_module_and_nothing_else() {
    let temp = tempfile::tempdir().unwrap();
    assert_eq!(export(temp.path(), "new.py").0, 0);
    let module = fs::read_to_string(temp.path().join("new.py")).unwrap();
    assert_eq!(export(temp.path(), "-"), (0, module, String::new()));
    assert!(!temp.path().join("-").exists());
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_stays_what_it_is() {
    use std::os::unix::fs::{FileTypeExt as _, symlink};
    let temp = tempfile::tempdir().unwrap();
    let fifo = temp.path().join("fifo");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    assert_eq!(export(temp.path(), "new.py").0, 0);
    symlink("new.py", temp.path().join("link")).unwrap();
    symlink("nowhere", temp.path().join("dangling")).unwrap();
    for (out, is) in
        [("fifo", "a pipe"), ("link", "a symbolic link"), ("dangling", "a symbolic link"), (".", "a directory")]
    {
        let (code, _, stderr) = export(temp.path(), out);
        assert!(code == 2 && stderr.contains(is) && stderr.contains("not a file"), "{out}: {stderr}");
    }
    assert!(fs::symlink_metadata(&fifo).unwrap().file_type().is_fifo());
    assert!(fs::symlink_metadata(temp.path().join("link")).unwrap().file_type().is_symlink());
}

#[cfg(unix)]
#[test]
fn files_are_as_readable_as_the_umask_says() {
    use std::os::unix::fs::PermissionsExt as _;
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("model.json"), MODEL).unwrap();
    for (mask, mode) in [("077", 0o600), ("027", 0o640), ("002", 0o664)] {
        let script = format!("umask {mask}; exec {} export model.json --to python", env!("CARGO_BIN_EXE_sindyna"));
        let output = std::process::Command::new("sh").current_dir(temp.path()).args(["-c", &script]).output().unwrap();
        assert_eq!(parts(&output).0, 0);
        let permissions = fs::metadata(temp.path().join("model.py")).unwrap().permissions();
        assert_eq!(permissions.mode() & 0o777, mode, "umask {mask}");
    }
}
