//! Dynamics, a task and sensors make an environment.

use serde::{Deserialize, Serialize};

use crate::{
    Checkpoint, CheckpointError, Dynamics, EnvError, Environment, Observe, Outcome, Rng, Spec, Task, decode, encode,
};

/// An [`Environment`] in the computer: the true system and the learned one are this same type.
#[derive(Debug, Clone)]
pub struct Simulated<D, T, H> {
    dynamics: D,
    task: T,
    sensors: H,
    state: Vec<f64>,
    next: Vec<f64>,
    control: Vec<f64>,
    observation: Vec<f64>,
    steps: usize,
    running: bool,
}

impl<D: Dynamics, T: Task, H: Observe> Simulated<D, T, H> {
    /// Puts `task` on `dynamics`, seen through `sensors`. The first call must be a reset.
    pub fn new(dynamics: D, task: T, sensors: H) -> Self {
        let spec = task.spec();
        let (n, k, m) = (spec.state_dim(), spec.control_dim(), spec.observation_dim());
        Self {
            dynamics,
            task,
            sensors,
            state: vec![0.0; n],
            next: vec![0.0; n],
            control: vec![0.0; k],
            observation: vec![0.0; m],
            steps: 0,
            running: false,
        }
    }

    /// The state x (n).
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// The control u (k) the last step applied.
    pub fn control(&self) -> &[f64] {
        &self.control
    }

    /// The task on this system.
    pub fn task(&self) -> &T {
        &self.task
    }

    /// Begins an episode in state `x` (n).
    pub fn reset_to(&mut self, x: &[f64], rng: &mut Rng) {
        self.state.copy_from_slice(x);
        self.begin(rng);
    }

    fn begin(&mut self, rng: &mut Rng) {
        self.steps = 0;
        self.running = true;
        self.sensors.observe(&self.state, rng, &mut self.observation);
    }
}

impl<D: Dynamics, T: Task, H: Observe> Environment for Simulated<D, T, H> {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        self.task.initial(rng, &mut self.state);
        self.begin(rng);
        Ok(())
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        if !self.running {
            return Err(EnvError::NeedsReset);
        }
        if !self.task.spec().action_space.control_into(action, &mut self.control) {
            return Err(EnvError::NotAnAction { action: action.to_vec() });
        }
        if let Err(diverged) = self.dynamics.step(&self.state, &self.control, rng, &mut self.next) {
            self.running = false;
            return Err(EnvError::diverged(self.task.spec(), diverged));
        }
        let reward = self.task.reward(&self.state, action, &self.control, &self.next);
        std::mem::swap(&mut self.state, &mut self.next);
        self.sensors.observe(&self.state, rng, &mut self.observation);
        self.steps += 1;
        let (spec, (before, after)) = (self.task.spec(), (&self.next, &self.state));
        if let Err(unpaid) = EnvError::unless_finite(spec, reward, (before, &self.control, after)) {
            self.running = false;
            return Err(unpaid);
        }
        let terminated = self.task.terminated(&self.state);
        let truncated = self.steps >= self.task.max_steps();
        self.running = !(terminated || truncated);
        Ok(Outcome { reward, terminated, truncated })
    }

    fn checkpoint(&mut self) -> Option<&mut dyn Checkpoint> {
        Some(self)
    }
}

/// What changes in a simulation from step to step.
#[derive(Serialize, Deserialize)]
struct Moment {
    state: Vec<f64>,
    control: Vec<f64>,
    observation: Vec<f64>,
    steps: usize,
    running: bool,
}

