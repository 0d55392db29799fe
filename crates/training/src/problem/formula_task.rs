//! A task whose reward and end are formulas.

use std::sync::Arc;

use rand::RngExt as _;
use sindyna_core::turning::wrapped;
use sindyna_core::{EnvError, Kind, Rng, Seed, Space, Spec, Task};
use sindyna_sindy::{Compiled, Expr, parse};

use super::condition::Condition;
use super::starts::{Start, Starts};
use crate::Error;

/// Variables of a reward held on the stack; larger systems fall back to the heap.
const STACK_VARIABLES: usize = 64;

/// The variable of a reward that is 1 where the step ended the episode, else 0.
const ENDED: &str = "terminated";

/// Share of drawn start states that must fulfil a condition on them.
const LEAST_SHARE: f64 = 0.01;

/// Names that formulas of a task may use besides states and controls.
#[derive(Debug, Clone, Copy, Default)]
pub struct Names<'a> {
    /// Names for terms of the states (n).
    pub definitions: &'a [(String, Expr)],
    /// Names for numbers.
    pub parameters: &'a [(String, f64)],
}

impl Names<'_> {
    /// What stands for the name of this number, definitions first.
    fn meaning(&self, i: usize) -> Expr {
        match i.checked_sub(self.definitions.len()) {
            None => self.definitions[i].1.clone(),
            Some(i) => Expr::Constant(self.parameters[i].1),
        }
    }
}

/// A task whose reward, end and condition on start states are formulas.
#[derive(Debug, Clone)]
pub struct FormulaTask {
    /// What is declared of the system.
    pub spec: Spec,
    max_steps: usize,
    starts: Starts,
    /// Over z = (x; u; x'; ended).
    reward: Compiled,
    /// Over x'.
    terminated: Option<Condition>,
    /// States of which formulas see the value between −π and π.
    folded: Vec<usize>,
}

impl FormulaTask {
    /// The task on the system `spec` whose states begin uniformly in the ranges `start` (n) and whose episodes have at most `max_steps`. `reward` is a formula over states, controls, states after
    /// the step (`next_x`) and `terminated` (1 where the step ended the episode, else 0); `terminated` a condition such as `abs(next_x) > 2 or next_v < 1`.
    ///
    /// # Errors
    /// [`Error::System`] if a formula cannot be read.
    pub fn new(
        spec: Spec,
        max_steps: usize,
        start: Vec<(f64, f64)>,
        reward: &str,
        terminated: Option<&str>,
    ) -> Result<Self, Error> {
        let start = start.into_iter().map(|(low, high)| Start::Uniform(low, high)).collect();
        Self::defined(spec, max_steps, (start, None), (reward, terminated), Names::default())
    }

