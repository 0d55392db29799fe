//! How a vector field becomes a system of the laboratory.

use sindyna_core::{Channel, Held, Precision, Rng, Scheme, Space, Spec, Task, VectorField};

use crate::system::{Card, System};
use crate::uniform::uniform;

/// Steps after which an episode is truncated, where nothing else ends it.
const MAX_STEPS: usize = 500;

/// How a vector field is set up in the laboratory.
pub(super) struct SetUp {
    pub(super) name: &'static str,
    pub(super) summary: &'static str,
    pub(super) true_equations: &'static [&'static str],
    pub(super) state: Vec<Channel>,
    /// Inputs, with the bounds of what may be applied.
    pub(super) control: Vec<Channel>,
    /// Range of start values of each state.
    pub(super) start: Vec<(f64, f64)>,
    /// Control interval \[s\].
    pub(super) dt: f64,
    /// Runge–Kutta steps in it.
    pub(super) substeps: usize,
}

impl SetUp {
    pub(super) fn system(self, field: impl VectorField + Copy + 'static) -> System {
        let (low, high) = self.control.iter().map(|c| c.prior.bounds).unzip();
        let spec = Spec {
            name: self.name.into(),
            observation: self.state.clone(),
            state: self.state,
            control: self.control,
            action_space: Space::Box { low, high },
            precision: Precision::F64,
            noise: 0.0,
            dt: self.dt,
        };
        let card = Card {
            name: self.name,
            gymnasium_id: None,
            solved_at: None,
            summary: self.summary,
            true_equations: self.true_equations,
        };
        let held = Held::new(field, Scheme::Rk4 { substeps: self.substeps }, self.dt);
        System::new(card, Watched { spec, start: self.start }, held, field)
    }
}

/// Nothing to be achieved: start states alone.
struct Watched {
    spec: Spec,
    start: Vec<(f64, f64)>,
}

impl Task for Watched {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn max_steps(&self) -> usize {
        MAX_STEPS
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        for (value, &(low, high)) in x.iter_mut().zip(&self.start) {
            *value = uniform(low, high, rng);
        }
    }

    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
        0.0
    }

    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}
