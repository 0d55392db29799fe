//! Candidates that are not defined on the whole way of a model.

use super::{json, parts, sindyna};

/// A car that begins at x = 0, of which noise alone makes all samples positive, so that √x and log x are candidates: they are not defined where the path of a model is negative, and nothing was
/// compared with `−2.6 steer + 0.39 speed·steer + 2.5 tan steer`.
#[test]
fn a_root_of_what_noise_keeps_positive_leaves_the_others_to_be_compared() {
    let temp = tempfile::tempdir().unwrap();
    let log = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/car.csv");
    let columns = ["--states", "pos_x,pos_y,heading,speed", "--inputs", "steer,accel_cmd"];
    let (code, stdout, stderr) =
        parts(&sindyna(temp.path(), &[&["identify", log, "--no-report", "--out", "car"], &columns[..]].concat()));
    assert_eq!(code, 0, "{stdout}{stderr}");
    let account = json(&temp.path().join("car/identify.json"));
    let expected = [
        vec![("speed·cos heading", 1.0)],
        vec![("speed·sin heading", 1.0)],
        vec![("speed·tan steer", 1.0 / 2.7)],
        vec![("speed", -0.02), ("accel_cmd", 1.0)],
    ];
    for (i, expected) in expected.iter().enumerate() {
        let terms = account["equations"][i]["terms"].as_array().unwrap();
        assert_eq!(terms.len(), expected.len(), "{stdout}");
        for (name, truth) in expected {
            let term = terms.iter().find(|t| t["term"] == *name).unwrap_or_else(|| panic!("{name}: {stdout}"));
            let (found, error) = (term["coefficient"].as_f64().unwrap(), term["standard_error"].as_f64().unwrap());
            assert!((found - truth).abs() < 4.0 * error, "{name}: {found} ± {error}");
        }
    }
}
