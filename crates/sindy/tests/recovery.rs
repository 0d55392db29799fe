//! Known equations from short rollouts: the support must be exactly the true one.

mod common;

use sindyna_core::Spec;
use sindyna_sindy::{Identified, Identifier};

fn supports(found: &Identified) -> Vec<Vec<String>> {
    let names = |s: &Vec<usize>| s.iter().map(|&j| found.report.features[j].clone()).collect();
    found.report.equations.iter().map(|e| names(&e.support)).collect()
}

/// The seeds of 0..n for which `found` has exactly the terms `expected`, in any order.
fn exact(n: u64, expected: &[&[&str]], find: impl Fn(u64) -> Identified) -> usize {
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    let expected: Vec<Vec<String>> =
        expected.iter().map(|e| sorted(e.iter().map(ToString::to_string).collect())).collect();
    let right = (0..n).filter(|&seed| {
        let found = find(seed);
        let got: Vec<_> = supports(&found).into_iter().map(sorted).collect();
        if got != expected {
            println!("seed {seed}: {}", found.model);
        }
        got == expected
    });
    right.count()
}

fn identify(spec: &Spec, data: &sindyna_core::Dataset) -> Identified {
    Identifier::new(spec).identify(data).expect("enough data")
}

#[test]
fn pendulum_is_found_from_ten_steps() {
    let spec = common::pendulum().spec;
    let terms: [&[&str]; 2] = [&["ω", "sin θ", "u"], &["sin θ", "u"]];
    for steps in [8, 10, 20] {
        let right = exact(40, &terms, |seed| identify(&spec, &common::pendulum_data(seed, steps)));
        assert_eq!(right, 40, "{steps} steps");
    }
}

#[test]
fn mountain_car_is_found_from_twelve_steps() {
    let spec = common::mountain_car().spec;
    let terms: [&[&str]; 2] = [&["v", "u", "cos 3x"], &["u", "cos 3x"]];
    for steps in [12, 20, 50] {
        let right = exact(40, &terms, |seed| identify(&spec, &common::mountain_car_data(seed, steps)));
        assert_eq!(right, 40, "{steps} steps");
    }
}
