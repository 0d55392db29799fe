//! Consecutive samples with nothing between them but the equations of motion.

use ndarray::{Array2, s};

use crate::motion::Run;

/// Consecutive samples of one trajectory.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    /// States (T + 1, n).
    pub(crate) x: Array2<f64>,
    /// Controls (T, k), each held from one sample to the next.
    pub(crate) u: Array2<f64>,
    /// Time from each sample to the next \[s\] (T).
    pub(crate) dt: Vec<f64>,
    /// Standard deviation of the error of each sample, relative to that of its channel (T + 1, n); `None` if all are the same.
    pub(crate) relative: Option<Array2<f64>>,
}

impl Segment {
    /// The samples of `run`, `dt` \[s\] apart.
    pub(crate) fn even(run: &Run, dt: f64) -> Self {
        Self { x: run.x.clone(), u: run.u.clone(), dt: vec![dt; run.len()], relative: None }
    }

    /// Number of steps T.
    pub(crate) fn len(&self) -> usize {
        self.u.nrows()
    }

    /// Steps `first` to `last`, that one excluded.
    pub(crate) fn part(&self, first: usize, last: usize) -> Self {
        Self {
            x: self.x.slice(s![first..=last, ..]).to_owned(),
            u: self.u.slice(s![first..last, ..]).to_owned(),
            dt: self.dt[first..last].to_vec(),
            relative: self.relative.as_ref().map(|r| r.slice(s![first..=last, ..]).to_owned()),
        }
    }

    /// Σ ln w² of the relative standard deviations w of all samples.
    pub(crate) fn log_variances(&self) -> f64 {
        self.relative.as_ref().map_or(0.0, |r| r.iter().map(|w| 2.0 * w.ln()).sum())
    }

    /// Standard deviation of the error of sample `t` of state `i`, relative to that of the channel.
    pub(crate) fn relative(&self, t: usize, i: usize) -> f64 {
        self.relative.as_ref().map_or(1.0, |r| r[[t, i]])
    }
}
