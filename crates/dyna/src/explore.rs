//! Policies that know nothing but the action space.

use ndarray::{ArrayView2, ArrayViewMut2};
use rand::RngExt as _;
use sindyna_core::{
    Checkpoint, CheckpointError, Dataset, End, Explorer, Mode, Policy, Rng, Space, Spec, decode, encode,
};

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

impl Checkpoint for Uniform {}

impl Explorer for Uniform {
    fn next(&mut self, _so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        uniform_action(&self.space, rng, action);
    }
}

impl Policy for Uniform {
    /// Draws anew for every observation, in either mode.
    fn act_batch(
        &self,
        observations: ArrayView2<'_, f64>,
        _mode: Mode,
        rng: &mut Rng,
        mut actions: ArrayViewMut2<'_, f64>,
    ) {
        let mut drawn = vec![0.0; self.space.action_dim()];
        for (_, mut action) in observations.rows().into_iter().zip(actions.rows_mut()) {
            uniform_action(&self.space, rng, &mut drawn);
            action.iter_mut().zip(&drawn).for_each(|(slot, value)| *slot = *value);
        }
    }
}

/// Small random actions around the middle of the action space, as a linear model of a system near its equilibrium wants them. Numbered actions
/// are drawn uniformly: there is no small one.
#[derive(Debug, Clone)]
pub struct Gentle {
    space: Space,
    share: f64,
}

impl Gentle {
    /// Explores the action space of `spec` within a `share` (0 to 1) of its range.
    #[must_use]
    pub fn new(spec: &Spec, share: f64) -> Self {
        Self { space: spec.action_space.clone(), share: share.clamp(0.0, 1.0) }
    }
}

impl Checkpoint for Gentle {}

impl Explorer for Gentle {
    fn next(&mut self, _so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        uniform_action(&self.space, rng, action);
        if let Space::Box { low, high } = &self.space {
            for ((a, low), high) in action.iter_mut().zip(low).zip(high) {
                let middle = 0.5 * (low + high);
                *a = middle + self.share * (*a - middle);
            }
        }
    }
}

/// One action, always.
#[derive(Debug, Clone)]
pub(crate) struct Holding(Vec<f64>);

impl Holding {
    /// The middle of a box and its ends in every direction; every numbered action.
    pub(crate) fn each(space: &Space) -> Vec<Self> {
        match space {
            Space::Discrete { controls } => (0..controls.nrows()).map(|row| Self(vec![row as f64])).collect(),
            Space::Box { low, high } => {
                let middle: Vec<f64> = low.iter().zip(high).map(|(low, high)| 0.5 * (low + high)).collect();
                let with = |(i, value): (usize, f64)| {
                    let mut action = middle.clone();
                    action[i] = value;
                    Self(action)
                };
                let ends = low.iter().copied().enumerate().chain(high.iter().copied().enumerate());
                ends.map(with).chain([Self(middle.clone())]).collect()
            }
        }
    }
}

impl Policy for Holding {
    fn act_batch(
        &self,
        _observations: ArrayView2<'_, f64>,
        _mode: Mode,
        _rng: &mut Rng,
        mut actions: ArrayViewMut2<'_, f64>,
    ) {
        for mut action in actions.rows_mut() {
            action.iter_mut().zip(&self.0).for_each(|(slot, value)| *slot = *value);
        }
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

impl Checkpoint for Alternating {
    fn save(&self) -> Vec<u8> {
        encode(&self.forward)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        self.forward = decode(saved)?;
        Ok(())
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

/// Pushes one way for a while, then the other, as long as the system bears it; the default warm-up.
///
/// What tells one equation from another is a state that goes far: a push that stays on one side for some steps drives it
/// there, sizes that change with every step tell the push itself apart from everything that changes slowly. A system that
/// falls under this (an episode that ends by itself) is pushed in alternating directions from then on, which keeps it up
/// longer. Every input keeps its own time; numbered actions are held and exchanged alike, the first one more briefly.
#[derive(Debug, Clone)]
pub struct Swings {
    space: Space,
    /// Per action value: the side it is on, and the steps left there.
    sides: Vec<(bool, usize)>,
}

impl Swings {
    /// Explores the action space of `spec`.
    #[must_use]
    pub fn new(spec: &Spec) -> Self {
        Self { space: spec.action_space.clone(), sides: Vec::new() }
    }
}

/// Steps on one side, between these.
const SWING: std::ops::RangeInclusive<usize> = 6..=8;

/// The same for the first side where actions are numbered: a push that never changes cannot be told from what is always
/// there.
const FIRST_NUMBERED: std::ops::RangeInclusive<usize> = 3..=5;

/// Smallest push, as part of the largest.
const LEAST_PUSH: f64 = 0.5;

impl Checkpoint for Swings {
    fn save(&self) -> Vec<u8> {
        encode(&self.sides)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        self.sides = decode(saved)?;
        Ok(())
    }
}

impl Explorer for Swings {
    fn next(&mut self, so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        let fallen = so_far.rollouts().any(|rollout| rollout.end == End::Terminated);
        for (i, a) in action.iter_mut().enumerate() {
            let (high, left) = match self.sides.get(i) {
                Some(&(high, left)) if left > 0 && !fallen => (high, left),
                Some(&(high, _)) => (!high, rng.random_range(SWING)),
                None => {
                    let first = if matches!(self.space, Space::Box { .. }) { SWING } else { FIRST_NUMBERED };
                    (rng.random_bool(0.5), rng.random_range(first))
                }
            };
            match self.sides.get_mut(i) {
                Some(side) => *side = (high, left - 1),
                None => self.sides.push((high, left - 1)),
            }
            *a = match &self.space {
                Space::Box { low, high: top } => {
                    let (middle, reach) = (0.5 * (low[i] + top[i]), 0.5 * (top[i] - low[i]));
                    let push = reach * rng.random_range(LEAST_PUSH..=1.0);
                    if high { middle + push } else { middle - push }
                }
                Space::Discrete { controls } if high => controls.nrows() as f64 - 1.0,
                Space::Discrete { .. } => 0.0,
            };
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
