//! Parameters that are drawn for every episode: states that never change.

use super::document::{Document, Parameter, State, StateKind};

impl Document {
    /// The same with parameters that are drawn as states after all others, whose rates are 0 in equations.
    pub(super) fn with_drawn(mut self) -> Self {
        let drawn = self.parameters.iter().filter_map(|(name, parameter)| match parameter {
            Parameter::Drawn(start) => Some((name.clone(), *start)),
            Parameter::Number(_) => None,
        });
        for (name, start) in drawn.collect::<Vec<_>>() {
            self.parameters.remove(&name);
            if let Some(equations) = &mut self.equations {
                equations.insert(name.clone(), "0".into());
            }
            if let Some(observation) = &mut self.observation
                && !observation.contains(&name)
            {
                // States come before formulas.
                observation.insert(0, name.clone());
            }
            self.state.push(State {
                name,
                unit: String::new(),
                scale: 1.0,
                start: Some(start),
                bounds: None,
                kind: Some(StateKind::Plain),
                rate_of: None,
                still: true,
            });
        }
        self
    }

    /// States that move.
    pub(super) fn moving(&self) -> usize {
        self.state.iter().filter(|state| !state.still).count()
    }

    /// Numbers with names.
    pub(super) fn numbers(&self) -> impl Iterator<Item = (String, f64)> {
        self.parameters.iter().filter_map(|(name, parameter)| match parameter {
            Parameter::Number(value) => Some((name.clone(), *value)),
            Parameter::Drawn(_) => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use sindyna_core::{Observe as _, Seed};

    use super::super::TaskFile;
    use crate::problem::Problem as _;

    /// The task file of a point that is to go where a parameter says.
    fn point(parameters: &str, rest: &str) -> anyhow::Result<TaskFile> {
        let text = format!(
            "name = \"point\"\nmax_steps = 10\ndt = 0.1\n{rest}[parameters]\nk = 2.0\n{parameters}\n[let]\nmiss = \"x - goal\"\n[equations]\nx = \"k*u\"\n\
             [[state]]\nname = \"x\"\n[[control]]\nname = \"u\"\nlow = -1.0\nhigh = 1.0\n\
             [task]\nreward = \"-next_miss^2\"\nterminated = \"abs(next_x - next_goal) < 0.01\"\n"
        );
        TaskFile::read(Path::new("point.toml"), text, None)
    }

    #[test]
    fn a_parameter_that_is_drawn_stays_for_an_episode_and_is_seen() {
        let file = point("goal = [1.0, 3.0]", "").unwrap();
        let names: Vec<_> = file.spec().observation.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["x", "goal"]);
        let (task, dynamics) = (file.task(), file.dynamics().unwrap());
        let (mut rng, mut x, mut sum) = (Seed::new(4).numpy(), [0.0; 2], 0.0);
        for _ in 0..2_000 {
            task.initial(&mut rng, &mut x);
            assert!(x[0] == 0.0 && (1.0..=3.0).contains(&x[1]), "{x:?}");
            sum += x[1];
            let mut next = [0.0; 2];
            dynamics.step(&x, &[0.5], &mut rng, &mut next).unwrap();
            assert!((next[0] - 0.1).abs() < 1e-12 && next[1] == x[1], "{next:?}");
            let reward = task.reward(&x, &[0.5], &[0.5], &next);
            assert!((reward + (0.1 - x[1]).powi(2)).abs() < 1e-12, "{reward}");
            assert!(task.terminated(&[x[1], x[1]]) && !task.terminated(&next));
        }
        // Standard error of the mean: 0.013.
        assert!((sum / 2_000.0 - 2.0).abs() < 0.05, "{sum}");
        let mut o = [0.0; 3];
        let file = point("goal = { mean = 0.0, std = 1.0 }", "observation = [\"x\", \"miss\"]\n").unwrap();
        file.sensors().observe(&[0.5, 0.2], &mut rng, &mut o);
        assert_eq!(o, [0.2, 0.5, 0.5 - 0.2], "a parameter that is not listed comes first");
    }

    #[test]
    fn what_is_no_parameter_is_refused() {
        for (parameters, says) in [
            ("goal = [3.0, 1.0]", "state `goal`: start must be [low, high]"),
            ("goal = \"far\"", "a parameter must be a number, [low, high] or { mean = …, std = … }"),
            ("goal = [0.0, 1.0]\nx = [0.0, 1.0]", "the name `x` is used twice"),
        ] {
            let refusal = format!("{:#}", point(parameters, "").err().unwrap());
            assert!(refusal.contains(says), "{parameters}: {refusal}");
        }
    }
}
