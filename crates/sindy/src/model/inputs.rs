//! Inputs over the steps of a simulation.

use ndarray::{ArrayView2, s};

/// Inputs over T steps: held, linear from the beginning of each step to its end, or switched within each step.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// At the beginning of each step (T, k).
    pub start: ArrayView2<'a, f64>,
    /// At the end of each step (T, k); `None` for zero-order hold.
    pub end: Option<ArrayView2<'a, f64>>,
    /// The part of each step (0 to 1) after which inputs become those at its end, at once; `None` if they change linearly.
    pub switch: Option<f64>,
}

impl<'a> From<ArrayView2<'a, f64>> for Inputs<'a> {
    fn from(start: ArrayView2<'a, f64>) -> Self {
        Self { start, end: None, switch: None }
    }
}

impl Inputs<'_> {
    /// Steps `from` to `to`, that one excluded.
    pub(super) fn part(&self, from: usize, to: usize) -> Inputs<'_> {
        Inputs {
            start: self.start.slice(s![from..to, ..]),
            end: self.end.as_ref().map(|end| end.slice(s![from..to, ..])),
            switch: self.switch,
        }
    }
}
