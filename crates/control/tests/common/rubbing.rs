//! A pendulum with dry friction whose motor lifts it by a seventh of the way.

use std::sync::Arc;

use rand::RngExt as _;
use sindyna_core::{Channel, Dynamics, Kind, Precision, Rng, Scheme, Space, Spec, Task};
use sindyna_sindy::{Entry, Form, Model, ModelParts};

/// q̈ = −19.5 sin q − F sign q̇ + 5.3 u, |u| ≤ 0.5; q from hanging.
pub(crate) struct Swingup(Spec);

const DT: f64 = 0.05;
const STEPS: usize = 400;

impl Swingup {
    pub(crate) fn new() -> Self {
        let rate = Channel::new("w", "rad/s", Kind::RateOf(0), 1.0);
        let spec = Spec {
            name: "rubbing pendulum".into(),
            // That it turns is found.
            state: vec![Channel::new("q", "rad", Kind::Plain, 1.0), rate.clone()],
            observation: vec![Channel::new("q", "rad", Kind::Plain, 1.0), rate],
            control: vec![Channel::new("u", "N m", Kind::Plain, 0.5)],
            action_space: Space::Box { low: vec![-0.5], high: vec![0.5] },
            precision: Precision::F64,
            noise: 0.0,
            dt: DT,
        };
        Self(spec)
    }

    /// With dry friction F \[rad/s²\].
    pub(crate) fn dynamics(&self, friction: f64) -> Arc<dyn Dynamics> {
        let model = Model::new(ModelParts {
            form: Form::Continuous(Scheme::Rk4 { substeps: 10 }),
            dt: DT,
            terms: ["w", "sin(q)", "sign(w)", "u"].map(String::from).to_vec(),
            equations: vec![
                vec![Entry::new(0, 1.0)],
                vec![Entry::new(1, -19.5), Entry::new(2, -friction), Entry::new(3, 5.3)],
            ],
            n_features: 4,
            states: ["q", "w"].map(String::from).to_vec(),
            controls: vec!["u".into()],
            readings: None,
            offsets: vec![0.0; 2],
            kinematic: vec![true, false],
        });
        Arc::new(model.expect("a model"))
    }
}

impl Task for Swingup {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn max_steps(&self) -> usize {
        STEPS
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x[0] = rng.random_range(-0.05..0.05);
        x[1] = rng.random_range(-0.05..0.05);
    }
    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
        0.5 * (1.0 - next[0].cos()) - 0.001 * next[1] * next[1]
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}
