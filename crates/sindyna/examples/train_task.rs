//! Trains a controller that swings a pendulum up, inside equations identified from ten steps.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use sindyna::{Training, Verdict};

fn main() -> Result<(), sindyna::Error> {
    // `sindyna::problem::names()` lists the tasks; every setting of `config.toml` can be changed.
    let training = Training::named("pendulum")?.with_seed(0).with("evaluation_episodes=50")?;
    let trained = training.run()?;

    for equation in trained.equations() {
        println!("{equation}");
    }
    let returns = trained.returns();
    let mean = returns.iter().sum::<f64>() / returns.len() as f64;
    println!("{:?} after {} steps: mean return {mean:.1}", trained.verdict(), trained.data.n_steps());

    // The policy maps an observation (cos θ, sin θ, ω) to a torque: hanging down, it begins to swing.
    let torque = trained.act(&[-1.0, 0.0, 0.0]);
    println!("torque when hanging at rest: {torque:?} N·m");
    assert_eq!(trained.verdict(), Verdict::Solved);
    Ok(())
}

#[cfg(test)]
#[test]
fn it_runs() {
    main().expect("the example runs");
}
