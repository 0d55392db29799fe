//! Controls that act late.

use std::collections::VecDeque;
use std::sync::Arc;

use ndarray::Array2;
use sindyna_sindy::Model;

use super::{Plant, PlantError};

/// Part of a control interval that is none.
const NONE: f64 = 1e-9;

/// How late controls act, in control intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Late {
    /// How long each of the controls that have not acted yet will act before the next one does \[s\], the oldest first.
    spans: Vec<f64>,
    /// Control interval \[s\].
    interval: f64,
}

impl Late {
    /// Controls every `interval` \[s\] that act after `delay` \[s\]; `None` if they act at once.
    #[must_use]
    pub fn of(delay: f64, interval: f64) -> Option<Self> {
        let intervals = delay / interval;
        let whole = (intervals + NONE).floor();
        let part = intervals - whole;
        let first = (part > NONE).then_some(part * interval);
        let spans: Vec<f64> = first.into_iter().chain((0..whole as usize).map(|_| interval)).collect();
        (!spans.is_empty()).then_some(Self { spans, interval })
    }

    /// Whether a control acts from within a control interval on.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.spans[0] < self.interval
    }

    /// Controls (k each) before an episode: zero.
    pub(crate) fn none(&self, k: usize) -> VecDeque<Vec<f64>> {
        self.spans.iter().map(|_| vec![0.0; k]).collect()
    }

    /// The state that follows `x` (n) in `model` once the `pending` controls (k each) have acted; `None` where it diverges.
    pub(crate) fn moved<'a>(
        &self,
        model: &Model,
        x: &[f64],
        pending: impl Iterator<Item = &'a [f64]>,
    ) -> Option<Vec<f64>> {
        moved(model, x, pending, &self.spans)
    }
}

/// The state that follows `x` (n) in `model` under `controls` (k each), each for one of `spans` \[s\]; `None` where it diverges.
fn moved<'a>(model: &Model, x: &[f64], controls: impl Iterator<Item = &'a [f64]>, spans: &[f64]) -> Option<Vec<f64>> {
    let all: Vec<f64> = controls.flatten().copied().collect();
    let u = Array2::from_shape_vec((spans.len(), model.controls().len()), all).ok()?;
    let states = model.simulate_at(x, u.view(), spans).ok()?;
    Some(states.row(spans.len()).to_vec())
}

/// The system of a model whose controls act late. Before an episode they were zero.
pub(super) struct LatePlant {
    model: Arc<Model>,
    late: Late,
    state: Vec<f64>,
    /// Controls that have not acted yet, the oldest first.
    pending: VecDeque<Vec<f64>>,
}

impl LatePlant {
    pub(super) fn new(model: Arc<Model>, late: Late) -> Self {
        let pending = late.none(model.controls().len());
        Self { state: vec![0.0; model.states().len()], model, late, pending }
    }
}

impl Plant for LatePlant {
    fn reset(&mut self, start: &[f64]) -> Result<Vec<f64>, PlantError> {
        self.state = start.to_vec();
        self.pending = self.late.none(self.model.controls().len());
        Ok(self.state.clone())
    }

    fn step(&mut self, u: &[f64]) -> Result<Vec<f64>, PlantError> {
        self.pending.push_back(u.to_vec());
        let Late { ref spans, interval } = self.late;
        let rest = interval - spans[0];
        let spans = if self.late.is_within() { vec![spans[0], rest] } else { vec![interval] };
        let acting = self.pending.iter().map(Vec::as_slice).take(spans.len());
        let next = moved(&self.model, &self.state, acting, &spans).ok_or("the model diverged")?;
        self.pending.pop_front();
        self.state.clone_from(&next);
        Ok(next)
    }
}
