//! A task whose reward and end are formulas.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use rand::RngExt as _;
use sindyna_core::{Kind, Rng, Space, Spec, Task};
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
    pub(crate) spec: Spec,
    /// Range of start values of each state.
    start: Vec<(f64, f64)>,
    /// Over z = (x; u; x'; ended).
    reward: Expr,
    /// What stands for z in formulas.
    names: Vec<String>,
    /// Over x'.
    terminated: Option<Condition>,
    /// States of which formulas see the value between −π and π.
    folded: Vec<usize>,
    /// The first reward that was no finite number: a [`Task`] has no other way to say so.
    complaint: OnceLock<String>,
}

impl FormulaTask {
    /// The task on the system `spec` whose states begin uniformly in the ranges `start` (n). `reward` is a formula over states, controls, states after
    /// the step (`next_x`) and `terminated` (1 where the step ended the episode, else 0); `terminated` a condition such as `abs(next_x) > 2 or next_v < 1`.
    ///
    /// # Errors
    /// [`Error::System`] if a formula cannot be read.
    pub fn new(spec: Spec, start: Vec<(f64, f64)>, reward: &str, terminated: Option<&str>) -> Result<Self, Error> {
        let (states, controls) = (spec.state.iter().map(|s| &s.name), spec.control.iter().map(|u| &u.name));
        let after: Vec<String> = states.clone().map(|name| format!("next_{name}")).collect();
        let names = states.chain(controls).chain(&after).cloned().chain([ENDED.to_owned()]).collect::<Vec<_>>();
        let name = spec.name.clone();
        let refused = |what: &str, why: String| Error::System { name: name.clone(), why: format!("{what}: {why}") };
        let reward = parse(reward, &names).map_err(|e| refused("reward", e.to_string()))?;
        let terminated = terminated.map(|text| Condition::parse(text, &after)).transpose();
        let terminated =
            terminated.map_err(|e| refused("terminated, a condition on the state after the step", format!("{e:#}")))?;
        let folded = Vec::new();
        Ok(Self { spec, start, reward, names, terminated, folded, complaint: OnceLock::new() })
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

    /// The first reward that was no finite number, and where.
    #[must_use]
    pub fn complaint(&self) -> Option<&str> {
        self.complaint.get().map(String::as_str)
    }

    fn complain(&self, z: &[f64], reward: f64) {
        self.complaint.get_or_init(|| {
            let at: Vec<String> = self.names.iter().zip(z).map(|(name, v)| format!("{name} = {v}")).collect();
            let (name, formula) = (&self.spec.name, self.reward.display(&self.names));
            format!("the reward of `{name}`, `{formula}`, is {reward} at {}", at.join(", "))
        });
    }

    /// Tries the reward at `times` start states under random controls; what is wrong with it is in [`Self::complaint`] then.
    pub(crate) fn try_reward(&self, times: usize, rng: &mut Rng) {
        let Space::Box { low, high } = &self.spec.action_space else { return };
        let (mut x, mut u) = (vec![0.0; self.spec.state_dim()], vec![0.0; self.spec.control_dim()]);
        for _ in 0..times {
            self.initial(rng, &mut x);
            for ((value, &low), &high) in u.iter_mut().zip(low).zip(high) {
                *value = rng.random_range(low..=high);
            }
            self.reward(&x, &u, &u, &x);
        }
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
        let reward = self.reward.eval(z);
        if !reward.is_finite() {
            self.complain(z, reward);
        }
        reward
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
}

#[cfg(test)]
mod tests {
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
            max_steps: 10,
            solved_at: None,
        }
    }

    fn task(reward: &str, terminated: Option<&str>) -> Result<FormulaTask, Error> {
        FormulaTask::new(spec(), vec![(0.0, 0.0); 2], reward, terminated)
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
