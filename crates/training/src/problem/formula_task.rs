//! A task whose reward and end are formulas.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use rand::RngExt as _;
use sindyna_core::{Channel, EnvError, Kind, Prior, Rng, Space, Spec, Task};
use sindyna_sindy::{Expr, parse};

use super::condition::Condition;
use crate::Error;

/// Variables of a reward held on the stack; larger systems fall back to the heap.
const STACK_VARIABLES: usize = 64;

/// The variable of a reward that is 1 where the step ended the episode, else 0.
const ENDED: &str = "terminated";

/// A task with ranges of start values, a reward and an end that are formulas.
#[derive(Debug, Clone)]
pub struct FormulaTask {
    /// What is declared of the system.
    pub spec: Spec,
    max_steps: usize,
    /// Range of start values of each state.
    start: Vec<(f64, f64)>,
    /// Samples of start states from which the range of each state was estimated; `None` where it is known.
    samples: Vec<Option<usize>>,
    /// Over z = (x; u; x'; ended).
    reward: Expr,
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
        Self::defined(spec, max_steps, start, (reward, terminated), &[])
    }

    /// The same with `definitions`: names for terms of the states (n). In formulas `next_` and such a name is its value after the step.
    pub fn defined(
        spec: Spec,
        max_steps: usize,
        start: Vec<(f64, f64)>,
        (reward, terminated): (&str, Option<&str>),
        definitions: &[(String, Expr)],
    ) -> Result<Self, Error> {
        let (states, controls) = (spec.state.iter().map(|s| &s.name), spec.control.iter().map(|u| &u.name));
        let (n, k, d) = (spec.state_dim(), spec.control_dim(), definitions.len());
        let after = |name: &String| format!("next_{name}");
        let defined = definitions.iter().map(|(name, _)| name);
        let mut names: Vec<String> = states.clone().chain(controls).cloned().chain(states.clone().map(after)).collect();
        names.push(ENDED.to_owned());
        names.extend(defined.clone().cloned().chain(defined.clone().map(after)));
        let after: Vec<String> = states.chain(defined).map(after).collect();
        let name = spec.name.clone();
        let refused = |what: &str, why: String| Error::System { name: name.clone(), why: format!("{what}: {why}") };
        let reward = parse(reward, &names).map_err(|e| refused("reward", e.to_string()))?;
        let reward = reward.replaced(&|i| match i.checked_sub(2 * n + k + 1)? {
            i if i < d => Some(definitions[i].1.clone()),
            i => Some(definitions[i - d].1.replaced(&|state| Some(Expr::Variable(n + k + state)))),
        });
        let terminated = terminated.map(|text| Condition::parse(text, &after)).transpose();
        let terminated =
            terminated.map_err(|e| refused("terminated, a condition on the state after the step", format!("{e:#}")))?;
        let terminated = terminated.map(|t| t.replaced(&|i| i.checked_sub(n).map(|i| definitions[i].1.clone())));
        let folded = Vec::new();
        let samples = vec![None; start.len()];
        Ok(Self { spec, max_steps, start, samples, reward, terminated, folded })
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
        Self { samples, ..self }
    }

    /// The same task with ranges of start values drawn from their posterior; `None` where all are known.
    ///
    /// The range W of n samples of a uniform distribution on \[a, b\] has the posterior W / (b − a) ~ Beta(n − 1, 2) under the prior 1 / (b − a), which is the
    /// second largest of n uniform numbers; what b − a has more is anywhere on both sides.
    #[must_use]
    pub fn drawn(&self, rng: &mut Rng) -> Option<Self> {
        let mut drawn = self.clone();
        let mut differs = false;
        for (i, samples) in self.samples.iter().enumerate() {
            let (low, high) = self.start[i];
            let Some(n) = samples.filter(|n| *n > 2 && high > low).map(|n| n as f64) else { continue };
            differs = true;
            let (middle, seen) = (0.5 * (low + high), (high - low) * (n - 1.0) / (n + 1.0));
            let share = rng.random::<f64>().powf(1.0 / n) * rng.random::<f64>().powf(1.0 / (n - 1.0));
            let (more, left) = (seen * (1.0 / share - 1.0), rng.random::<f64>());
            let Channel { kind, prior: Prior { bounds, .. }, .. } = self.spec.state[i];
            let range = (middle - 0.5 * seen - left * more, middle + 0.5 * seen + (1.0 - left) * more);
            let turn = kind == Kind::Angle && range.1 - range.0 > TAU;
            drawn.start[i] = if turn { (-PI, PI) } else { (range.0.max(bounds.0), range.1.min(bounds.1)) };
        }
        differs.then_some(drawn)
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
            x[i] = (x[i] + PI).rem_euclid(TAU) - PI;
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
        for (value, &(low, high)) in x.iter_mut().zip(&self.start) {
            *value = rng.random_range(low..=high);
        }
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
    use super::*;
    use sindyna_core::{Precision, Seed};

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
    fn ranges_drawn_hold_the_true_ones_as_often_as_their_posterior_says() {
        let mut rng = Seed::new(3).numpy();
        let (runs, n) = (2_000, 5);
        let mut below = 0;
        for _ in 0..runs {
            let samples: Vec<f64> = (0..n).map(|_| rng.random_range(1.0..3.0)).collect();
            let (low, high) = samples.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (v.min(l), v.max(h)));
            let wider = 0.5 * (high - low) * ((n + 1) as f64 / (n - 1) as f64 - 1.0);
            let estimated = FormulaTask::new(spec(), 10, vec![(low - wider, high + wider), (0.0, 0.0)], "-th", None);
            let estimated = estimated.unwrap().with_estimated_starts(vec![Some(n), Some(n)]);
            let drawn = estimated.drawn(&mut rng).unwrap();
            assert!(drawn.start[0].0 <= low && high <= drawn.start[0].1, "what was seen is possible");
            assert_eq!(drawn.start[1], (0.0, 0.0), "what never differs stays");
            below += u32::from(drawn.start[0].1 - drawn.start[0].0 < 2.0);
        }
        // A width drawn from the posterior is below the true one every second time: both are as likely. Standard error 0.011.
        let share = f64::from(below) / f64::from(runs);
        assert!((share - 0.5).abs() < 0.04, "{share}");
        assert!(task("-th", None).unwrap().drawn(&mut rng).is_none(), "known ranges are");
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
