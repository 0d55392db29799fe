//! Trains a controller for a system of one's own: a cart that is pushed to the middle of its track.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use sindyna::problem::{OwnSystem, TaskBuilder, stepped};
use sindyna::{Training, Verdict};

fn main() -> Result<(), sindyna::Error> {
    // What is declared: channels with their units and start states, the reward, and what counts as solved.
    let task = TaskBuilder::new("cart", 0.1)
        .state("x", "m", (-1.0, 1.0))
        .rate("v", "m/s", "x", (0.0, 0.0))
        .input("F", "N", -5.0, 5.0)
        .reward(|x, u, _next| -x[0].powi(2) - 0.1 * x[1].powi(2) - 0.001 * u[0].powi(2))
        .max_steps(60)
        .build()?;
    // The system, 0.1 s later: 2 kg, 0.4 N s/m of friction. Hardware would be a `sindyna::problem::Plant`.
    let step = |x: &[f64], u: &[f64]| {
        let v = x[1] + 0.1 * (u[0] - 0.4 * x[1]) / 2.0;
        vec![x[0] + 0.1 * v, v]
    };
    let trained = Training::of(OwnSystem::simulated(task, stepped(step))?.solved_at(-5.0)).run()?;
    println!("{}\n{:?}", trained.equations().join("\n"), trained.verdict());
    assert_eq!(trained.verdict(), Verdict::Solved);
    Ok(())
}

#[cfg(test)]
#[test]
fn it_runs() {
    main().expect("the example runs");
}
