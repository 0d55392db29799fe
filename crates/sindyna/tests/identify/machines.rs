//! Logs as machines write them.

use std::fmt::Write as _;
use std::fs;

use rand::RngExt as _;
use sindyna_core::Seed;

use super::common::{json, parts, sindyna};

const DT: f64 = 0.01;

/// Rates of a cart of 1 kg, with friction, that carries a pole of 0.2 kg and 0.5 m under a force: of place, angle and their rates.
fn cart_pole([_, th, v, w]: [f64; 4], force: f64) -> [f64; 4] {
    let (sin, cos) = th.sin_cos();
    let (force, total, heavy) = (force - 0.3 * v, 1.2, 1.0 + 0.2 * sin * sin);
    let a = (force + 0.2 * sin * (0.5 * w * w - 9.81 * cos)) / heavy;
    let b = (-force * cos - 0.1 * w * w * cos * sin + total * 9.81 * sin) / (0.5 * heavy);
    [v, w, a, b]
}

/// Its log: angles in degrees, 0.5 % noise on every state, stamps that jitter, a force that acts four rows late.
fn log(rows: usize) -> String {
    const LATE: usize = 4;
    let mut rng = Seed::new(7).stream("log", 0);
    let mut random = || 2.0 * rng.random::<f64>() - 1.0;
    let levels: Vec<f64> = (0..=rows / 10).map(|_| 4.0 * random()).collect();
    let times: Vec<f64> = (0..rows).map(|i| DT * (i as f64 + 0.2 * random())).collect();
    let mut states = vec![[0.0, 3.0, 0.0, 0.0]];
    for i in 0..rows - 1 {
        let u = if i < LATE { 0.0 } else { levels[(i - LATE) / 10] };
        let h = (times[i + 1] - times[i]) / 20.0;
        let mut x = states[i];
        for _ in 0..20 {
            let moved = |by: f64, k: [f64; 4]| std::array::from_fn(|j| x[j] + by * k[j]);
            let k1 = cart_pole(x, u);
            let k2 = cart_pole(moved(0.5 * h, k1), u);
            let k3 = cart_pole(moved(0.5 * h, k2), u);
            let k4 = cart_pole(moved(h, k3), u);
            x = std::array::from_fn(|j| x[j] + h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]));
        }
        states.push(x);
    }
    let spread: [f64; 4] = std::array::from_fn(|j| {
        let mean = states.iter().map(|x| x[j]).sum::<f64>() / rows as f64;
        (states.iter().map(|x| (x[j] - mean).powi(2)).sum::<f64>() / rows as f64).sqrt()
    });
    let mut text = "t,x (m),theta (deg),v (m/s),omega (deg/s),force (N)\n".to_owned();
    for (i, x) in states.iter().enumerate() {
        // The sum of twelve uniform numbers, each of variance 1/3, has a deviation of 2.
        let mut shown = |j: usize| x[j] + 0.005 * spread[j] * 0.5 * (0..12).map(|_| random()).sum::<f64>();
        let [x, th, v, w] = std::array::from_fn(&mut shown);
        let (th, w, u) = (th.to_degrees(), w.to_degrees(), levels[i / 10]);
        writeln!(text, "{:.6},{x:.5},{th:.4},{v:.5},{w:.4},{u:.5}", times[i]).unwrap();
    }
    text
}

#[test]
fn a_cart_and_pole_in_degrees_late_and_at_uneven_times_is_found() {
    let temp = tempfile::tempdir().unwrap();
    fs::write(temp.path().join("log.csv"), log(700)).unwrap();
    let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--no-report"]));
    assert_eq!(code, 0, "{stdout}{stderr}");
    for says in [
        "v is used as the rate of x",
        "theta is used as an angle, as its name or unit says",
        "delay of the inputs: 4 rows",
    ] {
        assert!(stdout.contains(says), "{says}: {stdout}");
    }
    let account = json(&temp.path().join("models/log/identify.json"));
    let expected = [
        ("v", &[("v", -0.25), ("sin", 0.1 / 1.2), ("cos", -0.1 / 1.2), ("force", 1.0 / 1.2)][..]),
        ("omega", &[("sin", 9.81 / 0.5), ("cos", -2.0)]),
    ];
    for (state, terms) in expected {
        let equations = account["equations"].as_array().unwrap();
        let found = equations.iter().find(|e| e["state"] == state).unwrap()["terms"].as_array().unwrap();
        assert_eq!(found.len(), terms.len(), "{found:?}");
        for (name, truth) in terms {
            let is_it = |term: &&serde_json::Value| {
                let own = term["term"].as_str().unwrap();
                own == *name || own.contains(&format!("{name} theta"))
            };
            let coefficient = found.iter().find(is_it).unwrap()["coefficient"].as_f64().unwrap();
            assert!((coefficient / truth - 1.0).abs() < 0.02, "{state}: {name} {coefficient}, not {truth}");
        }
    }
}
