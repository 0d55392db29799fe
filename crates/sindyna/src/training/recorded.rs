//! Real data that were there before: a warm-up that is replayed.

use sindyna_core::{Checkpoint, CheckpointError, Dataset, End, EnvError, Environment, Explorer, Outcome, Rng, Spec};

use crate::problem::Problem;

/// Repeats the recorded actions, then goes on as another explorer does.
pub(crate) struct Repeating {
    pub(crate) data: Dataset,
    pub(crate) then: Box<dyn Explorer>,
}

impl Checkpoint for Repeating {
    fn save(&self) -> Vec<u8> {
        self.then.save()
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        self.then.restore(saved)
    }
}

impl Explorer for Repeating {
    fn next(&mut self, so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        match self.data.transitions(so_far.n_steps()).next() {
            Some(recorded) => action.copy_from_slice(recorded.action),
            None => self.then.next(so_far, rng, action),
        }
    }
}

/// Shows the recorded rollouts one after the other, whatever is done; the system itself after them, which is opened only then.
pub(crate) struct Replayed<'a> {
    data: Dataset,
    problem: &'a dyn Problem,
    /// Rollouts begun.
    begun: usize,
    /// Steps shown of the last one.
    shown: usize,
    observation: Vec<f64>,
    system: Option<Box<dyn Environment>>,
}

impl<'a> Replayed<'a> {
    /// Shows `data` of the system of `problem`.
    pub(crate) fn new(data: Dataset, problem: &'a dyn Problem) -> Self {
        let observation = vec![0.0; problem.spec().observation_dim()];
        Self { data, problem, begun: 0, shown: 0, observation, system: None }
    }
}

impl Environment for Replayed<'_> {
    fn spec(&self) -> &Spec {
        self.problem.spec()
    }

    fn observation(&self) -> &[f64] {
        self.system.as_ref().map_or(&self.observation, |system| system.observation())
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        while let (None, Some(rollout)) = (&self.system, self.data.rollouts().nth(self.begun)) {
            (self.begun, self.shown) = (self.begun + 1, 0);
            // Nothing was done after such a reset.
            if !rollout.rewards.is_empty() {
                self.observation = rollout.observations.row(0).to_vec();
                return Ok(());
            }
        }
        let system = match self.system.take() {
            Some(system) => system,
            None => self.problem.environment().map_err(|e| EnvError::System { reason: e.to_string() })?,
        };
        self.system.insert(system).reset(rng)
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        if let Some(system) = &mut self.system {
            return system.step(action, rng);
        }
        let rollout =
            self.begun.checked_sub(1).and_then(|i| self.data.rollouts().nth(i)).ok_or(EnvError::NeedsReset)?;
        let (at, steps) = (self.shown, rollout.rewards.len());
        if at >= steps {
            return Err(EnvError::NeedsReset);
        }
        self.shown += 1;
        self.observation = rollout.observations.row(at + 1).to_vec();
        let last = at + 1 == steps;
        let terminated = last && rollout.end == End::Terminated;
        Ok(Outcome { reward: rollout.rewards[at], terminated, truncated: last && !terminated })
    }
}

#[cfg(test)]
mod tests {
    use sindyna_core::Seed;
    use sindyna_dyna::Uniform;

    use super::*;
    use crate::problem::named;

    #[test]
    fn recorded_rollouts_come_before_the_system() {
        let problem = named("pendulum").unwrap();
        let mut data = Dataset::new(3, 1, 1, problem.spec().dt);
        for (first, steps) in [(0.1, 1), (0.5, 2), (0.9, 0)] {
            data.begin(&[first, 0.0, 0.0]).unwrap();
            for step in 0..steps {
                data.push(&[first + f64::from(step)], &[0.0], -first, &[first, f64::from(step), 0.0]).unwrap();
            }
        }
        let mut rng = Seed::new(0).numpy();
        let mut env = Replayed::new(data.clone(), &*problem);
        let mut explorer = Repeating { data, then: Box::new(Uniform::new(problem.spec())) };
        assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
        let mut so_far = Dataset::new(3, 1, 1, problem.spec().dt);
        let mut seen = Vec::new();
        for _ in 0..2 {
            env.reset(&mut rng).unwrap();
            so_far.begin(env.observation()).unwrap();
            loop {
                let mut action = [9.0];
                explorer.next(&so_far, &mut rng, &mut action);
                let outcome = env.step(&action, &mut rng).unwrap();
                so_far.push(&action, &action, outcome.reward, env.observation()).unwrap();
                seen.push((action[0], outcome.reward));
                if outcome.truncated {
                    break;
                }
            }
        }
        assert_eq!(seen, [(0.1, -0.1), (0.5, -0.5), (1.5, -0.5)]);
        env.reset(&mut rng).unwrap();
        let o = env.observation();
        assert!((o[0].hypot(o[1]) - 1.0).abs() < 1e-6 && o[0] != 0.9, "the pendulum itself: {o:?}");
    }
}
