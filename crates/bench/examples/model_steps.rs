//! Nanoseconds a step of a learned model takes, one thread, for the model files named, as a JSON line each:
//! `cargo run --release -p sindyna-bench --example model_steps runs/pendulum-seed0/model.json`.
//!
//! `one`: a rollout, where every step waits for the one before. `many`: 256 states side by side, which wait for nobody, one
//! call of `Dynamics::step` each. Medians and least of many short windows.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::hint::black_box;
use std::time::Instant;

use rand::RngExt as _;
use sindyna_core::{Diverged, Dynamics as _, Rng, Seed};
use sindyna_sindy::Model;

const STATES: usize = 256;
const WINDOWS: usize = 1000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args().skip(1) {
        let model = Model::from_json(&std::fs::read_to_string(&path)?)?;
        let mut rng = Seed::new(0).stream("benchmark", 0);
        let (n, k) = (model.states().len(), model.controls().len());
        let mut draw = |count| (0..count).map(|_| rng.random_range(-0.05..0.05)).collect::<Vec<f64>>();
        let (states, inputs) = (draw(STATES * n), draw(STATES * k));
        let one = windows(&mut rng.clone(), |rng| rollout(&model, &states[..n], &inputs, rng))?;
        let many = windows(&mut rng, |rng| side_by_side(&model, &states, &inputs, rng))?;
        let show = |(median, least)| serde_json::json!({ "median_ns": median, "least_ns": least });
        println!("{}", serde_json::json!({ "model": path, "one": show(one), "many": show(many) }));
    }
    Ok(())
}

/// As many steps as there are inputs, each from where the last one led.
fn rollout(model: &Model, start: &[f64], inputs: &[f64], rng: &mut Rng) -> Result<(), Diverged> {
    let (mut x, mut next) = (start.to_vec(), start.to_vec());
    for u in inputs.chunks_exact(model.controls().len()) {
        model.step(&x, u, rng, &mut next)?;
        std::mem::swap(&mut x, &mut next);
    }
    black_box(x);
    Ok(())
}

/// One step from every state.
fn side_by_side(model: &Model, states: &[f64], inputs: &[f64], rng: &mut Rng) -> Result<(), Diverged> {
    let (n, k) = (model.states().len(), model.controls().len());
    let mut next = vec![0.0; states.len()];
    let rows = states.chunks_exact(n).zip(inputs.chunks_exact(k)).zip(next.chunks_exact_mut(n));
    for ((x, u), next) in rows {
        model.step(x, u, rng, next)?;
    }
    black_box(next);
    Ok(())
}

/// Median and least of the nanoseconds per step over many calls of `steps`, which makes [`STATES`] of them.
fn windows(
    rng: &mut Rng,
    steps: impl Fn(&mut Rng) -> Result<(), Diverged>,
) -> Result<(f64, f64), Box<dyn std::error::Error>> {
    let mut seconds = Vec::with_capacity(WINDOWS);
    for _ in 0..WINDOWS {
        let start = Instant::now();
        steps(rng)?;
        seconds.push(start.elapsed().as_secs_f64() * 1e9 / STATES as f64);
    }
    seconds.sort_by(f64::total_cmp);
    Ok((seconds[WINDOWS / 2], seconds[0]))
}
