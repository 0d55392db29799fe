//! A signal in the trajectories of a log.

use ndarray::{Array1, ArrayView1};

use super::finding::At;
use crate::recording::{Recording, Source};

/// A trajectory, and when it began.
pub(super) struct Trajectory<'a> {
    pub(super) recording: &'a Recording,
    /// Since the first sample of its file \[s\].
    pub(super) start: f64,
}

/// One signal in all trajectories.
pub(super) struct Signal<'a> {
    pub(super) name: &'a str,
    /// Distance of neighbouring values, where it is known.
    pub(super) step: Option<f64>,
    pub(super) pieces: Vec<Piece<'a>>,
}

/// A signal in one trajectory.
pub(super) struct Piece<'a> {
    pub(super) trajectory: &'a Trajectory<'a>,
    pub(super) values: ArrayView1<'a, f64>,
}

impl Piece<'_> {
    /// When sample number `i` was taken \[s\].
    pub(super) fn seconds(&self, i: usize) -> f64 {
        let times = &self.trajectory.recording.times;
        self.trajectory.start + times.get(i).map_or(0.0, |t| t - times[0])
    }
}

/// Tells which file a trajectory is of, and when.
pub(super) struct Clock<'a> {
    pub(super) sources: &'a [Source<'a>],
}

impl Clock<'_> {
    pub(super) fn at(&self, table: usize, seconds: f64) -> At {
        let file = (self.sources.len() > 1).then(|| self.sources[table].path().to_owned());
        At { file, seconds }
    }

    pub(super) fn of(&self, piece: &Piece<'_>, i: usize) -> At {
        self.at(piece.trajectory.recording.table, piece.seconds(i))
    }
}

/// From each value to the next.
pub(super) fn differences(values: ArrayView1<'_, f64>) -> Array1<f64> {
    let n = values.len().saturating_sub(1);
    Array1::from_shape_fn(n, |i| values[i + 1] - values[i])
}

pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
