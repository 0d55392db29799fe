//! A task whose reward and end are formulas.

use std::sync::OnceLock;

use rand::RngExt as _;
use sindyna_core::{Rng, Space, Spec, Task};
use sindyna_sindy::Expr;

use super::condition::Condition;

/// Variables of a reward held on the stack; larger systems fall back to the heap.
const STACK_VARIABLES: usize = 64;

/// Start ranges, reward and end as a task file gives them.
#[derive(Clone)]
pub(super) struct FormulaTask {
    pub(super) spec: Spec,
    /// Range of start values of each state.
    pub(super) start: Vec<(f64, f64)>,
    /// Over z = (x; u; x').
    pub(super) reward: Expr,
    /// What stands for z in formulas.
    pub(super) names: Vec<String>,
    /// Over x'.
    pub(super) terminated: Option<Condition>,
    /// The first reward that was no finite number: a [`Task`] has no other way to say so.
    pub(super) complaint: OnceLock<String>,
}

impl FormulaTask {
    fn complain(&self, z: &[f64], reward: f64) {
        self.complaint.get_or_init(|| {
            let at: Vec<String> = self.names.iter().zip(z).map(|(name, v)| format!("{name} = {v}")).collect();
            let (name, formula) = (&self.spec.name, self.reward.display(&self.names));
            format!("the reward of `{name}`, `{formula}`, is {reward} at {}", at.join(", "))
        });
    }

    /// Tries the reward at `times` start states under random controls; what is wrong with it is in `complaint` then.
    pub(super) fn try_reward(&self, times: usize, rng: &mut Rng) {
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
        let z = if 2 * n + k <= STACK_VARIABLES {
            &mut stack[..2 * n + k]
        } else {
            heap.resize(2 * n + k, 0.0);
            &mut heap[..]
        };
        z[..n].copy_from_slice(x);
        z[n..n + k].copy_from_slice(u);
        z[n + k..].copy_from_slice(next);
        let reward = self.reward.eval(z);
        if !reward.is_finite() {
            self.complain(z, reward);
        }
        reward
    }

    fn terminated(&self, next: &[f64]) -> bool {
        self.terminated.as_ref().is_some_and(|condition| condition.holds(next))
    }
}
