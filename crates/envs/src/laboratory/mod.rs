//! Systems nobody has a task for: there to be identified.
//!
//! Each is a [`VectorField`](sindyna_core::VectorField) from the textbooks, stepped so finely that what it does in one control interval is exact to
//! 1e-10 of a channel's scale (`tests/laboratory.rs` measures it), and seen as it is: every state, in float64.

mod driven_pendulum;
mod lorenz;
mod lotka_volterra;
mod rotary_pendulum;
mod set_up;
mod two_link_arm;
mod van_der_pol;

use crate::system::System;

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
