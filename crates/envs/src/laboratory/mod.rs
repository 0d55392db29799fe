//! Systems nobody has a task for: there to be identified.
//!
//! Each is a [`VectorField`] from the textbooks, stepped so finely that what it does in one control interval is exact to
//! 1e-10 of a channel's scale (`tests/laboratory.rs` measures it), and seen as it is: every state, in float64.

mod driven_pendulum;
mod lorenz;
mod lotka_volterra;
mod rotary_pendulum;
mod two_link_arm;
mod van_der_pol;

use sindyna_core::{Channel, Held, Precision, Rng, Scheme, Space, Spec, Task, VectorField};

use crate::system::{Card, System};
use crate::uniform::uniform;

/// The laboratory's systems: without a task, for identification.
///
/// Their [`System::task`] draws start states, pays nothing and never ends.
#[must_use]
pub fn fields() -> Vec<System> {
    vec![
        driven_pendulum::system(),
        van_der_pol::system(),
        lorenz::system(),
        lotka_volterra::system(),
        two_link_arm::system(),
        rotary_pendulum::system(),
    ]
}

/// The system of the laboratory called `name`.
#[must_use]
pub fn find_field(name: &str) -> Option<System> {
    fields().into_iter().find(|s| s.name() == name)
}

/// Steps after which an episode is truncated, where nothing else ends it.
const MAX_STEPS: usize = 500;

/// How a vector field is set up in the laboratory.
struct SetUp {
    name: &'static str,
    summary: &'static str,
    true_equations: &'static [&'static str],
    state: Vec<Channel>,
    /// Inputs, with the bounds of what may be applied.
    control: Vec<Channel>,
    /// Range of start values of each state.
    start: Vec<(f64, f64)>,
    /// Control interval \[s\].
    dt: f64,
    /// Runge–Kutta steps in it.
    substeps: usize,
}

impl SetUp {
    fn system(self, field: impl VectorField + Copy + 'static) -> System {
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

#[cfg(test)]
mod test_support {
    use sindyna_core::VectorField;

    /// ẋ at (x, u).
    pub(super) fn rates<const N: usize>(field: impl VectorField, x: [f64; N], u: &[f64]) -> [f64; N] {
        let mut x_dot = [0.0; N];
        field.eval(&x, u, &mut x_dot);
        x_dot
    }

    /// dE/dt along the field: a central difference of second order, so to about 1e-9 of E.
    pub(super) fn power<const N: usize>(
        field: impl VectorField,
        energy: impl Fn([f64; N]) -> f64,
        x: [f64; N],
        u: &[f64],
    ) -> f64 {
        let x_dot = rates(field, x, u);
        let size = x_dot.iter().fold(1.0_f64, |size, v| size.max(v.abs()));
        let h = 1e-5 / size;
        let moved = |h: f64| std::array::from_fn(|i| x[i] + h * x_dot[i]);
        (energy(moved(h)) - energy(moved(-h))) / (2.0 * h)
    }
}
