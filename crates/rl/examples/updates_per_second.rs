//! Updates of SAC per second, at best and over all windows, and the cost of an action, one thread, at two widths, or at the
//! one named: `cargo run --release -p sindyna-rl --example updates_per_second [64|256]`.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::time::{Duration, Instant};

use ndarray::Array2;
use sindyna_core::{Agent, AgentError, Batch, Mode, Rng, Seed};
use sindyna_rl::{Sac, SacConfig, SacDiscrete, Scaling};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut rng = Seed::new(0).stream("benchmark", 0);
    println!("observation 3, action 1, batch 256, one thread; the best of many short windows, and all of them");
    let wanted: Option<usize> = std::env::args().nth(1).map(|w| w.parse()).transpose()?;
    for (width, n_windows, window) in [(64, 1000, 5), (256, 200, 2)] {
        if wanted.is_some_and(|w| w != width) {
            continue;
        }
        let config = SacConfig { hidden: vec![width, width], ..SacConfig::default() };
        let mut sac = Sac::new(config.clone(), Scaling::identity(3), &[-2.0], &[2.0], &mut rng)?;
        let mut numbered = SacDiscrete::new(config, Scaling::identity(3), 2, &mut rng)?;
        let mut batch = Batch::zeros(256, 3, 1);
        batch.observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64).sin());
        batch.next_observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64 + 0.1).sin());
        batch.actions.iter_mut().enumerate().for_each(|(i, v)| *v = 2.0 * (3.0 * i as f64).sin());
        batch.rewards.iter_mut().enumerate().for_each(|(i, v)| *v = (7.0 * i as f64).cos());
        let real = measure(&mut sac, &batch, n_windows, window, &mut rng)?;
        println!("{width}x{width}: {real}");
        batch.actions.mapv_inplace(|a| f64::from(u8::from(a > 0.0)));
        let numbered = measure(&mut numbered, &batch, n_windows, window, &mut rng)?;
        println!("{width}x{width}: {numbered} (two numbered actions)");
    }
    Ok(())
}

fn measure(
    agent: &mut impl Agent,
    batch: &Batch,
    n_windows: u32,
    window: u32,
    rng: &mut Rng,
) -> Result<String, AgentError> {
    let (mut update, mut act, mut all) = (Duration::MAX, Duration::MAX, Duration::ZERO);
    let mut actions = Array2::zeros((256, 1));
    for _ in 0..n_windows {
        let start = Instant::now();
        for _ in 0..window {
            agent.learn(batch, rng)?;
        }
        let elapsed = start.elapsed();
        (update, all) = (update.min(elapsed), all + elapsed);
    }
    for _ in 0..n_windows {
        let start = Instant::now();
        agent.act_batch(batch.observations.view(), Mode::Explore, rng, actions.view_mut());
        act = act.min(start.elapsed());
    }
    let (updates, act) = (f64::from(window) / update.as_secs_f64(), act.as_secs_f64() / 256.0);
    let sustained = f64::from(n_windows * window) / all.as_secs_f64();
    Ok(format!("{updates:.0} updates/s ({sustained:.0} over all), {:.2} µs per action", 1e6 * act))
}
