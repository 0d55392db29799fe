//! Transitions kept for replay.

use std::{hint::black_box, ops::Range};

use ndarray::{Array1, Array2};
use rand::RngExt as _;
use serde::{Deserialize, Serialize};

use crate::{CheckpointError, Rng};

/// One step of experience, borrowed.
#[derive(Debug, Clone, Copy)]
pub struct Transition<'a> {
    /// Observation before the step (m).
    pub observation: &'a [f64],
    /// Action chosen.
    pub action: &'a [f64],
    /// Reward of the step.
    pub reward: f64,
    /// Observation after the step (m).
    pub next_observation: &'a [f64],
    /// The task ended for good; a truncated step is *not* marked here, so that its value bootstraps.
    pub terminated: bool,
}

/// B transitions drawn for one update.
#[derive(Debug, Clone)]
pub struct Batch {
    /// Observations before the step (B, m).
    pub observations: Array2<f64>,
    /// Actions chosen (B, action values).
    pub actions: Array2<f64>,
    /// Rewards (B).
    pub rewards: Array1<f64>,
    /// Observations after the step (B, m).
    pub next_observations: Array2<f64>,
    /// 1 where the task ended for good, else 0 (B).
    pub terminated: Array1<f64>,
}

impl Batch {
    /// A batch of `size` zero rows, to be filled by [`Replay::sample_into`].
    #[must_use]
    pub fn zeros(size: usize, observation_dim: usize, action_dim: usize) -> Self {
        Self {
            observations: Array2::zeros((size, observation_dim)),
            actions: Array2::zeros((size, action_dim)),
            rewards: Array1::zeros(size),
            next_observations: Array2::zeros((size, observation_dim)),
            terminated: Array1::zeros(size),
        }
    }

    /// Number of transitions B.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rewards.len()
    }

    /// Whether there is nothing in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rewards.is_empty()
    }
}

/// Transitions drawn before any is copied: they come from far memory all at the same time, not one after the other.
const AHEAD: usize = 32;

/// Number of the system among those that make transitions; models are counted from one.
const REAL: u32 = 0;

/// A ring of the newest transitions, all of one width, each with the model that made it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Replay {
    capacity: usize,
    observation_dim: usize,
    action_dim: usize,
    /// Each row: observation, action, reward, next observation, terminated.
    rows: Vec<f64>,
    /// Number of the model that imagined each row; [`REAL`] for none.
    models: Vec<u32>,
    width: usize,
    pushed: usize,
}

impl Replay {
    /// Room for `capacity` transitions (at least one).
    #[must_use]
    pub fn new(capacity: usize, observation_dim: usize, action_dim: usize) -> Self {
        let width = 2 * observation_dim + action_dim + 2;
        Self {
            capacity: capacity.max(1),
            observation_dim,
            action_dim,
            rows: Vec::new(),
            models: Vec::new(),
            width,
            pushed: 0,
        }
    }

    /// Keeps a transition of the system; the oldest one makes room when the ring is full.
    pub fn push(&mut self, t: Transition<'_>) {
        self.push_of(REAL, t);
    }

    /// The same for a transition that `model`, the number of a fit from 1 on, imagined.
    pub fn push_imagined(&mut self, model: u32, t: Transition<'_>) {
        self.push_of(model.max(REAL + 1), t);
    }

    fn push_of(&mut self, model: u32, t: Transition<'_>) {
        let row = t.observation.iter().chain(t.action).chain([&t.reward]).chain(t.next_observation);
        let row = row.copied().chain([f64::from(u8::from(t.terminated))]);
        let index = self.pushed % self.capacity;
        let slot = index * self.width;
        if slot == self.rows.len() {
            self.rows.extend(row);
            self.models.push(model);
        } else {
            self.models[index] = model;
            for (kept, value) in self.rows[slot..slot + self.width].iter_mut().zip(row) {
                *kept = value;
            }
        }
        self.pushed += 1;
    }

