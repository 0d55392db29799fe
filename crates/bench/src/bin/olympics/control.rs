//! A planner in the learned equations as a controller of the simulator.

use std::sync::Arc;

use sindyna_bench::study::Result;
use sindyna_control::{Method, Planner};
use sindyna_core::{Dynamics, Memory, Mode, Policy as _, Rng, Seed};
use sindyna_sindy::Model;

use super::plant::{DT, LIMIT, Robot, Run, STEPS, run, stepped};
use super::score::Score;
use super::task::{EVERY, Prices, Ramped, SwingUp};

/// Criteria near which the first prices are those of the score: a swing-up of a second.
const TYPICAL: [f64; 5] = [1.0, 8.0, 2.0, 0.01, 80.0];

/// Times that prices are set anew where the plan so far comes to.
const ROUNDS: usize = 3;

/// A planner for `robot` in `model`: it looks for a way up, and improves what it found at the prices that hold there.
pub(crate) fn planner(model: &Model, robot: Robot) -> Result<Planner> {
    let dynamics = Arc::new(Ramped::new(model.clone()));
    let new = |prices| Planner::new(Method::Ilqr, dynamics.clone(), Arc::new(SwingUp::new(robot, prices)));
    let mut planner = new(Prices::near(&TYPICAL).with_all_for_time())?.prepared();
    for _ in 0..ROUNDS {
        let imagined = controlled(&stepped(model.clone()), robot, &planner)?;
        let score = Score::of(&imagined.x[..STEPS], &imagined.torque);
        if score.score == 0.0 {
            break;
        }
        planner = new(Prices::near(&score.criteria()))?.following(&planner);
    }
    Ok(planner)
}

/// A run of 10 s in `simulator` under a planner.
pub(crate) fn controlled(simulator: &impl Dynamics, robot: Robot, planner: &Planner) -> Result<Run> {
    let mut controller = Controller::new(planner);
    let mut own = Seed::new(0).stream("planner", 0);
    Ok(run(simulator, robot, |x| controller.torque(x, &mut own))?)
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
