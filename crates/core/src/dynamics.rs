//! How a state moves: one control interval ([`Dynamics`]) or one instant ([`VectorField`]).

use std::sync::Arc;

use ndarray::Array2;

use crate::Rng;

/// A step that left the finite numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the model diverged: state {index} is not finite after the step")]
pub struct Diverged {
    /// The first state that is not finite.
    pub index: usize,
}

impl Diverged {
    /// `Ok` if every state in `next` is finite.
    ///
    /// # Errors
    /// [`Diverged`] with the first index that is NaN or infinite.
    pub fn check(next: &[f64]) -> Result<(), Self> {
        match next.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(index) => Err(Self { index }),
        }
    }
}

/// x' = F(x, u): one control interval with the control u held.
pub trait Dynamics: Send + Sync {
    /// Writes the next state. `x` and `next` have n values, `u` has k; `rng` is for stochastic systems only.
    ///
    /// # Errors
    /// [`Diverged`] if a state is not finite afterwards.
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged>;

    /// ∂F/∂x (n, n) and ∂F/∂u (n, k) at `x` (n), `u` (k): by central differences of one step, unless the dynamics know better. For stochastic
    /// systems this is no more than a draw.
    ///
    /// # Errors
    /// [`Diverged`] if a step near the point is not finite.
    fn linearize(&self, x: &[f64], u: &[f64], rng: &mut Rng) -> Result<Jacobians, Diverged> {
        differences(&|z, rng, next| self.step(&z[..x.len()], &z[x.len()..], rng, next), (x, u), rng)
    }

    /// The same dynamics stepped less exactly in less time: good enough to compare models with each other, whose errors are then the same. `None` if there is no
    /// such way.
    fn coarse(&self) -> Option<Arc<dyn Dynamics>> {
        None
    }
}

/// ∂F/∂x (n, n) and ∂F/∂u (n, k).
pub type Jacobians = (Array2<f64>, Array2<f64>);

/// Step of the differences, as a part of a value's magnitude, or of 1 for smaller ones: their own error is then about 1e-10 of the third
/// derivative, that of rounding 1e-11.
const STEP: f64 = 1e-5;

/// z = (x; u) to the next state (n).
type Stepped<'a> = &'a dyn Fn(&[f64], &mut Rng, &mut [f64]) -> Result<(), Diverged>;

/// The Jacobians of `step` by central differences.
fn differences(step: Stepped<'_>, (x, u): (&[f64], &[f64]), rng: &mut Rng) -> Result<Jacobians, Diverged> {
    let (n, k) = (x.len(), u.len());
    let mut jacobians = (Array2::zeros((n, n)), Array2::zeros((n, k)));
    let mut z = [x, u].concat();
    let (mut ahead, mut behind) = (vec![0.0; n], vec![0.0; n]);
    for j in 0..n + k {
        let (middle, h) = (z[j], STEP * z[j].abs().max(1.0));
        z[j] = middle + h;
        step(&z, rng, &mut ahead)?;
        z[j] = middle - h;
        step(&z, rng, &mut behind)?;
        z[j] = middle;
        let mut column = if j < n { jacobians.0.column_mut(j) } else { jacobians.1.column_mut(j - n) };
        for (slope, (ahead, behind)) in column.iter_mut().zip(ahead.iter().zip(&behind)) {
            *slope = (ahead - behind) / (2.0 * h);
        }
    }
    Ok(jacobians)
}

impl<D: Dynamics + ?Sized> Dynamics for &D {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        (**self).step(x, u, rng, next)
    }

    fn linearize(&self, x: &[f64], u: &[f64], rng: &mut Rng) -> Result<Jacobians, Diverged> {
        (**self).linearize(x, u, rng)
    }

    fn coarse(&self) -> Option<Arc<dyn Dynamics>> {
        (**self).coarse()
    }
}

impl<D: Dynamics + ?Sized> Dynamics for Arc<D> {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        (**self).step(x, u, rng, next)
    }

    fn linearize(&self, x: &[f64], u: &[f64], rng: &mut Rng) -> Result<Jacobians, Diverged> {
        (**self).linearize(x, u, rng)
    }

    fn coarse(&self) -> Option<Arc<dyn Dynamics>> {
        (**self).coarse()
    }
}

/// ẋ = f(x, u) in continuous time.
pub trait VectorField: Send + Sync {
    /// Writes ẋ (n values) at state `x` (n) and control `u` (k).
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]);
}

impl<V: VectorField + ?Sized> VectorField for &V {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        (**self).eval(x, u, x_dot);
    }
}

impl<V: VectorField + ?Sized> VectorField for Arc<V> {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        (**self).eval(x, u, x_dot);
    }
}

