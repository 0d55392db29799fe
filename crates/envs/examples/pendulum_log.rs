//! Writes `examples/logs/pendulum.csv`: the true pendulum near its lower rest, pushed at random, without sensors.
//!
//! `cargo run --release -p sindyna-envs --example pendulum_log > examples/logs/pendulum.csv`

use rand::RngExt as _;
use sindyna_core::{Diverged, Seed};

/// Samples between two changes of the torque.
const HELD: usize = 5;
/// Rows of the log.
const ROWS: usize = 101;

#[allow(clippy::print_stdout, reason = "this is what it is for")]
fn main() -> Result<(), Diverged> {
    let pendulum = sindyna_envs::find("pendulum").expect("it is registered");
    let (dynamics, dt) = (pendulum.dynamics(), pendulum.spec().dt);
    let mut rng = Seed::new(1).stream("log", 0);
    let (mut x, mut next, mut u) = ([3.0, 0.0], [0.0; 2], [0.0]);
    println!("t,th [rad],w [rad/s],u [N·m]");
    for i in 0..ROWS {
        if i % HELD == 0 {
            u = [rng.random_range(-2.0..2.0)];
        }
        println!("{:.2},{},{},{}", i as f64 * dt, x[0], x[1], u[0]);
        dynamics.step(&x, &u, &mut rng, &mut next)?;
        x = next;
    }
    Ok(())
}
