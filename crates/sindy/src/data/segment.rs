//! Consecutive samples with nothing between them but the equations of motion.

use ndarray::Array2;

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
    /// Number of steps T.
    pub(crate) fn len(&self) -> usize {
        self.u.nrows()
    }
}
