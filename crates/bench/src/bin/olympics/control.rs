//! A planner in the learned equations as a controller of the simulator.

use std::sync::Arc;

use sindyna_bench::study::Result;
use sindyna_control::{Method, Planner};
use sindyna_core::{Memory, Mode, Policy as _, Rng, Seed};
use sindyna_sindy::Model;

use super::plant::{DT, LIMIT, Plant, Robot, Run, run};
use super::task::{EVERY, Ramped, SwingUp};

/// Criteria near which the prices are those of the score: a swing-up of a second.
const TYPICAL: [f64; 5] = [1.0, 8.0, 2.0, 0.01, 80.0];

/// A planner for `robot` in `model`.
pub(crate) fn planner(model: &Model, robot: Robot) -> Result<Planner> {
    let (dynamics, task) = (Arc::new(Ramped::new(model.clone())), Arc::new(SwingUp::new(robot, &TYPICAL)));
    Ok(Planner::new(Method::Ilqr, dynamics, task)?.prepared())
}

/// A run of 10 s under a planner.
pub(crate) fn controlled(plant: Plant, robot: Robot, planner: &Planner) -> Result<Run> {
    let mut controller = Controller::new(planner);
    let mut own = Seed::new(0).stream("planner", 0);
    Ok(run(plant, robot, |x| controller.torque(x, &mut own))?)
}

/// A planner in the middle of a run: asked every few steps, its torque goes on at the rate it chose.
struct Controller<'a> {
    memory: Option<Box<dyn Memory + 'a>>,
    steps: usize,
    torque: f64,
    rate: f64,
}

impl<'a> Controller<'a> {
    fn new(planner: &'a Planner) -> Self {
        Self { memory: planner.begin(), steps: 0, torque: 0.0, rate: 0.0 }
    }

    fn torque(&mut self, x: &[f64; 4], rng: &mut Rng) -> f64 {
        if self.steps.is_multiple_of(EVERY) {
            let mut action = [0.0];
            let seen = [x[0], x[1], x[2], x[3], self.torque];
            if let Some(memory) = &mut self.memory {
                memory.act(&seen, Mode::Exploit, rng, &mut action);
            }
            self.rate = action[0];
        }
        // The middle of the ramp over this step.
        let now = (self.torque + 0.5 * self.rate * DT).clamp(-LIMIT, LIMIT);
        self.torque = (self.torque + self.rate * DT).clamp(-LIMIT, LIMIT);
        self.steps += 1;
        now
    }
}
