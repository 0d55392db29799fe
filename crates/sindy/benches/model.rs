//! Identification from ten steps and steps of the model found, one thread: `cargo bench -p sindyna-sindy`.
//!
//! For a look while working. Figures to be told come from `benches/`, beside peers and in turn with them.

#![allow(clippy::unwrap_used, reason = "systems and data stand right here")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Truth, record, uniform};
use divan::Bencher;
use sindyna_core::{Dataset, Dynamics as _, Rng, Seed, Space};
use sindyna_sindy::Identifier;

const SYSTEMS: [&str; 3] = ["pendulum", "cart-pole", "inverted-pendulum"];

fn main() {
    divan::main();
}

fn system(name: &str) -> Truth {
    match name {
        "pendulum" => common::pendulum(),
        "cart-pole" => common::cart_pole(),
        _ => common::inverted_pendulum(),
    }
}

/// Ten steps, pushed hard to one side and then to the other.
fn rollout(truth: &Truth) -> Dataset {
    let Space::Box { high, .. } = &truth.spec.action_space else { unreachable!("pushes are real numbers") };
    let (n, reach) = (truth.spec.state_dim(), high[0]);
    let start = |rng: &mut Rng| (0..n).map(|_| uniform(rng, -0.01, 0.01)).collect();
    let push =
        |rng: &mut Rng, i: usize| uniform(rng, 0.5, 1.0) * if (i / 4).is_multiple_of(2) { reach } else { -reach };
    record(truth, 0, 10, start, push, |_| false)
}

#[divan::bench(args = SYSTEMS)]
fn identify(bencher: Bencher<'_, '_>, name: &str) {
    let truth = system(name);
    let (data, identifier) = (rollout(&truth), Identifier::new(&truth.spec));
    bencher.bench(|| identifier.identify(&data).unwrap());
}

#[divan::bench(args = SYSTEMS)]
fn step(bencher: Bencher<'_, '_>, name: &str) {
    let truth = system(name);
    let model = Identifier::new(&truth.spec).identify(&rollout(&truth)).unwrap().model;
    let mut rng = Seed::new(0).stream("benchmark", 0);
    let (x, mut next) = (vec![0.01; truth.spec.state_dim()], vec![0.0; truth.spec.state_dim()]);
    bencher.bench_local(|| model.step(divan::black_box(&x), &[0.5], &mut rng, &mut next));
}