    /// The same with start states (n) that are drawn again where they do not fulfil a condition, and with `known` names. In formulas `next_` and the name of a
    /// definition is its value after the step.
    ///
    /// # Errors
    /// [`Error::System`] if a formula cannot be read, or the condition on start states is hardly ever fulfilled.
    pub fn defined(
        spec: Spec,
        max_steps: usize,
        (start, start_if): (Vec<Start>, Option<&str>),
        (reward, terminated): (&str, Option<&str>),
        known: Names<'_>,
    ) -> Result<Self, Error> {
        let Names { definitions, parameters } = known;
        let (states, controls) = (spec.state.iter().map(|s| &s.name), spec.control.iter().map(|u| &u.name));
        let (n, k, d) = (spec.state_dim(), spec.control_dim(), definitions.len());
        let after = |name: &String| format!("next_{name}");
        let defined = definitions.iter().map(|(name, _)| name);
        let mut names: Vec<String> = states.clone().chain(controls).cloned().chain(states.clone().map(after)).collect();
        names.push(ENDED.to_owned());
        let numbers = || parameters.iter().map(|(name, _)| name.clone());
        names.extend(defined.clone().cloned().chain(defined.clone().map(after)).chain(numbers()));
        let before: Vec<String> = states.clone().chain(defined.clone()).cloned().chain(numbers()).collect();
        let after: Vec<String> = states.chain(defined).map(after).chain(numbers()).collect();
        let name = spec.name.clone();
        let refused = |what: &str, why: String| Error::System { name: name.clone(), why: format!("{what}: {why}") };
        let reward = parse(reward, &names).map_err(|e| refused("reward", e.to_string()))?;
        let reward = reward.replaced(&|i| match i.checked_sub(2 * n + k + 1)? {
            i if i < d => Some(definitions[i].1.clone()),
            i if i < 2 * d => Some(definitions[i - d].1.replaced(&|state| Some(Expr::Variable(n + k + state)))),
            i => Some(known.meaning(i - d)),
        });
        let reward = Compiled::new(&reward, 2 * n + k + 1)
            .ok_or_else(|| refused("reward", "it has a variable that nothing defines".into()))?;
        let terminated = terminated.map(|text| Condition::parse(text, &after)).transpose();
        let terminated =
            terminated.map_err(|e| refused("terminated, a condition on the state after the step", format!("{e:#}")))?;
        let written_out = |c: Condition| c.replaced(&|i| i.checked_sub(n).map(|i| known.meaning(i)));
        let terminated = terminated.map(written_out);
        let start_if = start_if.map(|text| Condition::parse(text, &before)).transpose();
        let start_if = start_if.map_err(|e| refused("start_if, a condition on the start state", format!("{e:#}")))?;
        let starts = Starts::new(&spec, start, start_if.map(written_out));
        let share = starts.share(&mut Seed::new(0).stream("start states on trial", 0));
        if share < LEAST_SHARE {
            let why = format!(
                "start_if: {:.1} % of the sampled start states are within bounds and satisfy it; at least 1 % must",
                100.0 * share
            );
            return Err(Error::System { name, why });
        }
        Ok(Self { spec, max_steps, starts, reward, terminated, folded: Vec::new() })
    }

    /// The same with angles that are seen only as cosine and sine between −π and π in all formulas: no sensor shows how often they turned.
    #[must_use]
    pub fn with_folded_angles(mut self) -> Self {
        let spec = &self.spec;
        let seen = |name: &String| spec.observation.iter().any(|o| o.name == *name);
        let folded = |i: &usize| spec.state[*i].kind == Kind::Angle && !seen(&spec.state[*i].name);
        self.folded = (0..spec.state_dim()).filter(folded).collect();
        self
    }

    /// The same with ranges of start values that are estimates from so many `samples` (n), uniform ones: \[low, high\] is the range of the samples, made wider by
    /// (samples + 1) / (samples − 1). What is learned is learned for ranges drawn from their posterior ([`Task::draw`]).
    #[must_use]
    pub fn with_estimated_starts(self, samples: Vec<Option<usize>>) -> Self {
        Self { starts: self.starts.estimated(samples), ..self }
    }

    /// The same task with ranges of start values drawn from their posterior; `None` where all are known.
    #[must_use]
    pub fn drawn(&self, rng: &mut Rng) -> Option<Self> {
        let starts = self.starts.drawn(&self.spec, rng)?;
        Some(Self { starts, ..self.clone() })
    }

    /// Tries the reward at `times` start states under random controls.
    pub fn try_reward(&self, times: usize, rng: &mut Rng) -> Result<(), EnvError> {
        let Space::Box { low, high } = &self.spec.action_space else { return Ok(()) };
        let (mut x, mut u) = (vec![0.0; self.spec.state_dim()], vec![0.0; self.spec.control_dim()]);
        for _ in 0..times {
            self.initial(rng, &mut x);
            for ((value, &low), &high) in u.iter_mut().zip(low).zip(high) {
                *value = rng.random_range(low..=high);
            }
            EnvError::unless_finite(&self.spec, self.reward(&x, &u, &u, &x), (&x, &u, &x))?;
        }
        Ok(())
    }