impl<D, T, H> Checkpoint for Simulated<D, T, H> {
    fn save(&self) -> Vec<u8> {
        let Self { state, control, observation, steps, running, .. } = self;
        let (state, control, observation) = (state.clone(), control.clone(), observation.clone());
        encode(&Moment { state, control, observation, steps: *steps, running: *running })
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        let Moment { state, control, observation, steps, running } = decode(saved)?;
        CheckpointError::expect_len("states", self.state.len(), state.len())?;
        CheckpointError::expect_len("controls", self.control.len(), control.len())?;
        CheckpointError::expect_len("observed values", self.observation.len(), observation.len())?;
        (self.state, self.control, self.observation) = (state, control, observation);
        (self.steps, self.running) = (steps, running);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Diverged, Kind, Precision, Seed, Sensors, Space};

    /// x' = x + u, ends beyond 1, reward −x² of the state before the step, which is no number below −1.
    struct Walk(Spec);

    impl Walk {
        fn new() -> Self {
            Self(Spec {
                name: "walk".into(),
                state: vec![Channel::new("x", "m", Kind::Plain, 1.0)],
                observation: vec![Channel::new("x", "m", Kind::Plain, 1.0)],
                control: vec![Channel::new("u", "m", Kind::Plain, 1.0)],
                action_space: Space::Box { low: vec![-0.5], high: vec![0.5] },
                precision: Precision::F32,
                noise: 0.0,
                dt: 1.0,
            })
        }
    }

    impl Task for Walk {
        fn spec(&self) -> &Spec {
            &self.0
        }
        fn max_steps(&self) -> usize {
            4
        }
        fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
            x[0] = 0.1;
        }
        fn reward(&self, x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
            if x[0] < -1.0 { f64::NAN } else { -x[0] * x[0] }
        }
        fn terminated(&self, next: &[f64]) -> bool {
            next[0] > 1.0
        }
    }

    struct Add;
    impl Dynamics for Add {
        fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
            next[0] = x[0] + u[0];
            Diverged::check(next)
        }
    }

    fn walk() -> (Simulated<Add, Walk, Sensors>, Rng) {
        let task = Walk::new();
        let sensors = Sensors::new(task.spec()).expect("the observation names the state");
        (Simulated::new(Add, task, sensors), Seed::new(0).numpy())
    }

    #[test]
    fn a_step_needs_a_reset_and_a_real_action() {
        let (mut env, mut rng) = walk();
        assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
        env.reset(&mut rng).expect("a simulation resets");
        assert!(matches!(env.step(&[f64::NAN], &mut rng), Err(EnvError::NotAnAction { .. })));
    }

    #[test]
    fn the_time_limit_truncates_and_the_task_terminates() {
        let (mut env, mut rng) = walk();
        env.reset(&mut rng).expect("a simulation resets");
        let ends: Vec<_> = (0..4).map(|_| env.step(&[0.0], &mut rng).expect("still running")).collect();
        assert_eq!(ends.iter().filter(|o| o.truncated).count(), 1);
        assert!(ends[3].truncated && !ends[3].terminated);

        env.reset_to(&[0.9], &mut rng);
        let outcome = env.step(&[9.0], &mut rng).expect("still running");
        assert!(outcome.terminated && !outcome.truncated);
        assert!((outcome.reward + 0.81).abs() < 1e-15, "the reward is of the state before the step");
        assert!((env.state()[0] - 1.4).abs() < 1e-15, "the control is the clipped action");
    }

    #[test]
    fn a_reward_that_is_no_number_ends_the_episode_with_where() {
        let (mut env, mut rng) = walk();
        env.reset_to(&[-2.0], &mut rng);
        let error = env.step(&[0.25], &mut rng).expect_err("the task pays NaN");
        assert_eq!(error.to_string(), "the reward of `walk` is NaN at x = -2.0, u = 0.25, next_x = -1.75");
        assert_eq!(env.step(&[0.25], &mut rng), Err(EnvError::NeedsReset));
    }

    #[test]
    fn observations_are_rounded_and_the_state_is_not() {
        let (mut env, mut rng) = walk();
        env.reset(&mut rng).expect("a simulation resets");
        assert_eq!(env.observation(), [f64::from(0.1_f32)]);
        assert_eq!(env.state(), [0.1]);
    }
}
