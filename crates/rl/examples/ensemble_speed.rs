//! Training examples per second of an ensemble, one thread, beside `benches/peers/torch_ensemble.py`, and the time of a step:
//! `cargo run --release -p sindyna-rl --example ensemble_speed [paper|janner] [isa]`.
//!
//! An example is a row of one batch, of which every member sees one of its own; what is timed is a whole fit but for its
//! data, with as good as nothing held out. Observation 3, action 1, reward head, batch 256: the pendulum.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::time::Instant;

use ndarray::Array2;
use sindyna_core::Seed;
use sindyna_rl::{EnsembleConfig, EnsembleTrainer, Isa};

const ROWS: usize = 5121;
const EPOCHS: usize = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let preset = arguments.next().unwrap_or_else(|| "paper".into());
    let isa = arguments.next().map_or(Ok(Isa::widest()), |name| name.parse())?;
    let config = match preset.as_str() {
        "paper" => EnsembleConfig::paper(),
        "janner" => EnsembleConfig::janner(),
        other => return Err(format!("no preset named `{other}`; known: `paper`, `janner`").into()),
    };
    let config = EnsembleConfig { max_holdout: 1, patience: EPOCHS, max_epochs: Some(EPOCHS), ..config };
    let wave = |width: usize, phase: f64| {
        Array2::from_shape_fn((ROWS, width), |(i, j)| (1.7 * (i * width + j) as f64 + phase).sin())
    };
    let (inputs, targets) = (wave(4, 0.0), wave(4, 1.0));
    let trainer = EnsembleTrainer::new(config)?.with_isa(isa)?;
    let mut rng = Seed::new(0).stream("benchmark", 0);
    // Weights and buffers are there before the clock starts.
    let start = trainer.fit(inputs.view(), targets.view(), None, &mut rng)?;
    let clock = Instant::now();
    let ensemble = trainer.fit(inputs.view(), targets.view(), Some(&start), &mut rng)?;
    let seconds = clock.elapsed().as_secs_f64();
    let examples = (ensemble.report().training_rows * EPOCHS) as f64 / seconds;
    // Per row and member: forward, weights' and inputs' gradients, where the first layer's inputs need none.
    let widths = [&[4], ensemble.config().hidden.as_slice(), &[8]].concat();
    let products: Vec<usize> = widths.windows(2).map(|w| w[0] * w[1]).collect();
    let flops = 2 * (3 * products.iter().sum::<usize>() - products[0]) * ensemble.config().members;
    println!(
        "{preset}: {examples:.0} examples/s, {:.0} GFLOP/s in products, {} parameters, {isa}",
        examples * flops as f64 / 1e9,
        ensemble.n_parameters()
    );
    let (mut next, row, draws) = ([0.0; 3], [0.1, 0.2, 0.3, 0.4], 20_000);
    let clock = Instant::now();
    (0..draws).for_each(|_| ensemble.sample(&row, &mut rng, &mut next));
    println!("{preset}: {:.1} µs per imagined step", 1e6 * clock.elapsed().as_secs_f64() / f64::from(draws));
    Ok(())
}
