//! What passes over the data cost.

use std::cell::Cell;

use super::Flow;
use crate::data::Segment;

/// Operations so far, of about a nanosecond each: counted, so that what is stopped by them does not depend on the machine.
#[derive(Debug, Default)]
pub(crate) struct Work(Cell<u64>);

/// Operations for a function or another node of the rates, for a number of their derivatives, for one of the elimination of states; and numbers of a
/// triangular factor for one operation. Measured on runs of the study `undeclared`.
const RATE: u64 = 5;
const SLOPE: u64 = 2;
const ROW: u64 = 3;
const FACTOR: u64 = 4;

impl Work {
    pub(crate) fn operations(&self) -> u64 {
        self.0.get()
    }

    /// One step of `flow` for each sample.
    pub(super) fn steps(&self, flow: &Flow, segments: &[Segment]) {
        self.add(samples(segments) * RATE * flow.n_rates());
    }

    /// Steps with their derivatives, and the elimination of all states from them.
    pub(super) fn elimination(&self, flow: &Flow, segments: &[Segment]) {
        let (n, p) = (flow.n as u64, flow.n_parameters as u64);
        let rough = flow.for_derivatives();
        let steps = RATE * (rough.n_rates() + rough.n_slopes()) + SLOPE * n * n * (n + p) * rough.n_stages() as u64;
        let rows = ROW * 2 * n * 3 * n * (2 * n + p + 1);
        let triangle = 2 * n * (p + 1) * (p + 1) / FACTOR;
        self.add(samples(segments) * (steps + rows + triangle));
    }

    fn add(&self, operations: u64) {
        self.0.set(self.0.get().saturating_add(operations));
    }
}

fn samples(segments: &[Segment]) -> u64 {
    segments.iter().map(|s| s.len() as u64 + 1).sum()
}
