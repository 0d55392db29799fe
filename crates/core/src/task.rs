//! What is to be achieved, and what the agent is told about it.

use std::sync::Arc;

use crate::{Rng, Spec};

/// Start states, reward and termination: the part of a problem the agent is allowed to know (Arora et al. 2022, §3:
/// "known reward function"). Nothing about walls, friction or motion belongs here.
pub trait Task: Send + Sync {
    /// Names, bounds, time step.
    fn spec(&self) -> &Spec;

    /// Steps after which an episode is truncated: the horizon of the return that is to be predicted.
    fn max_steps(&self) -> usize;

    /// Draws a start state into `x` (n).
    fn initial(&self, rng: &mut Rng, x: &mut [f64]);

    /// Reward of the step from `x` (n) under `action` (control `u`) to `next` (n).
    fn reward(&self, x: &[f64], action: &[f64], u: &[f64], next: &[f64]) -> f64;

    /// Whether arriving in `next` (n) ends the episode for good.
    fn terminated(&self, next: &[f64]) -> bool;

    /// A task as likely as this one, where start states are known from a sample alone: reward and end are the same, start states are drawn from their
    /// posterior. `None`, and no random number is drawn, where they are known.
    fn draw(&self, _rng: &mut Rng) -> Option<Arc<dyn Task>> {
        None
    }
}

/// A task with something else declared about its system, such as noise on its sensors. Start states, reward and
/// termination, which are of the state and not of what is observed, remain.
#[derive(Debug, Clone)]
pub struct Redeclared<T> {
    task: T,
    spec: Spec,
}

impl<T: Task> Redeclared<T> {
    /// `task` with its spec changed by `change`; channels must remain in number and meaning.
    pub fn new(task: T, change: impl FnOnce(&mut Spec)) -> Self {
        let mut spec = task.spec().clone();
        change(&mut spec);
        Self { task, spec }
    }
}

impl<T: Task> Task for Redeclared<T> {
    fn spec(&self) -> &Spec {
        &self.spec
    }
    fn max_steps(&self) -> usize {
        self.task.max_steps()
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        self.task.initial(rng, x);
    }
    fn reward(&self, x: &[f64], action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        self.task.reward(x, action, u, next)
    }
    fn terminated(&self, next: &[f64]) -> bool {
        self.task.terminated(next)
    }
    fn draw(&self, rng: &mut Rng) -> Option<Arc<dyn Task>> {
        let task = self.task.draw(rng)?;
        Some(Arc::new(Redeclared { task, spec: self.spec.clone() }))
    }
}

impl<T: Task + ?Sized> Task for &T {
    fn spec(&self) -> &Spec {
        (**self).spec()
    }
    fn max_steps(&self) -> usize {
        (**self).max_steps()
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        (**self).initial(rng, x);
    }
    fn reward(&self, x: &[f64], action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        (**self).reward(x, action, u, next)
    }
    fn terminated(&self, next: &[f64]) -> bool {
        (**self).terminated(next)
    }
    fn draw(&self, rng: &mut Rng) -> Option<Arc<dyn Task>> {
        (**self).draw(rng)
    }
}

impl<T: Task + ?Sized> Task for Arc<T> {
    fn spec(&self) -> &Spec {
        (**self).spec()
    }
    fn max_steps(&self) -> usize {
        (**self).max_steps()
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        (**self).initial(rng, x);
    }
    fn reward(&self, x: &[f64], action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        (**self).reward(x, action, u, next)
    }
    fn terminated(&self, next: &[f64]) -> bool {
        (**self).terminated(next)
    }
    fn draw(&self, rng: &mut Rng) -> Option<Arc<dyn Task>> {
        (**self).draw(rng)
    }
}
