//! Logs of systems that change.

use std::fmt::Write as _;
use std::fs;

use rand::RngExt as _;
use sindyna_core::Seed;

use super::common::{parts, sindyna};

/// 800 rows of v̇ = F − k x − 0.4 v with errors of 0.003, whose stiffness k is another one from row `at` on.
fn log(seed: u64, stiffness: [f64; 2], at: usize) -> String {
    let mut rng = Seed::new(seed).stream("changed", 0);
    let (mut x, mut v, mut force, mut text) = (0.3, 0.0, 0.0, "t,x,v,F\n".to_owned());
    for t in 0..800 {
        if t % 15 == 0 {
            force = rng.random_range(-3.0..3.0);
        }
        let noise: [f64; 2] = std::array::from_fn(|_| (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0);
        writeln!(text, "{},{},{},{force}", 0.02 * t as f64, x + 0.003 * noise[0], v + 0.003 * noise[1]).unwrap();
        for _ in 0..100 {
            v += 2e-4 * (force - stiffness[usize::from(t >= at)] * x - 0.4 * v);
            x += 2e-4 * v;
        }
    }
    text
}

#[test]
fn the_beginning_and_the_end_of_a_log_are_told_apart() {
    let temp = tempfile::tempdir().unwrap();
    for (seed, stiffness, at) in [(0, [4.0, 5.0], 400), (1, [9.0, 8.7], 300), (2, [2.0, 2.0], 400)] {
        fs::write(temp.path().join("log.csv"), log(seed, stiffness, at)).unwrap();
        let (code, stdout, stderr) = parts(&sindyna(temp.path(), &["identify", "log.csv", "--no-report"]));
        assert_eq!(code, 0, "{stderr}");
        let Some(told) = stdout.lines().find(|line| line.contains("the system changed")) else {
            assert!(stiffness[0] == stiffness[1] && stdout.contains("equations: adequate"), "{stdout}");
            continue;
        };
        let of_x: Vec<f64> =
            told.split("v̇ = −").skip(1).map(|rest| rest.split(' ').next().unwrap().parse().unwrap()).collect();
        assert!(of_x.len() == 2 && of_x.iter().zip(stiffness).all(|(k, truth)| (k - truth).abs() < 0.02), "{told}");
    }
}
