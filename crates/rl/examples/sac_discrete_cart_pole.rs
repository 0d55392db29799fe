//! SAC for numbered actions on the true cart-pole, without any model, for the seeds named or else 0 to 9:
//! `cargo run --release -p sindyna-rl --example sac_discrete_cart_pole [SEED...]`.
//!
//! Every run takes the same number of steps, one update after each, and is judged by the policy it ends with: nothing is
//! selected. One thread.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::time::Instant;

use rand::RngExt as _;
use sindyna_core::{Batch, Environment as _, Mode, Policy as _, Replay, Seed, Transition};
use sindyna_dyna::evaluate;
use sindyna_rl::{SacConfig, SacDiscrete, Scaling};

const STEPS: usize = 20_000;
const RANDOM_STEPS: usize = 1_000;
const EPISODES: usize = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut seeds: Vec<u64> = std::env::args().skip(1).map(|s| s.parse()).collect::<Result<_, _>>()?;
    if seeds.is_empty() {
        seeds = (0..10).collect();
    }
    println!("| seed | steps | mean of {EPISODES} episodes | worst | temperature | time |\n|---|---|---|---|---|---|");
    let mut solved = 0;
    for seed in &seeds {
        let start = Instant::now();
        let run = train(Seed::new(*seed))?;
        let mean = run.returns.iter().sum::<f64>() / EPISODES as f64;
        let worst = run.returns.iter().copied().fold(f64::INFINITY, f64::min);
        let (least, most) = run.temperatures;
        let seconds = start.elapsed().as_secs_f64();
        println!("| {seed} | {STEPS} | {mean:.1} | {worst:.0} | {least:.4} to {most:.4} | {seconds:.0} s |");
        solved += u32::from(mean >= 475.0);
    }
    println!("{solved} of {} reached 475", seeds.len());
    Ok(())
}

struct Run {
    returns: Vec<f64>,
    /// Least and largest temperature of the training.
    temperatures: (f64, f64),
}

fn train(seed: Seed) -> Result<Run, Box<dyn std::error::Error>> {
    let system = sindyna_envs::find("cart-pole").ok_or("no cart-pole")?;
    let spec = system.spec();
    let m = spec.observation_dim();
    let config = SacConfig {
        learning_rate: 1e-3,
        discount: 1.0 - 1.0 / system.protocol().max_steps as f64,
        initial_temperature: 0.1,
        reward_scale: 0.1,
        ..SacConfig::default()
    };
    let scaling = Scaling { center: vec![0.0; m], scale: spec.observation.iter().map(|c| c.prior.scale).collect() };
    let mut batch = Batch::zeros(config.batch_size, m, 1);
    let mut rng = seed.stream("agent", 0);
    let mut agent = SacDiscrete::new(config, scaling, 2, &mut rng)?;
    let mut replay = Replay::new(STEPS, m, 1);

    let mut env = system.environment();
    let mut starts = seed.stream("episodes", 0);
    env.reset(&mut starts)?;
    let (mut observation, mut action) = (vec![0.0; m], [0.0]);
    let mut temperatures = (agent.temperature(), agent.temperature());
    for step in 0..STEPS {
        observation.copy_from_slice(env.observation());
        if step < RANDOM_STEPS {
            action = [f64::from(rng.random_range(0..2))];
        } else {
            agent.act(&observation, Mode::Explore, &mut rng, &mut action);
        }
        let outcome = env.step(&action, &mut starts)?;
        replay.push(Transition {
            observation: &observation,
            action: &action,
            reward: outcome.reward,
            next_observation: env.observation(),
            terminated: outcome.terminated,
        });
        if outcome.terminated || outcome.truncated {
            env.reset(&mut starts)?;
        }
        if step >= RANDOM_STEPS {
            replay.sample_into(&mut batch, &mut rng);
            let t = agent.update(&batch, &mut rng)?.temperature;
            temperatures = (t.min(temperatures.0), t.max(temperatures.1));
        }
    }
    // As many systems as one thread steps together.
    let mut systems: Vec<_> = (0..25).map(|_| system.environment()).collect();
    Ok(Run { returns: evaluate(&mut systems, &agent.frozen(), EPISODES, seed, "evaluation")?, temperatures })
}
