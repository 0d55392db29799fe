//! Data that were there before, as if they happened now.

use std::sync::Arc;

use sindyna_core::{Checkpoint, CheckpointError, Dataset, End, EnvError, Environment, Explorer, Outcome, Rng, Spec};

use super::Problem;

/// Recorded rollouts one after the other, and what comes after them: the system itself, which is opened only then, or nothing.
pub struct Played {
    spec: Spec,
    data: Arc<Dataset>,
    after: Option<Arc<dyn Problem>>,
    system: Option<Box<dyn Environment>>,
    /// Rollouts begun.
    begun: usize,
    /// Steps shown of the last one.
    step: usize,
    observation: Vec<f64>,
}

impl Played {
    /// `data` of the system `spec`, then that of `after`.
    pub fn new(spec: Spec, data: Arc<Dataset>, after: Option<Arc<dyn Problem>>) -> Self {
        let observation = vec![0.0; spec.observation_dim()];
        Self { spec, data, after, system: None, begun: 0, step: 0, observation }
    }
}

impl Environment for Played {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn observation(&self) -> &[f64] {
        self.system.as_ref().map_or(&self.observation, |system| system.observation())
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        while let (None, Some(rollout)) = (&self.system, self.data.rollouts().nth(self.begun)) {
            (self.begun, self.step) = (self.begun + 1, 0);
            // After some resets nothing was done.
            if !rollout.rewards.is_empty() {
                self.observation = rollout.observations.row(0).to_vec();
                return Ok(());
            }
        }
        let failed = |reason: String| EnvError::System { reason };
        let system = match (self.system.take(), &self.after) {
            (Some(system), _) => system,
            (None, Some(problem)) => problem.environment().map_err(|e| failed(e.to_string()))?,
            (None, None) => return Err(failed("the end of the log is reached".into())),
        };
        self.system.insert(system).reset(rng)
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        if let Some(system) = &mut self.system {
            return system.step(action, rng);
        }
        let rollout =
            self.begun.checked_sub(1).and_then(|i| self.data.rollouts().nth(i)).ok_or(EnvError::NeedsReset)?;
        let (at, steps) = (self.step, rollout.rewards.len());
        if at >= steps {
            return Err(EnvError::NeedsReset);
        }
        if rollout.actions.row(at).iter().ne(action) {
            return Err(EnvError::System { reason: "a log has no response to another action".into() });
        }
        self.step += 1;
        self.observation = rollout.observations.row(at + 1).to_vec();
        let last = self.step == steps;
        let terminated = last && rollout.end == End::Terminated;
        Ok(Outcome { reward: rollout.rewards[at], terminated, truncated: last && !terminated })
    }
}

/// Does what was done in recorded data, then what another explorer does.
pub struct Replayed {
    data: Arc<Dataset>,
    then: Option<Box<dyn Explorer>>,
}

impl Replayed {
    /// Repeats `data`, then does what `then` does.
    pub fn new(data: Arc<Dataset>, then: Option<Box<dyn Explorer>>) -> Self {
        Self { data, then }
    }
}

impl Checkpoint for Replayed {
    fn save(&self) -> Vec<u8> {
        self.then.as_ref().map_or_else(Vec::new, |then| then.save())
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        self.then.as_mut().map_or(Ok(()), |then| then.restore(saved))
    }
}

impl Explorer for Replayed {
    fn next(&mut self, so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        match (self.data.transitions(so_far.n_steps()).next(), &mut self.then) {
            (Some(recorded), _) => action.copy_from_slice(recorded.action),
            (None, Some(then)) => then.next(so_far, rng, action),
            (None, None) => {}
        }
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
        let spec = problem.spec().clone();
        let mut data = Dataset::new(3, 1, 1, spec.dt);
        for (first, steps) in [(0.1, 1), (0.5, 2), (0.9, 0)] {
            data.begin(&[first, 0.0, 0.0]).unwrap();
            for step in 0..steps {
                data.push(&[first + f64::from(step)], &[0.0], -first, &[first, f64::from(step), 0.0]).unwrap();
            }
        }
        let (data, mut rng) = (Arc::new(data), Seed::new(0).numpy());
        let mut env = Played::new(spec.clone(), data.clone(), Some(problem));
        let mut explorer = Replayed::new(data.clone(), Some(Box::new(Uniform::new(&spec))));
        assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
        let mut so_far = Dataset::new(3, 1, 1, spec.dt);
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
        let mut alone = Played::new(spec, data, None);
        alone.reset(&mut rng).unwrap();
        assert!(alone.step(&[7.0], &mut rng).is_err(), "another action than the one recorded");
    }
}
