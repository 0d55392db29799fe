//! Logs that are inspected, and logs that are held out.

use std::fs;

use super::common::{json, parts, sindyna};
use super::{at_uneven_times, reordered};

#[test]
fn a_log_is_inspected_before_anything_is_identified() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), "time,th,w,u\n".to_owned() + &at_uneven_times(2.0, 150)).unwrap();
    let args = ["inspect", "log.csv", "--angles", "th", "--report", "log.html", "--json"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stderr}");
    let told: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let told = &told["result"];
    assert_eq!(told["rows"], 150);
    for (step, truth) in [("shortest", 0.02), ("longest", 0.023)] {
        assert!((told["step"][step].as_f64().unwrap() - truth).abs() < 1e-9, "{told}");
    }
    let response = &told["responses"][0];
    assert!(
        response["state"] == "w"
            && response["delay"].as_f64() == Some(0.0)
            && response["correlation"].as_f64().unwrap() > 0.95,
        "{told}"
    );
    assert!(fs::read_to_string(temp.path().join("log.html")).unwrap().contains("th [rad] against time"));
    let (code, stdout, _) = parts(&sindyna(temp.path(), &args));
    assert!(code == 2 && stdout.contains("log.html exists already"), "{stdout}");
}

#[test]
fn another_log_is_held_out_and_predicted_in_windows() {
    let temp = tempfile::tempdir().unwrap();
    let header = "time,th,w,u\n".to_owned();
    fs::write(temp.path().join("a.csv"), header.clone() + &at_uneven_times(2.0, 150)).unwrap();
    fs::write(temp.path().join("b.csv"), reordered(&(header.clone() + &at_uneven_times(-1.0, 150)))).unwrap();
    let args = ["identify", "a.csv", "--angles", "th", "--out"];
    let alone = parts(&sindyna(temp.path(), &[&args[..], &["alone"]].concat()));
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &[&args[..], &["model", "--holdout", "b.csv"]].concat()));
    assert_eq!((code, alone.0), (0, 0), "{stderr}");
    let bytes = |dir: &str| fs::read(temp.path().join(dir).join("model.json")).unwrap();
    assert_eq!(bytes("model"), bytes("alone"), "what is held out changes nothing");
    assert!(stdout.contains("held out: 149 steps of b.csv"), "{stdout}");
    let held_out = &json(&temp.path().join("model/identify.json"))["held_out"];
    assert_eq!(held_out["logs"][0], "b.csv");
    let predictions = held_out["predictions"].as_array().unwrap();
    let seconds: Vec<Option<f64>> = predictions.iter().map(|p| p["seconds"].as_f64()).collect();
    assert_eq!(seconds, [None, None, Some(0.5), Some(1.0), None]);
    for ahead in predictions {
        assert_eq!(ahead["diverged"], 0);
        for i in [0, 1] {
            let fit = ahead["fit_percent"][i][1].as_f64().unwrap();
            let (rmse, median) = (ahead["rmse"][i][1].as_f64().unwrap(), ahead["median_rmse"][i][1].as_f64().unwrap());
            assert!(fit > 99.9 && rmse < 1e-3 && median < 1e-3, "{ahead}");
        }
    }
    // One step: a window for each.
    assert_eq!((&predictions[0]["windows"], &predictions[4]["windows"]), (&149.into(), &1.into()));
    let missing = header.replace("w,u", "v,u") + &at_uneven_times(0.3, 20);
    fs::write(temp.path().join("c.csv"), missing).unwrap();
    let (code, _, stderr) = parts(&sindyna(temp.path(), &[&args[..], &["none", "--holdout", "c.csv"]].concat()));
    assert!(code == 2 && stderr.contains("c.csv has no column named `w`"), "{stderr}");
    let (code, _, stderr) =
        parts(&sindyna(temp.path(), &[&args[..], &["none", "--holdout", "b.csv", "--holdout", "0.2"]].concat()));
    assert!(code == 2 && stderr.contains("one share or other logs"), "{stderr}");
}

#[test]
fn a_model_that_diverges_on_another_log_is_said_to() {
    let temp = tempfile::tempdir().unwrap();
    // ẋ = x² from −2 on comes to rest; from 2 on it is gone in half a second.
    let row = |x: f64, i: usize| format!("{},{x}\n", 0.02 * i as f64);
    let falling: String = (0..100).map(|i| row(-1.0 / (0.5 + 0.02 * i as f64), i)).collect();
    let standing: String = (0..100).map(|i| row(2.0, i)).collect();
    fs::write(temp.path().join("a.csv"), "t,x\n".to_owned() + &falling).unwrap();
    fs::write(temp.path().join("b.csv"), "t,x\n".to_owned() + &standing).unwrap();
    let args = ["identify", "a.csv", "--holdout", "b.csv", "--out", "model"];
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &args));
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("the model diverges in") && stdout.contains("the first from 0 s on"), "{stdout}");
    let held_out = &json(&temp.path().join("model/identify.json"))["held_out"]["predictions"];
    let second = held_out.as_array().unwrap().iter().find(|p| p["seconds"] == 1.0).unwrap();
    assert_eq!(second["diverged"], second["windows"]);
    assert!(second["rmse"][0][1].is_null() && second["median_rmse"][0][1].is_null(), "{second}");
    assert_eq!(held_out[0]["diverged"], 0);
}
