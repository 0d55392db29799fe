//! Trains a controller for a system of one's own: a cart that is pushed to the middle of its track.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use sindyna::problem::{OwnSystem, TaskBuilder, stepped};
use sindyna::{Training, Verdict};

/// A cart of some mass \[kg\] with viscous friction \[N s/m\].
struct Cart(f64, f64);

impl Cart {
    /// Position and velocity 0.1 s later, under the force `u`. Hardware would be a `sindyna::problem::Plant`.
    fn step(&self, x: &[f64], u: &[f64]) -> Vec<f64> {
        let v = x[1] + 0.1 * (u[0] - self.1 * x[1]) / self.0;
        vec![x[0] + 0.1 * v, v]
    }
}

fn main() -> Result<(), sindyna::Error> {
    // What is declared: channels with their units and start states, the reward, and what counts as solved.
    let task = TaskBuilder::new("cart", 0.1)
        .state("x", "m", (-1.0, 1.0))
        .rate("v", "m/s", "x", (0.0, 0.0))
        .input("F", "N", -5.0, 5.0)
        .reward(|x, u, _next| -x[0].powi(2) - 0.1 * x[1].powi(2) - 0.001 * u[0].powi(2))
        .max_steps(60)
        .build()?;
    let cart = Cart(2.0, 0.4);
    let system = OwnSystem::simulated(task, stepped(move |x, u| cart.step(x, u)))?.solved_at(-5.0);

    let trained = Training::of(system).run()?;
    println!("{}\n{:?}", trained.equations().join("\n"), trained.verdict());
    assert_eq!(trained.verdict(), Verdict::Solved);
    Ok(())
}

#[cfg(test)]
#[test]
fn it_runs() {
    main().expect("the example runs");
}