/// How a [`VectorField`] is stepped through one control interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// x' = x + h f(x, u): first order.
    Euler,
    /// The classical Runge–Kutta scheme of fourth order in `substeps` equal parts.
    Rk4 {
        /// Number of equal parts of the interval, at least 1.
        substeps: usize,
    },
}

/// A vector field with its control held for `dt` \[s\]: a [`Dynamics`].
#[derive(Debug, Clone)]
pub struct Held<V> {
    field: V,
    scheme: Scheme,
    dt: f64,
}

impl<V: VectorField> Held<V> {
    /// Steps `field` by `dt` \[s\] with `scheme`.
    pub fn new(field: V, scheme: Scheme, dt: f64) -> Self {
        Self { field, scheme, dt }
    }

    /// The vector field that is stepped.
    pub fn field(&self) -> &V {
        &self.field
    }
}

/// States held on the stack during a step; larger systems fall back to the heap.
const STACK_STATES: usize = 16;

impl<V: VectorField> Dynamics for Held<V> {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        let n = x.len();
        let mut stack = [0.0; 6 * STACK_STATES];
        let mut heap = Vec::new();
        let buffer = if n <= STACK_STATES {
            &mut stack[..6 * n]
        } else {
            heap.resize(6 * n, 0.0);
            &mut heap[..]
        };
        next.copy_from_slice(x);
        match self.scheme {
            Scheme::Euler => {
                let x_dot = &mut buffer[..n];
                self.field.eval(x, u, x_dot);
                axpy(self.dt, x_dot, next);
            }
            Scheme::Rk4 { substeps } => {
                let h = self.dt / substeps as f64;
                for _ in 0..substeps {
                    rk4(&self.field, h, u, next, buffer);
                }
            }
        }
        Diverged::check(next)
    }
}

/// y ← y + a x.
fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// One classical Runge–Kutta step of length h, in place; `buffer` holds 6 n values.
fn rk4<V: VectorField>(field: &V, h: f64, u: &[f64], x: &mut [f64], buffer: &mut [f64]) {
    let n = x.len();
    let (k, rest) = buffer.split_at_mut(4 * n);
    let (stage, _) = rest.split_at_mut(n);
    for s in 0..4 {
        stage.copy_from_slice(x);
        if s > 0 {
            let fraction = if s == 3 { h } else { 0.5 * h };
            axpy(fraction, &k[(s - 1) * n..s * n], stage);
        }
        field.eval(stage, u, &mut k[s * n..(s + 1) * n]);
    }
    for i in 0..n {
        x[i] += h / 6.0 * (k[i] + 2.0 * k[n + i] + 2.0 * k[2 * n + i] + k[3 * n + i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    struct Oscillator;
    impl VectorField for Oscillator {
        fn eval(&self, x: &[f64], _u: &[f64], x_dot: &mut [f64]) {
            x_dot[0] = x[1];
            x_dot[1] = -x[0];
        }
    }

    fn error_after_one_second(scheme: Scheme, steps: usize) -> f64 {
        let held = Held::new(Oscillator, scheme, 1.0 / steps as f64);
        let mut rng = Seed::new(0).numpy();
        let (mut x, mut next) = ([1.0, 0.0], [0.0; 2]);
        for _ in 0..steps {
            held.step(&x, &[], &mut rng, &mut next).expect("an oscillator stays finite");
            x = next;
        }
        (x[0] - 1_f64.cos()).hypot(x[1] + 1_f64.sin())
    }

    #[test]
    fn schemes_converge_at_their_order() {
        for (scheme, order) in
            [(Scheme::Euler, 1.0), (Scheme::Rk4 { substeps: 1 }, 4.0), (Scheme::Rk4 { substeps: 3 }, 4.0)]
        {
            let ratio = error_after_one_second(scheme, 20) / error_after_one_second(scheme, 40);
            assert!((ratio.log2() - order).abs() < 0.2, "{scheme:?}: measured order {}", ratio.log2());
        }
    }

    #[test]
    fn a_step_out_of_the_finite_numbers_is_named() {
        struct Explodes;
        impl VectorField for Explodes {
            fn eval(&self, _x: &[f64], _u: &[f64], x_dot: &mut [f64]) {
                x_dot.copy_from_slice(&[0.0, f64::INFINITY]);
            }
        }
        let held = Held::new(Explodes, Scheme::Euler, 0.1);
        let mut next = [0.0; 2];
        let step = held.step(&[0.0, 0.0], &[], &mut Seed::new(0).numpy(), &mut next);
        assert_eq!(step, Err(Diverged { index: 1 }));
    }
}
