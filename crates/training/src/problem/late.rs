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
    /// Whether they act through actuators with a lag, whose states are the last ones of the model.
    lags: bool,
}

impl Late {
    /// Controls every `interval` \[s\] that act after `delay` \[s\], through a lag with the time constant `lag` \[s\], 0 for none.
    #[must_use]
    pub fn of((delay, lag): (f64, f64), interval: f64) -> Self {
        let intervals = delay / interval;
        let whole = (intervals + NONE).floor();
        let part = intervals - whole;
        let first = (part > NONE).then_some(part * interval);
        let spans = first.into_iter().chain((0..whole as usize).map(|_| interval)).collect();
        Self { spans, interval, lags: lag > 0.0 }
    }

    /// Whether they act at once, and without a lag.
    #[must_use]
    pub fn is_now(&self) -> bool {
        self.spans.is_empty() && !self.lags
    }

    /// Whether they act through a lag.
    pub(crate) fn lags(&self) -> bool {
        self.lags
    }

    /// Whether a control acts from within a control interval on.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.spans.first().is_some_and(|first| *first < self.interval)
    }

    /// Controls (k each) before an episode: zero.
    pub(crate) fn none(&self, k: usize) -> VecDeque<Vec<f64>> {
        self.spans.iter().map(|_| vec![0.0; k]).collect()
    }

    /// The state that follows `x` (n) in `model` after one control interval, over which the oldest of the `pending` controls (k each) act, the last of which was given now; `None` where it diverges.
    pub(crate) fn stepped(&self, model: &Model, x: &[f64], pending: &VecDeque<Vec<f64>>) -> Option<Vec<f64>> {
        let spans = match self.spans.first() {
            Some(first) if self.is_within() => vec![*first, self.interval - first],
            _ => vec![self.interval],
        };
        moved(model, x, pending.iter().map(Vec::as_slice).take(spans.len()), &spans)
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
#[derive(Clone)]
pub(super) struct LatePlant {
    model: Arc<Model>,
    late: Late,
    /// All of its states; what actuators deliver are the last ones.
    state: Vec<f64>,
    /// How many states are shown.
    shown: usize,
    /// Controls that have not acted yet, the oldest first.
    pending: VecDeque<Vec<f64>>,
}

impl LatePlant {
    /// That of `model`, whose controls are `late`. So many states are `shown`: those that actuators have not are as the controls that they would follow.
    pub(super) fn new(model: Arc<Model>, late: Late, shown: usize) -> Self {
        let pending = late.none(model.controls().len());
        Self { state: vec![0.0; model.states().len()], model, late, shown, pending }
    }

    /// The states that are shown after `control` (k) has acted.
    fn seen(&self, control: &[f64]) -> Vec<f64> {
        self.state.iter().chain(control).copied().take(self.shown).collect()
    }
}

impl Plant for LatePlant {
    fn reset(&mut self, start: &[f64]) -> Result<Vec<f64>, PlantError> {
        let k = self.model.controls().len();
        // Actuators that are not among the states of the task are at rest.
        let rest = std::iter::repeat(0.0);
        self.state = start.iter().copied().chain(rest).take(self.model.states().len()).collect();
        self.pending = self.late.none(k);
        Ok(self.seen(&vec![0.0; k]))
    }

    fn step(&mut self, u: &[f64]) -> Result<Vec<f64>, PlantError> {
        self.pending.push_back(u.to_vec());
        self.state = self.late.stepped(&self.model, &self.state, &self.pending).ok_or("the model diverged")?;
        let acted = self.pending.pop_front().unwrap_or_default();
        Ok(self.seen(&acted))
    }
}

#[cfg(test)]
mod tests {
    use sindyna_sindy::{Entry, ModelParts};

    use super::*;

    /// x' = u.
    fn integrator() -> Model {
        Model::new(ModelParts {
            states: vec!["x".into()],
            controls: vec!["u".into()],
            form: sindyna_sindy::Form::Continuous(sindyna_core::Scheme::Rk4 { substeps: 1 }),
            dt: 0.1,
            readings: None,
            terms: vec!["u".into()],
            equations: vec![vec![Entry::new(0, 1.0)]],
            kinematic: vec![false],
            offsets: vec![0.0],
            n_features: 1,
        })
        .expect("a model")
    }

    #[test]
    fn controls_act_after_the_delay_and_not_before() {
        for (delay, is_within) in [(0.0, false), (0.2, false), (0.03, true), (0.25, true)] {
            let late = Late::of((delay, 0.0), 0.1);
            assert_eq!(late.is_within(), is_within, "{delay}");
            let mut plant = LatePlant::new(Arc::new(integrator()), late.clone(), 1);
            plant.reset(&[5.0]).expect("reset");
            let (controls, mut pending) = ([1.0, -2.0, 4.0, 3.0, 0.5, 7.0], late.none(1));
            let acted = |until: f64| -> f64 {
                let each = controls.iter().enumerate();
                each.map(|(i, u)| u * (until - delay - 0.1 * i as f64).clamp(0.0, 0.1)).sum()
            };
            for (i, u) in controls.into_iter().enumerate() {
                let now = 0.1 * i as f64;
                // What is predicted for the moment when the next control begins to act.
                let x = late.moved(&integrator(), &plant.state, pending.iter().map(Vec::as_slice)).expect("finite");
                assert!((x[0] - 5.0 - acted(now + delay)).abs() < 1e-12, "{delay}: {i}");
                let next = plant.step(&[u]).expect("finite");
                assert!((next[0] - 5.0 - acted(now + 0.1)).abs() < 1e-12, "{delay}: {next:?}");
                pending.push_back(vec![u]);
                pending.pop_front();
            }
        }
    }

    #[test]
    fn actuators_are_shown_where_the_policy_knows_of_them_and_hidden_where_not() {
        let behind = integrator().with_actuators(0.2, &["u_delivered".into()]).expect("continuous");
        let steps = |model: Model, shown: usize| {
            let mut plant = LatePlant::new(Arc::new(model), Late::of((0.0, 0.0), 0.1), shown);
            let first = plant.reset(&vec![0.0; shown]).expect("reset");
            (first, plant.step(&[1.0]).expect("finite"))
        };
        let left = f64::exp(-0.5);
        let near = |found: &[f64], truth: &[f64]| found.iter().zip(truth).all(|(a, b)| (a - b).abs() < 1e-6);
        let (first, next) = steps(behind.clone(), 2);
        assert!(first == [0.0, 0.0] && near(&next, &[0.1 - 0.2 * (1.0 - left), 1.0 - left]), "{next:?}");
        assert_eq!(steps(behind, 1).1, next[..1]);
        // Without a lag what is delivered is what was told.
        assert_eq!(steps(integrator(), 2), (vec![0.0, 0.0], vec![0.1, 1.0]));
    }
}
