//! Recorded rollouts as contiguous rows with borders.

use ndarray::{ArrayView1, ArrayView2};
use serde::{Deserialize, Serialize};

use crate::{CheckpointError, InterSample, Transition};

/// How a rollout ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum End {
    /// The task ended for good.
    Terminated,
    /// The time limit was reached.
    Truncated,
    /// The recording stopped; the system could have gone on.
    Cut,
}

/// Rows that do not belong into a data set.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A row has the wrong number of values.
    #[error("{what} has {got} values, expected {expected}")]
    Width {
        /// Which row it is.
        what: &'static str,
        /// Values wanted.
        expected: usize,
        /// Values found.
        got: usize,
    },
    /// A value is NaN or infinite.
    #[error("{what} {index} is {value}, which is not finite")]
    NotFinite {
        /// Which row it is.
        what: &'static str,
        /// Position in the row.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// A step was pushed where no rollout was begun.
    #[error("a step needs a rollout: call `begin` first")]
    NotBegun,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Border {
    first_observation: usize,
    first_step: usize,
    end: End,
}

/// Rollouts of one system: T steps each, with T + 1 observations. Nothing is ever computed across a border.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Dataset {
    observation_dim: usize,
    control_dim: usize,
    action_dim: usize,
    dt: f64,
    /// Zero-order hold where nothing is written.
    #[serde(default)]
    intersample: InterSample,
    observations: Vec<f64>,
    controls: Vec<f64>,
    actions: Vec<f64>,
    rewards: Vec<f64>,
    borders: Vec<Border>,
}

/// One rollout of T steps.
#[derive(Debug, Clone, Copy)]
pub struct Rollout<'a> {
    /// Observations (T + 1, m).
    pub observations: ArrayView2<'a, f64>,
    /// Controls applied (T, k); row i is held from observation i to i + 1, or with first-order hold linear to row i + 1.
    pub controls: ArrayView2<'a, f64>,
    /// Actions chosen (T, action values).
    pub actions: ArrayView2<'a, f64>,
    /// Rewards (T).
    pub rewards: ArrayView1<'a, f64>,
    /// How it ended.
    pub end: End,
}

impl Dataset {
    /// An empty data set of samples `dt` \[s\] apart.
    #[must_use]
    pub fn new(observation_dim: usize, control_dim: usize, action_dim: usize, dt: f64) -> Self {
        Self {
            observation_dim,
            control_dim,
            action_dim,
            dt,
            intersample: InterSample::Zoh,
            observations: Vec::new(),
            controls: Vec::new(),
            actions: Vec::new(),
            rewards: Vec::new(),
            borders: Vec::new(),
        }
    }

    /// The same with inputs that are `intersample` between samples. What they are after the last step of a rollout with first-order hold is not known.
    #[must_use]
    pub fn with_intersample(self, intersample: InterSample) -> Self {
        Self { intersample, ..self }
    }

    /// The first `steps` of it; a rollout that goes on after them is [`End::Cut`].
    #[must_use]
    pub fn first(&self, steps: usize) -> Self {
        let mut part = self.clone();
        if steps >= self.n_steps() {
            return part;
        }
        let rollouts = self.borders.partition_point(|b| b.first_step < steps);
        let ends = self.borders.get(rollouts).is_some_and(|next| next.first_step == steps);
        part.borders.truncate(rollouts);
        if !ends {
            part.finish(End::Cut);
        }
        part.observations.truncate((steps + rollouts) * self.observation_dim);
        part.controls.truncate(steps * self.control_dim);
        part.actions.truncate(steps * self.action_dim);
        part.rewards.truncate(steps);
        part
    }

