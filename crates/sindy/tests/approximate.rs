//! Systems whose equations are no combination of the terms: how good the approximation is.

mod common;

use common::{Truth, uniform};
use sindyna_core::{Dataset, Dynamics as _, Rng, Seed};
use sindyna_sindy::{Identified, Identifier, Target};

/// RMS error of one predicted step over a box, per state, relative to the RMS change of that state in a step.
fn errors(truth: &Truth, found: &Identified, half_widths: [f64; 4], control: fn(&mut Rng) -> f64) -> [f64; 4] {
    let mut rng = Seed::new(7).stream("test", 0);
    let (mut wrong, mut change) = ([0.0; 4], [0.0; 4]);
    for _ in 0..500 {
        let x = half_widths.map(|w| uniform(&mut rng, -w, w));
        let u = [control(&mut rng)];
        let next = (truth.step)(&x, &u);
        let mut predicted = [0.0; 4];
        found.model.step(&x, &u, &mut rng, &mut predicted).expect("finite");
        for i in 0..4 {
            wrong[i] += (predicted[i] - next[i]).powi(2);
            change[i] += (next[i] - x[i]).powi(2);
        }
    }
    std::array::from_fn(|i| (wrong[i] / change[i]).sqrt())
}

/// The median and the largest error of each state over the seeds 0..n.
fn spread(n: u64, find: impl Fn(u64) -> [f64; 4]) -> [(f64, f64); 4] {
    let all: Vec<[f64; 4]> = (0..n).map(find).collect();
    std::array::from_fn(|i| {
        let mut of: Vec<f64> = all.iter().map(|e| e[i]).collect();
        of.sort_by(f64::total_cmp);
        (of[of.len() / 2], of[of.len() - 1])
    })
}

/// Median and largest error must be below the `bounds`.
fn check(spread: &[(f64, f64); 4], bounds: [(f64, f64); 4]) {
    for (got, bound) in spread.iter().zip(bounds) {
        assert!(got.0 < bound.0 && got.1 < bound.1, "{got:?} is not within {bound:?}");
    }
}

fn identify(truth: &Truth, data: &Dataset) -> Identified {
    Identifier::new(&truth.spec).with_target(Target::Increment).identify(data).expect("enough data")
}

#[test]
fn inverted_pendulum_from_thirty_steps_predicts_within_a_few_percent() {
    let truth = common::inverted_pendulum();
    let spread = spread(40, |seed| {
        let found = identify(&truth, &common::inverted_pendulum_data(seed, 30));
        errors(&truth, &found, [1.0, 0.2, 2.0, 2.0], |rng| uniform(rng, -3.0, 3.0))
    });
    // The rare large error: v and ω are nearly proportional along a rollout, and one stands for the other.
    check(&spread, [(0.01, 0.02), (0.01, 0.02), (0.02, 0.05), (0.02, 0.2)]);
}

#[test]
fn cart_pole_from_thirty_steps_predicts_within_a_thousandth() {
    let truth = common::cart_pole();
    let spread = spread(40, |seed| {
        let found = identify(&truth, &common::cart_pole_data(seed, 30));
        errors(&truth, &found, [2.4, 2.0, 0.21, 2.0], |rng| 10.0 * uniform(rng, -1.0, 1.0).signum())
    });
    check(&spread, [(1e-7, 1e-6), (1e-4, 3e-3), (1e-7, 1e-6), (3e-4, 3e-3)]);
}
