//! How the cost of an update of SAC grows with the width of its networks and with its batch, one thread, a JSON line each:
//! `cargo run --release -p sindyna-rl --example cost_of_update [rounds]`.
//!
//! All sizes are measured in turn, and medians of the rounds are printed.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::time::Instant;

use sindyna_core::{Batch, Seed};
use sindyna_rl::{Sac, SacConfig, Scaling};

/// Hidden width and batch: widths at one batch, then batches at one width.
const SIZES: [(usize, usize); 11] = [
    (16, 128),
    (32, 128),
    (64, 128),
    (128, 128),
    (256, 128),
    (512, 128),
    (64, 32),
    (64, 64),
    (64, 256),
    (64, 512),
    (64, 1024),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rounds: usize = std::env::args().nth(1).map_or(Ok(50), |n| n.parse())?;
    let mut rng = Seed::new(0).stream("benchmark", 0);
    let mut cases = Vec::new();
    for (width, rows) in SIZES {
        let config = SacConfig { hidden: vec![width, width], ..SacConfig::default() };
        let agent = Sac::new(config, Scaling::identity(3), &[-2.0], &[2.0], &mut rng)?;
        let mut batch = Batch::zeros(rows, 3, 1);
        batch.observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64).sin());
        batch.next_observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64 + 0.1).sin());
        batch.actions.iter_mut().enumerate().for_each(|(i, v)| *v = 2.0 * (3.0 * i as f64).sin());
        batch.rewards.iter_mut().enumerate().for_each(|(i, v)| *v = (7.0 * i as f64).cos());
        cases.push((width, rows, agent, batch, Vec::with_capacity(rounds)));
    }
    for _ in 0..=rounds {
        for (_, _, agent, batch, seconds) in &mut cases {
            let start = Instant::now();
            agent.update(batch, &mut rng)?;
            seconds.push(start.elapsed().as_secs_f64());
        }
    }
    for (width, batch, _, _, mut seconds) in cases {
        // The first update allocates.
        seconds.remove(0);
        seconds.sort_by(f64::total_cmp);
        let microseconds = 1e6 * seconds[seconds.len() / 2];
        println!("{{\"width\": {width}, \"batch\": {batch}, \"microseconds\": {microseconds:.2}}}");
    }
    Ok(())
}