    /// The steps from number `first` on, as they are replayed.
    pub fn transitions(&self, first: usize) -> impl Iterator<Item = Transition<'_>> {
        let (m, k) = (self.observation_dim, self.action_dim);
        (first..self.n_steps()).map(move |step| {
            let next = self.borders.partition_point(|b| b.first_step <= step);
            let last = self.borders.get(next).map_or(self.n_steps(), |b| b.first_step);
            // A rollout has one observation more than steps.
            let observation = |at: usize| &self.observations[at * m..(at + 1) * m];
            Transition {
                observation: observation(step + next - 1),
                action: &self.actions[step * k..(step + 1) * k],
                reward: self.rewards[step],
                next_observation: observation(step + next),
                terminated: step + 1 == last && self.borders[next - 1].end == End::Terminated,
            }
        })
    }

    /// Refuses to stand for `other` unless its rows are as wide, and complete.
    ///
    /// # Errors
    /// [`CheckpointError`] with what differs.
    pub fn check(&self, other: &Self) -> Result<(), CheckpointError> {
        let (steps, rollouts) = (self.rewards.len(), self.borders.len());
        for (what, expected, got, rows, values) in [
            ("observed values", other.observation_dim, self.observation_dim, steps + rollouts, &self.observations),
            ("controls", other.control_dim, self.control_dim, steps, &self.controls),
            ("action values", other.action_dim, self.action_dim, steps, &self.actions),
        ] {
            CheckpointError::expect_len(what, expected, got)?;
            CheckpointError::expect_len(what, rows * got, values.len())?;
        }
        let borders = self.borders.iter().enumerate();
        let fits = |(i, b): (usize, &Border)| b.first_step <= steps && b.first_observation == b.first_step + i;
        if borders.clone().all(fits) && self.borders.is_sorted_by_key(|b| b.first_step) {
            return Ok(());
        }
        Err(CheckpointError::new("rollouts that overlap"))
    }

    /// Begins a rollout at `observation` (m).
    ///
    /// # Errors
    /// [`DatasetError::Width`] or [`DatasetError::NotFinite`].
    pub fn begin(&mut self, observation: &[f64]) -> Result<(), DatasetError> {
        check("observation", observation, self.observation_dim)?;
        self.borders.push(Border {
            first_observation: self.observations.len() / self.observation_dim.max(1),
            first_step: self.rewards.len(),
            end: End::Cut,
        });
        self.observations.extend_from_slice(observation);
        Ok(())
    }

    /// Adds a step to the rollout begun last.
    ///
    /// # Errors
    /// [`DatasetError`] for a wrong width, a value that is not finite, or a step before any `begin`.
    pub fn push(
        &mut self,
        action: &[f64],
        control: &[f64],
        reward: f64,
        next_observation: &[f64],
    ) -> Result<(), DatasetError> {
        if self.borders.is_empty() {
            return Err(DatasetError::NotBegun);
        }
        check("action", action, self.action_dim)?;
        check("control", control, self.control_dim)?;
        check("reward", &[reward], 1)?;
        check("observation", next_observation, self.observation_dim)?;
        self.actions.extend_from_slice(action);
        self.controls.extend_from_slice(control);
        self.rewards.push(reward);
        self.observations.extend_from_slice(next_observation);
        Ok(())
    }

    /// States how the rollout begun last ended; a rollout is [`End::Cut`] until then.
    pub fn finish(&mut self, end: End) {
        if let Some(border) = self.borders.last_mut() {
            border.end = end;
        }
    }

    /// The rollouts in the order they were recorded.
    pub fn rollouts(&self) -> impl ExactSizeIterator<Item = Rollout<'_>> {
        (0..self.borders.len()).map(|i| self.rollout(i))
    }

    fn rollout(&self, index: usize) -> Rollout<'_> {
        let border = &self.borders[index];
        let last_step = self.borders.get(index + 1).map_or(self.rewards.len(), |b| b.first_step);
        let steps = border.first_step..last_step;
        let observations = border.first_observation..border.first_observation + steps.len() + 1;
        Rollout {
            observations: rows(&self.observations, observations, self.observation_dim),
            controls: rows(&self.controls, steps.clone(), self.control_dim),
            actions: rows(&self.actions, steps.clone(), self.action_dim),
            rewards: ArrayView1::from(&self.rewards[steps]),
            end: border.end,
        }
    }

    /// Steps in all rollouts together.
    #[must_use]
    pub fn n_steps(&self) -> usize {
        self.rewards.len()
    }

    /// Number of rollouts.
    #[must_use]
    pub fn n_rollouts(&self) -> usize {
        self.borders.len()
    }

    /// Values in one observation, m.
    #[must_use]
    pub fn observation_dim(&self) -> usize {
        self.observation_dim
    }

    /// Number of inputs, k.
    #[must_use]
    pub fn control_dim(&self) -> usize {
        self.control_dim
    }

    /// Sampling interval \[s\].
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// What inputs do between samples.
    #[must_use]
    pub fn intersample(&self) -> InterSample {
        self.intersample
    }
}