    /// The states (n) as formulas see them.
    fn fold(&self, x: &mut [f64]) {
        for &i in &self.folded {
            x[i] = wrapped(x[i]);
        }
    }
}

impl Task for FormulaTask {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn max_steps(&self) -> usize {
        self.max_steps
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        self.starts.draw(rng, x);
    }

    fn reward(&self, x: &[f64], _action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        let (n, k) = (x.len(), u.len());
        let mut stack = [0.0; STACK_VARIABLES];
        let mut heap = Vec::new();
        let z = if 2 * n + k < STACK_VARIABLES {
            &mut stack[..=2 * n + k]
        } else {
            heap.resize(2 * n + k + 1, 0.0);
            &mut heap[..]
        };
        z[..n].copy_from_slice(x);
        z[n..n + k].copy_from_slice(u);
        z[n + k..2 * n + k].copy_from_slice(next);
        z[2 * n + k] = f64::from(u8::from(self.terminated(next)));
        self.fold(&mut z[..n]);
        self.fold(&mut z[n + k..2 * n + k]);
        self.reward.eval(z)
    }

    fn terminated(&self, next: &[f64]) -> bool {
        let Some(condition) = &self.terminated else { return false };
        if self.folded.is_empty() {
            return condition.holds(next);
        }
        let mut next = next.to_vec();
        self.fold(&mut next);
        condition.holds(&next)
    }

    fn draw(&self, rng: &mut Rng) -> Option<Arc<dyn Task>> {
        self.drawn(rng).map(|task| Arc::new(task) as Arc<dyn Task>)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use sindyna_core::{Channel, Precision};

    fn spec() -> Spec {
        let state = vec![Channel::new("th", "rad", Kind::Angle, 1.0), Channel::new("w", "rad/s", Kind::RateOf(0), 1.0)];
        let seen = |name, kind| Channel::new(name, "", kind, 1.0);
        Spec {
            name: "any".into(),
            observation: vec![seen("c", Kind::CosOf(0)), seen("s", Kind::SinOf(0)), state[1].clone()],
            state,
            control: vec![Channel::new("u", "", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.1,
        }
    }

    fn task(reward: &str, terminated: Option<&str>) -> Result<FormulaTask, Error> {
        FormulaTask::new(spec(), 10, vec![(0.0, 0.0); 2], reward, terminated)
    }

    #[test]
    fn a_reward_knows_the_step_and_whether_it_ended_the_episode() {
        let task = task("10*terminated - w*u + next_w", Some("next_w > 3 and next_th < 1")).unwrap();
        assert_eq!(task.reward(&[0.0, 2.0], &[9.0], &[0.5], &[0.0, 2.5]), 1.5);
        assert_eq!(task.reward(&[0.0, 2.0], &[9.0], &[0.5], &[0.0, 4.0]), 13.0);
    }

    #[test]
    fn formulas_see_no_turns_of_angles_that_are_seen_as_cosine_and_sine() {
        let turned = [0.5 + 2.0 * TAU, 0.0];
        let plain = task("-th", Some("next_th > 3")).unwrap();
        assert_eq!((plain.reward(&turned, &[0.0], &[0.0], &turned), plain.terminated(&turned)), (-turned[0], true));
        let folded = plain.with_folded_angles();
        assert!((folded.reward(&turned, &[0.0], &[0.0], &turned) + 0.5).abs() < 1e-12 && !folded.terminated(&turned));
    }

    #[test]
    fn formulas_that_cannot_be_read_are_told() {
        for (reward, terminated, says) in
            [("-x", None, "reward: "), ("-th", Some("w > 1"), "terminated, a condition on the state after the step: ")]
        {
            let refusal = task(reward, terminated).unwrap_err().to_string();
            assert!(refusal.contains(says), "{refusal}");
        }
    }
}
