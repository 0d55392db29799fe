//! A task that is easy to see through, its dynamics, and an agent that shows what it was given.

#![allow(dead_code)]

use std::sync::{Arc, Mutex};

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{
    Agent, AgentError, Batch, Channel, Dataset, Diverged, Dynamics, DynamicsLearner, FitError, Kind, Knowledge, Losses,
    Mode, Policy, Precision, Rng, Space, Spec, Task,
};

/// A point on a line, pushed about; falls off at |x| > 1 and is paid −x² for every step.
pub(crate) struct Line(pub(crate) Spec);

impl Line {
    pub(crate) fn new(max_steps: usize) -> Self {
        Self(Spec {
            name: "line".into(),
            state: vec![Channel::new("x", "m", Kind::Plain, 2.0)],
            observation: vec![Channel::new("x", "m", Kind::Plain, 2.0)],
            control: vec![Channel::new("u", "m", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-0.4], high: vec![0.4] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 1.0,
            max_steps,
            solved_at: None,
        })
    }
}

impl Task for Line {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        use rand::RngExt as _;
        x[0] = rng.random_range(-0.1..0.1);
    }
    fn reward(&self, x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
        -x[0] * x[0]
    }
    fn terminated(&self, next: &[f64]) -> bool {
        next[0].abs() > 1.0
    }
}

/// x' = x + gain·u; beyond `breaks_at` the model blows up.
#[derive(Clone)]
pub(crate) struct Push {
    pub(crate) gain: f64,
    pub(crate) breaks_at: f64,
}

impl Dynamics for Push {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        next[0] = if x[0].abs() > self.breaks_at { f64::NAN } else { x[0] + self.gain * u[0] };
        Diverged::check(next)
    }
}

pub(crate) struct Given(pub(crate) Push);

impl DynamicsLearner for Given {
    type Model = Push;
    fn fit(
        &self,
        _data: &Dataset,
        _previous: Option<&Push>,
        _rng: &mut Rng,
    ) -> Result<Option<Knowledge<Push>>, FitError> {
        Ok(Some(Knowledge::certain(self.0.clone())))
    }
}

/// Moves by a gain that improves a little with each update, and keeps what it was shown.
#[derive(Clone, Default)]
pub(crate) struct Student {
    pub(crate) gain: f64,
    /// Acts twice as strongly as its gain says: right where the model is half as lively as the truth.
    pub(crate) eager: bool,
    pub(crate) shown: Arc<Mutex<Vec<(f64, f64, f64)>>>,
}

impl Policy for Student {
    fn act_batch(&self, o: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, mut actions: ArrayViewMut2<'_, f64>) {
        use rand::RngExt as _;
        for (o, mut a) in o.rows().into_iter().zip(actions.rows_mut()) {
            a[0] = match mode {
                Mode::Exploit => (-self.gain * if self.eager { 2.0 } else { 1.0 } * o[0]).clamp(-0.4, 0.4),
                Mode::Explore => rng.random_range(-0.4..0.4),
            };
        }
    }
}

impl Agent for Student {
    type Frozen = Self;
    fn update(&mut self, batch: &Batch, _rng: &mut Rng) -> Result<Losses, AgentError> {
        self.gain = (self.gain + 0.1).min(1.0);
        let mut shown = self.shown.lock().expect("one thread");
        for i in 0..batch.len() {
            shown.push((batch.next_observations[[i, 0]], batch.rewards[i], batch.terminated[i]));
        }
        Ok(Losses { critic: 0.0, actor: 0.0, temperature: 0.0, entropy: 0.0 })
    }
    fn frozen(&self) -> Self {
        self.clone()
    }
}