fn check(what: &'static str, row: &[f64], expected: usize) -> Result<(), DatasetError> {
    if row.len() != expected {
        return Err(DatasetError::Width { what, expected, got: row.len() });
    }
    match row.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(DatasetError::NotFinite { what, index, value: row[index] }),
    }
}

fn rows(values: &[f64], range: std::ops::Range<usize>, width: usize) -> ArrayView2<'_, f64> {
    let slice = &values[range.start * width..range.end * width];
    ArrayView2::from_shape((range.len(), width), slice).expect("rows are pushed whole")
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn borders_separate_rollouts() {
        let mut data = Dataset::new(1, 1, 1, 0.1);
        data.begin(&[0.0]).expect("one value");
        data.push(&[1.0], &[0.5], -1.0, &[1.0]).expect("finite");
        data.push(&[2.0], &[0.5], -2.0, &[2.0]).expect("finite");
        data.finish(End::Terminated);
        data.begin(&[7.0]).expect("one value");
        data.push(&[3.0], &[0.5], -3.0, &[8.0]).expect("finite");

        let rollouts: Vec<_> = data.rollouts().collect();
        assert_eq!(rollouts[0].observations, array![[0.0], [1.0], [2.0]]);
        assert_eq!(rollouts[0].end, End::Terminated);
        assert_eq!(rollouts[1].observations, array![[7.0], [8.0]]);
        assert_eq!(rollouts[1].actions, array![[3.0]]);
        assert_eq!(rollouts[1].end, End::Cut);
        assert_eq!((data.n_steps(), data.n_rollouts()), (3, 2));
    }

    /// Rollouts of so many steps, the first of which ended for good; observations count up.
    fn counted(steps: &[usize]) -> Dataset {
        let mut data = Dataset::new(1, 1, 1, 0.1);
        for steps in steps {
            data.begin(&[data.observations.len() as f64]).expect("one value");
            for _ in 0..*steps {
                let next = data.observations.len() as f64;
                data.push(&[next], &[0.5], -next, &[next]).expect("finite");
            }
            if data.n_rollouts() == 1 {
                data.finish(End::Terminated);
            }
        }
        data
    }

    #[test]
    fn the_first_steps_are_what_was_recorded_until_then() {
        let whole = counted(&[2, 3]);
        for (steps, begun) in [(0, &[][..]), (2, &[2]), (3, &[2, 1]), (5, &[2, 3]), (9, &[2, 3])] {
            assert_eq!(whole.first(steps), counted(begun), "{steps} steps");
        }
        assert_eq!(whole.first(1).rollouts().map(|r| r.end).collect::<Vec<_>>(), [End::Cut]);
    }

    #[test]
    fn transitions_do_not_cross_borders() {
        let data = counted(&[2, 3]);
        let seen: Vec<_> =
            data.transitions(1).map(|t| (t.observation[0], t.next_observation[0], t.reward, t.terminated)).collect();
        let expected = [(1.0, 2.0, true), (3.0, 4.0, false), (4.0, 5.0, false), (5.0, 6.0, false)];
        assert_eq!(seen, expected.map(|(before, next, terminated)| (before, next, -next, terminated)));
        assert!(data.transitions(1).all(|t| t.action == t.next_observation));
    }

    #[test]
    fn bad_rows_are_refused_with_their_place() {
        let mut data = Dataset::new(2, 1, 1, 0.1);
        assert_eq!(data.push(&[0.0], &[0.0], 0.0, &[0.0, 0.0]), Err(DatasetError::NotBegun));
        assert_eq!(data.begin(&[0.0]), Err(DatasetError::Width { what: "observation", expected: 2, got: 1 }));
        let nan = data.begin(&[0.0, f64::NAN]).expect_err("NaN is refused");
        assert_eq!(nan.to_string(), "observation 1 is NaN, which is not finite");
        assert_eq!(data.n_rollouts(), 0);
    }
}
