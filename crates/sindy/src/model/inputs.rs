//! Inputs over the steps of a simulation.

use ndarray::{ArrayView2, s};
use sindyna_core::InterSample;

/// Inputs over T steps.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// At the beginning of each step (T, k).
    pub start: ArrayView2<'a, f64>,
    /// At the end of each step (T, k); `None` for zero-order hold.
    pub end: Option<ArrayView2<'a, f64>>,
    /// How they change over each step, if they do.
    pub intersample: InterSample,
}

impl<'a> From<ArrayView2<'a, f64>> for Inputs<'a> {
    fn from(start: ArrayView2<'a, f64>) -> Self {
        Self { start, end: None, intersample: InterSample::Zoh }
    }
}

impl Inputs<'_> {
    /// Steps `from` to `to`, that one excluded.
    pub(super) fn part(&self, from: usize, to: usize) -> Inputs<'_> {
        Inputs {
            start: self.start.slice(s![from..to, ..]),
            end: self.end.as_ref().map(|end| end.slice(s![from..to, ..])),
            intersample: self.intersample,
        }
    }
}
