//! Updates of SAC and steps of an ensemble, one thread: `cargo bench -p sindyna-rl`.
//!
//! For a look while working. Figures to be told come from `benches/`, beside peers and in turn with them.

#![allow(clippy::unwrap_used, reason = "sizes and settings stand right here")]

use divan::Bencher;
use ndarray::Array2;
use sindyna_core::{Batch, Rng, Seed};
use sindyna_rl::{EnsembleConfig, EnsembleTrainer, Sac, SacConfig, Scaling};

fn main() {
    divan::main();
}

fn rng() -> Rng {
    Seed::new(0).stream("benchmark", 0)
}

fn wave(rows: usize, columns: usize, phase: f64) -> Array2<f64> {
    Array2::from_shape_fn((rows, columns), |(i, j)| (1.7 * (i * columns + j) as f64 + phase).sin())
}

fn batch(rows: usize) -> Batch {
    let (observations, next_observations) = (wave(rows, 3, 0.0), wave(rows, 3, 0.1));
    Batch { observations, next_observations, actions: wave(rows, 1, 0.2), ..Batch::zeros(rows, 3, 1) }
}

/// An update of SAC: width of both hidden layers, batch.
#[divan::bench(args = [(64, 128), (64, 256), (256, 128), (256, 256)])]
fn update(bencher: Bencher<'_, '_>, (width, rows): (usize, usize)) {
    let config = SacConfig { hidden: vec![width; 2], ..SacConfig::default() };
    let mut rng = rng();
    let mut sac = Sac::new(config, Scaling::identity(3), &[-2.0], &[2.0], &mut rng).unwrap();
    let batch = batch(rows);
    bencher.bench_local(|| sac.update(&batch, &mut rng).unwrap());
}

/// One step of every member on 256 rows, as a fit that ends after it.
#[divan::bench(args = ["paper", "janner"])]
fn ensemble_step(bencher: Bencher<'_, '_>, preset: &str) {
    let config = if preset == "paper" { EnsembleConfig::paper() } else { EnsembleConfig::janner() };
    let config = EnsembleConfig { max_holdout: 1, max_epochs: Some(1), ..config };
    let trainer = EnsembleTrainer::new(config).unwrap();
    let (inputs, targets, mut rng) = (wave(257, 4, 0.0), wave(257, 4, 1.0), rng());
    let start = trainer.fit(inputs.view(), targets.view(), None, &mut rng).unwrap();
    bencher.bench_local(|| trainer.fit(inputs.view(), targets.view(), Some(&start), &mut rng).unwrap());
}
