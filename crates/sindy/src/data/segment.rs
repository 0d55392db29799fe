//! Consecutive samples with nothing between them but the equations of motion.

use ndarray::Array2;

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
}

impl Segment {
    /// The samples of `run`, `dt` \[s\] apart.
    pub(crate) fn even(run: &Run, dt: f64) -> Self {
        Self { x: run.x.clone(), u: run.u.clone(), dt: vec![dt; run.len()] }
    }

    /// Number of steps T.
    pub(crate) fn len(&self) -> usize {
        self.u.nrows()
    }
}
