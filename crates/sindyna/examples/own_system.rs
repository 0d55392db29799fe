//! Trains a controller for a system of one's own: a cart that is pushed to the middle of its track.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use sindyna::problem::{OwnSystem, Plant, PlantError, TaskBuilder};
use sindyna::{Training, Verdict};

/// The cart, simulated here; hardware would be read and driven in the same two functions.
struct Cart {
    state: [f64; 2],
}

impl Plant for Cart {
    fn reset(&mut self, start: &[f64]) -> Result<Vec<f64>, PlantError> {
        self.state = [start[0], start[1]];
        Ok(self.state.to_vec())
    }

    fn step(&mut self, u: &[f64]) -> Result<Vec<f64>, PlantError> {
        // 0.1 s of a mass of 2 kg under the force u, with viscous friction.
        let [x, v] = self.state;
        let v = v + 0.1 * (u[0] - 0.4 * v) / 2.0;
        self.state = [x + 0.1 * v, v];
        Ok(self.state.to_vec())
    }
}

fn main() -> Result<(), sindyna::Error> {
    let task = TaskBuilder::new("cart", 0.1)
        .state("x", "m", (-1.0, 1.0))
        .rate("v", "m/s", "x", (0.0, 0.0))
        .input("F", "N", -5.0, 5.0)
        .reward(|x, u, _next| -x[0].powi(2) - 0.1 * x[1].powi(2) - 0.001 * u[0].powi(2))
        .max_steps(60)
        .solved_at(-5.0)
        .build()?;
    let system = OwnSystem::connected(task, || Ok(Cart { state: [0.0; 2] }))?;

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
