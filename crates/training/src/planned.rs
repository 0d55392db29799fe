//! Policies that plan: made again from a record, and timed.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_control::{Method, Planners};
use sindyna_core::{Memory, Mode, Policy, Rng};
use sindyna_sindy::Model;

use crate::Error;
use crate::problem::Problem;

/// The planner called `name` in `model`, as a run had it, for measurements of the states with errors of the standard deviations `noise` (none for exact ones);
/// `None` if there is none of that name.
pub fn planner(
    problem: &dyn Problem,
    name: &str,
    model: Model,
    noise: &[f64],
) -> Result<Option<impl Policy + use<>>, Error> {
    let Some(method) = Method::ALL.into_iter().find(|method| method.name() == name) else { return Ok(None) };
    let planners = Planners::new(&[method], problem.task(), Arc::default())?;
    Ok(Some(planners.planner(method, Arc::new(model), noise)?))
}

/// A policy whose actions are timed.
pub struct Timed<'a> {
    policy: &'a dyn Policy,
    seconds: Mutex<Vec<f64>>,
}

impl<'a> Timed<'a> {
    /// `policy` with a clock.
    pub fn new(policy: &'a dyn Policy) -> Self {
        Self { policy, seconds: Mutex::default() }
    }

    fn note(&self, begun: Instant) {
        self.seconds.lock().unwrap_or_else(PoisonError::into_inner).push(begun.elapsed().as_secs_f64());
    }

    /// Median of the seconds of an action, and of a policy that plans the largest; `None` where none was timed.
    pub fn seconds(self) -> (Option<f64>, Option<f64>) {
        let mut seconds = self.seconds.into_inner().unwrap_or_else(PoisonError::into_inner);
        seconds.sort_by(f64::total_cmp);
        let slowest = seconds.last().copied().filter(|_| self.policy.begin().is_some());
        (seconds.get(seconds.len() / 2).copied(), slowest)
    }
}

impl Policy for Timed<'_> {
    fn act_batch(&self, observations: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, actions: ArrayViewMut2<'_, f64>) {
        let (count, begun) = (observations.nrows(), Instant::now());
        self.policy.act_batch(observations, mode, rng, actions);
        // Of many at once the time of one is not known.
        if count == 1 {
            self.note(begun);
        }
    }

    fn begin(&self) -> Option<Box<dyn Memory + '_>> {
        Some(Box::new(TimedMemory { memory: self.policy.begin()?, of: self }))
    }
}

/// A memory whose actions are timed.
struct TimedMemory<'a> {
    memory: Box<dyn Memory + 'a>,
    of: &'a Timed<'a>,
}

impl Memory for TimedMemory<'_> {
    fn act(&mut self, observation: &[f64], mode: Mode, rng: &mut Rng, action: &mut [f64]) {
        let begun = Instant::now();
        self.memory.act(observation, mode, rng, action);
        self.of.note(begun);
    }
}
