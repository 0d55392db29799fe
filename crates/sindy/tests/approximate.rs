//! Systems whose equations are no combination of the terms: how good the approximation is.

mod common;

use sindyna_core::{Dynamics as _, Seed};
use sindyna_sindy::{Identified, Identifier};

/// RMS error of one predicted step over a box, per state, relative to the RMS change of that state in a step.
fn errors(
    truth: &common::Truth,
    found: &Identified,
    half_widths: [f64; 4],
    control: fn(&mut sindyna_core::Rng) -> f64,
) -> Vec<f64> {
    let mut rng = Seed::new(7).stream("test", 0);
    let (mut wrong, mut change) = (vec![0.0; 4], vec![0.0; 4]);
    for _ in 0..500 {
        let x = half_widths.map(|w| common::uniform(&mut rng, -w, w));
        let u = [control(&mut rng)];
        let next = (truth.step)(&x, &u);
        let mut predicted = [0.0; 4];
        found.model.step(&x, &u, &mut rng, &mut predicted).expect("finite");
        for i in 0..4 {
            wrong[i] += (predicted[i] - next[i]).powi(2);
            change[i] += (next[i] - x[i]).powi(2);
        }
    }
    wrong.iter().zip(&change).map(|(w, c)| (w / c).sqrt()).collect()
}

#[test]
fn inverted_pendulum_from_thirty_steps_predicts_within_a_few_percent() {
    let truth = common::inverted_pendulum();
    for seed in 0..20 {
        let t = std::time::Instant::now();
        let found = Identifier::new(&truth.spec).identify(&common::inverted_pendulum_data(seed, 30)).expect("rows");
        let t = t.elapsed();
        let errors = errors(&truth, &found, [1.0, 0.2, 2.0, 2.0], |rng| common::uniform(rng, -3.0, 3.0));
        println!("{t:?} {}", errors.iter().map(|e| format!("{e:.1e}")).collect::<Vec<_>>().join(" "));
        if seed < 3 {
            println!("{}", found.model);
        }
    }
}

#[test]
fn cart_pole_from_thirty_steps_predicts_within_a_thousandth() {
    let truth = common::cart_pole();
    for seed in 0..20 {
        let t = std::time::Instant::now();
        let found = Identifier::new(&truth.spec).identify(&common::cart_pole_data(seed, 30)).expect("rows");
        let t = t.elapsed();
        let errors =
            errors(&truth, &found, [2.4, 2.0, 0.21, 2.0], |rng| 10.0 * common::uniform(rng, -1.0, 1.0).signum());
        println!("{t:?} {}", errors.iter().map(|e| format!("{e:.1e}")).collect::<Vec<_>>().join(" "));
        if seed < 3 {
            println!("{}", found.model);
        }
    }
}