    /// Refuses to stand for `other` unless it has its room, for transitions as wide.
    ///
    /// # Errors
    /// [`CheckpointError`] with what differs.
    pub fn check(&self, other: &Self) -> Result<(), CheckpointError> {
        CheckpointError::expect_len("transitions of room", other.capacity, self.capacity)?;
        CheckpointError::expect_len("observed values", other.observation_dim, self.observation_dim)?;
        CheckpointError::expect_len("action values", other.action_dim, self.action_dim)?;
        CheckpointError::expect_len("values of transitions", self.len() * other.width, self.rows.len())?;
        CheckpointError::expect_len("models of transitions", self.len(), self.models.len())?;
        CheckpointError::expect_len("values of a transition", other.width, self.width)
    }

    /// Forgets what models before number `model` imagined. Real transitions stay; those `made_room`, the oldest, come back.
    pub fn forget_before<'a>(&mut self, model: u32, made_room: impl Iterator<Item = Transition<'a>>) {
        let mut kept = Self::new(self.capacity, self.observation_dim, self.action_dim);
        made_room.for_each(|transition| kept.push(transition));
        let oldest = self.pushed.saturating_sub(self.capacity);
        for index in (oldest..self.pushed).map(|age| age % self.capacity) {
            let made_by = self.models[index];
            if made_by == REAL || made_by >= model {
                kept.push_of(made_by, self.transition(index));
            }
        }
        *self = kept;
    }

    fn transition(&self, index: usize) -> Transition<'_> {
        let (observation, rest) = self.rows[index * self.width..][..self.width].split_at(self.observation_dim);
        let (action, rest) = rest.split_at(self.action_dim);
        let next_observation = &rest[1..=self.observation_dim];
        let terminated = rest[1 + self.observation_dim] > 0.0;
        Transition { observation, action, reward: rest[0], next_observation, terminated }
    }

    /// Real transitions kept now.
    #[must_use]
    pub fn n_real(&self) -> usize {
        self.models.iter().filter(|model| **model == REAL).count()
    }

    /// Transitions there is room for.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Transitions kept now.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pushed.min(self.capacity)
    }

    /// Whether nothing is kept.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pushed == 0
    }

    /// The observation (m) before a transition drawn uniformly; `None` when nothing is kept.
    pub fn sample_observation(&self, rng: &mut Rng) -> Option<&[f64]> {
        if self.is_empty() {
            return None;
        }
        let slot = rng.random_range(0..self.len()) * self.width;
        Some(&self.rows[slot..slot + self.observation_dim])
    }

    /// Mean and standard deviation of each observation (m) before the transitions kept.
    #[must_use]
    pub fn observed(&self) -> Vec<(f64, f64)> {
        let column = |j: usize| self.rows.chunks_exact(self.width).map(move |row| row[j]);
        let n = self.len().max(1) as f64;
        let of = |j: usize| {
            let mean = column(j).sum::<f64>() / n;
            (mean, (column(j).map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
        };
        (0..self.observation_dim).map(of).collect()
    }

    /// Fills `batch` with transitions drawn uniformly, with replacement. Leaves it as it is when nothing is kept.
    pub fn sample_into(&self, batch: &mut Batch, rng: &mut Rng) {
        self.sample_rows_into(batch, 0..batch.len(), rng);
    }

    /// The same for some `rows` of the batch, so that batches can be mixed.
    ///
    /// # Panics
    /// If the batch has fewer rows.
    pub fn sample_rows_into(&self, batch: &mut Batch, rows: Range<usize>, rng: &mut Rng) {
        if self.is_empty() {
            return;
        }
        let (m, k) = (self.observation_dim, self.action_dim);
        let Batch { observations, actions, rewards, next_observations, terminated } = batch;
        let [observations, actions, next_observations] = [observations, actions, next_observations].map(row_major);
        let mut slots = [0; AHEAD];
        for first in rows.clone().step_by(AHEAD) {
            let slots = &mut slots[..AHEAD.min(rows.end - first)];
            slots.fill_with(|| rng.random_range(0..self.len()) * self.width);
            // Both ends are read here only so that they are near when their turn comes.
            black_box(slots.iter().map(|slot| self.rows[*slot] + self.rows[slot + self.width - 1]).sum::<f64>());
            for (b, slot) in (first..).zip(slots.iter()) {
                let (before, rest) = self.rows[*slot..slot + self.width].split_at(m);
                let (action, rest) = rest.split_at(k);
                fill(&mut observations[b * m..(b + 1) * m], before);
                fill(&mut actions[b * k..(b + 1) * k], action);
                rewards[b] = rest[0];
                fill(&mut next_observations[b * m..(b + 1) * m], &rest[1..=m]);
                terminated[b] = rest[m + 1];
            }
        }
    }
}

/// The numbers of `table`, row after row; one that lies otherwise is laid so first.
fn row_major(table: &mut Array2<f64>) -> &mut [f64] {
    if !table.is_standard_layout() {
        *table = table.as_standard_layout().into_owned();
    }
    table.as_slice_mut().expect("the standard layout is row-major")
}

#[inline(always)]
fn fill(slots: &mut [f64], values: &[f64]) {
    for (slot, value) in slots.iter_mut().zip(values) {
        *slot = *value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    #[test]
    fn the_ring_keeps_the_newest_and_draws_them_evenly() {
        let mut replay = Replay::new(4, 1, 1);
        for i in 0..6 {
            let v = f64::from(i);
            replay.push(Transition {
                observation: &[v],
                action: &[10.0 * v],
                reward: -v,
                next_observation: &[v + 1.0],
                terminated: i == 5,
            });
        }
        assert_eq!(replay.len(), 4);
        let mut batch = Batch::zeros(4000, 1, 1);
        replay.sample_into(&mut batch, &mut Seed::new(3).numpy());
        let mut counts = [0; 6];
        for b in 0..batch.len() {
            let v = batch.observations[[b, 0]];
            counts[v as usize] += 1;
            assert_eq!(batch.actions[[b, 0]], 10.0 * v);
            assert_eq!(batch.rewards[b], -v);
            assert_eq!(batch.next_observations[[b, 0]], v + 1.0);
            assert_eq!(batch.terminated[b], f64::from(u8::from(v == 5.0)));
        }
        assert_eq!(counts[..2], [0, 0], "the two oldest made room");
        // 1000 expected, standard deviation 27.
        assert!(counts[2..].iter().all(|c| (870..1130).contains(c)), "{counts:?}");
    }

    /// A transition told from others by its observation.
    fn number(v: &[f64; 2]) -> Transition<'_> {
        Transition {
            observation: &v[..1],
            action: &[0.5],
            reward: -v[0],
            next_observation: &v[1..],
            terminated: v[0] > 2.0,
        }
    }

    #[test]
    fn what_older_models_imagined_is_forgotten_and_what_was_real_stays_in_order() {
        let steps = [[0.0, 1.0], [1.0, 2.0], [2.0, 3.0], [3.0, 4.0], [4.0, 5.0], [5.0, 6.0]];
        let mut replay = Replay::new(5, 1, 1);
        replay.push(number(&steps[0]));
        replay.push(number(&steps[1]));
        replay.push_imagined(1, number(&steps[2]));
        replay.push_imagined(2, number(&steps[3]));
        replay.push(number(&steps[4]));
        replay.push_imagined(2, number(&steps[5]));
        assert_eq!((replay.len(), replay.n_real()), (5, 2), "the first one made room");
        let mut newest = replay.clone();
        newest.forget_before(2, steps[..1].iter().map(number));
        let mut expected = Replay::new(5, 1, 1);
        expected.push(number(&steps[0]));
        expected.push(number(&steps[1]));
        expected.push_imagined(2, number(&steps[3]));
        expected.push(number(&steps[4]));
        expected.push_imagined(2, number(&steps[5]));
        assert_eq!((&newest.rows, &newest.models), (&expected.rows, &expected.models));
        newest.forget_before(3, std::iter::empty());
        assert_eq!((newest.len(), newest.n_real()), (3, 3));
        assert!((0..3).all(|i| newest.transition(i).observation[0] == [0.0, 1.0, 4.0][i]));
    }
}
