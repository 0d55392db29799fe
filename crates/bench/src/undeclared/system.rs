//! A true system as a small value.

use std::sync::Arc;

use sindyna_core::VectorField;

use crate::equations::{NotASummand, Term, summands};
use crate::log::Role;

/// Runge–Kutta steps in one sampling interval, unless a system needs more.
const SUBSTEPS: usize = 40;

/// A state: its name, its role and the range its start values are drawn from.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) name: &'static str,
    pub(super) role: Role,
    pub(super) start: (f64, f64),
}

/// An input: its name and range.
#[derive(Debug, Clone)]
pub(super) struct Input {
    pub(super) name: &'static str,
    pub(super) range: (f64, f64),
}

/// A system to be identified: states, inputs, right-hand side and true terms.
#[derive(Clone)]
pub struct System {
    pub(super) name: &'static str,
    pub(super) dt: f64,
    pub(super) length: usize,
    pub(super) substeps: usize,
    pub(super) states: Vec<State>,
    pub(super) inputs: Vec<Input>,
    pub(super) field: Arc<dyn VectorField>,
    truth: &'static [&'static str],
}

impl System {
    /// A system sampled every `dt` \[s\] in recordings of about `length` samples.
    pub(super) fn new(name: &'static str, dt: f64, length: usize) -> Self {
        let (states, inputs, field) =
            (Vec::new(), Vec::new(), Arc::new(Closure(|_: &[f64], _: &[f64], _: &mut [f64]| ())));
        Self { name, dt, length, substeps: SUBSTEPS, states, inputs, field, truth: &[] }
    }

    /// One more state, on the real line.
    pub(super) fn plain(self, name: &'static str, low: f64, high: f64) -> Self {
        self.state(name, Role::Plain, low, high)
    }

    /// One more state, an angle that may enter by itself.
    pub(super) fn angle(self, name: &'static str, low: f64, high: f64) -> Self {
        self.state(name, Role::Angle, low, high)
    }

    /// One more state, an angle that goes round.
    pub(super) fn turning(self, name: &'static str, low: f64, high: f64) -> Self {
        self.state(name, Role::Turning, low, high)
    }

    /// One more state, the rate of state number `of`.
    pub(super) fn rate(self, name: &'static str, of: usize, low: f64, high: f64) -> Self {
        self.state(name, Role::RateOf(of), low, high)
    }

    fn state(mut self, name: &'static str, role: Role, low: f64, high: f64) -> Self {
        self.states.push(State { name, role, start: (low, high) });
        self
    }

    /// One more input.
    pub(super) fn input(mut self, name: &'static str, low: f64, high: f64) -> Self {
        self.inputs.push(Input { name, range: (low, high) });
        self
    }

    /// Runge–Kutta steps in one sampling interval.
    pub(super) fn substeps(self, substeps: usize) -> Self {
        Self { substeps, ..self }
    }

    /// The right-hand side: writes ẋ at (x, u).
    pub(super) fn field(self, field: impl Fn(&[f64], &[f64], &mut [f64]) + Send + Sync + 'static) -> Self {
        Self { field: Arc::new(Closure(field)), ..self }
    }

    /// The right-hand side of another system.
    pub(super) fn shared(self, field: Arc<dyn VectorField>) -> Self {
        Self { field, ..self }
    }

    /// The true terms of each state's equation, as [`summands`] reads them.
    pub(super) fn truth(self, truth: &'static [&'static str]) -> Self {
        Self { truth, ..self }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Whether one of its states is the rate of another.
    #[must_use]
    pub fn has_rates(&self) -> bool {
        self.states.iter().any(|s| matches!(s.role, Role::RateOf(_)))
    }

    /// Names of the states.
    #[must_use]
    pub fn states(&self) -> Vec<String> {
        self.states.iter().map(|s| s.name.to_owned()).collect()
    }

    /// Names of the inputs.
    #[must_use]
    pub fn controls(&self) -> Vec<String> {
        self.inputs.iter().map(|u| u.name.to_owned()).collect()
    }

    /// The right-hand side.
    #[must_use]
    pub fn rates(&self) -> &dyn VectorField {
        &*self.field
    }

    /// The true equations; where rates depend on each other, in the form with a mass matrix, divided by what stands before
    /// the equation's own rate.
    ///
    /// # Errors
    /// If they are miswritten.
    pub fn equations(&self) -> Result<Vec<Vec<Term>>, NotASummand> {
        self.truth.iter().map(|text| summands(text, &self.states())).collect()
    }

    /// The states whose equations are judged: those whose rate is not itself a state.
    pub fn judged(&self) -> impl Iterator<Item = usize> + '_ {
        let kinematic = |i: &usize| self.states.iter().any(|s| s.role == Role::RateOf(*i));
        (0..self.states.len()).filter(move |i| !kinematic(i))
    }
}

/// A closure as a vector field.
struct Closure<F>(F);

impl<F: Fn(&[f64], &[f64], &mut [f64]) + Send + Sync> VectorField for Closure<F> {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        (self.0)(x, u, x_dot);
    }
}
