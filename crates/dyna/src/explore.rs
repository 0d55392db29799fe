//! Warm-up policies that know nothing but the action space.

use rand::RngExt as _;
use sindyna_core::{Dataset, Explorer, Rng, Space, Spec};

/// Independent actions, uniform over the action space.
#[derive(Debug, Clone)]
pub struct Uniform {
    space: Space,
}

impl Uniform {
    /// Explores the action space of `spec`.
    #[must_use]
    pub fn new(spec: &Spec) -> Self {
        Self { space: spec.action_space.clone() }
    }
}

impl Explorer for Uniform {
    fn next(&mut self, _so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        uniform_action(&self.space, rng, action);
    }
}

/// Pushes in alternating directions, with occasional random ones: what keeps a balancing system alive longest
/// (Arora et al. 2022, §4, "Discrete Classic").
///
/// Real actions alternate in sign and have a uniformly random size; numbered actions alternate between the first and
/// the last.
#[derive(Debug, Clone)]
pub struct Alternating {
    space: Space,
    random_share: f64,
    forward: bool,
}

impl Alternating {
    /// Explores the action space of `spec`; `random_share` (0 to 1) of the actions are uniformly random.
    #[must_use]
    pub fn new(spec: &Spec, random_share: f64) -> Self {
        Self { space: spec.action_space.clone(), random_share, forward: false }
    }
}

impl Explorer for Alternating {
    fn next(&mut self, _so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        self.forward = !self.forward;
        if rng.random_bool(self.random_share) {
            return uniform_action(&self.space, rng, action);
        }
        match &self.space {
            Space::Box { low, high } => {
                for ((a, &low), &high) in action.iter_mut().zip(low).zip(high) {
                    let middle = 0.5 * (low + high);
                    *a = rng.random_range(if self.forward { middle..=high } else { low..=middle });
                }
            }
            Space::Discrete { controls } => action[0] = if self.forward { controls.nrows() as f64 - 1.0 } else { 0.0 },
        }
    }
}

/// Draws an action uniformly from `space`.
pub(crate) fn uniform_action(space: &Space, rng: &mut Rng, action: &mut [f64]) {
    match space {
        Space::Box { low, high } => {
            for ((a, &low), &high) in action.iter_mut().zip(low).zip(high) {
                *a = rng.random_range(low..=high);
            }
        }
        Space::Discrete { controls } => action[0] = rng.random_range(0..controls.nrows()) as f64,
    }
}
