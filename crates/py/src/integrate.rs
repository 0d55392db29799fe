//! Solutions of identified equations in continuous time, to a tolerance.

use std::fmt;

use ndarray::{Array2, ArrayView2};
use pyo3::prelude::*;
use sindyna_core::VectorField;

use crate::interrupt::Look;

/// The input between two times.
pub(crate) enum Input<'a> {
    /// Values (T, k), each held until the next time.
    Held(ArrayView2<'a, f64>),
    /// Values (T, k), a straight line between.
    Linear(ArrayView2<'a, f64>),
    /// A Python callable of time, and the number of inputs.
    Call(&'a Py<PyAny>, usize),
}

/// Errors allowed in each step: `atol` + `rtol` |x|.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    pub(crate) rtol: f64,
    pub(crate) atol: f64,
}

/// Why there is no solution.
#[derive(Debug)]
pub(crate) enum Failure {
    /// States that leave the finite numbers.
    Diverged { at: f64 },
    /// Steps that became too small to go on.
    Stiff { at: f64, step: f64 },
    /// The input, or a signal's handler, raised an exception.
    Python(PyErr),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Diverged { at } => write!(f, "the solution leaves the finite numbers at t = {at} s"),
            Self::Stiff { at, step } => {
                write!(
                    f,
                    "the solution needs steps below {step:e} s at t = {at} s: it grows without bound there, or the tolerances are too small"
                )
            }
            Self::Python(e) => e.fmt(f),
        }
    }
}

/// Nodes of the scheme.
const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
/// Its weights, row by row; the last is the solution of order five.
const A: [&[f64]; 7] = [
    &[],
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Weights of the difference to the solution of order four.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// Steps between two looks for signals.
const LOOK: usize = 64;

/// Smallest step, as a part of the time it is at or of the span of one interval.
const SMALLEST: f64 = 1e-13;

/// The solution (T, n) of ẋ = f(x, u) at times `t` (T) from `x0` (n) on.
///
/// # References
/// Dormand, Prince (1980), J. Comput. Appl. Math. 6(1); step sizes after Hairer, Nørsett, Wanner, Solving ODEs I, §II.4.
pub(crate) fn follow(
    field: &dyn VectorField,
    x0: &[f64],
    t: &[f64],
    input: &Input<'_>,
    tolerance: Tolerance,
    look: &Look,
) -> Result<Array2<f64>, Failure> {
    let mut solution = Array2::zeros((t.len(), x0.len()));
    let mut stepper = Stepper::new(field, x0, input, tolerance);
    for i in 0..t.len() {
        if i > 0 {
            stepper.advance((i - 1, t[i - 1], t[i]), look)?;
        }
        solution.row_mut(i).iter_mut().zip(&stepper.x).for_each(|(slot, v)| *slot = *v);
    }
    Ok(solution)
}

struct Stepper<'a, 'b> {
    field: &'a dyn VectorField,
    input: &'a Input<'b>,
    tolerance: Tolerance,
    x: Vec<f64>,
    k: [Vec<f64>; 7],
    stage: Vec<f64>,
    u: Vec<f64>,
    /// The step that was allowed last.
    step: Option<f64>,
    steps: usize,
}

impl<'a, 'b> Stepper<'a, 'b> {
    fn new(field: &'a dyn VectorField, x0: &[f64], input: &'a Input<'b>, tolerance: Tolerance) -> Self {
        let n = x0.len();
        let n_inputs = match input {
            Input::Held(u) | Input::Linear(u) => u.ncols(),
            Input::Call(_, k) => *k,
        };
        Self {
            field,
            input,
            tolerance,
            x: x0.to_vec(),
            k: std::array::from_fn(|_| vec![0.0; n]),
            stage: vec![0.0; n],
            u: vec![0.0; n_inputs],
            step: None,
            steps: 0,
        }
    }

    /// Sets the input at time `at` in interval `i`, which is from `begin` to `end`.
    fn set_input(&mut self, at: f64, (i, begin, end): (usize, f64, f64)) -> Result<(), Failure> {
        match self.input {
            Input::Held(u) => self.u.iter_mut().zip(u.row(i)).for_each(|(slot, v)| *slot = *v),
            Input::Linear(u) => {
                let part = (at - begin) / (end - begin);
                for (slot, (a, b)) in self.u.iter_mut().zip(u.row(i).iter().zip(u.row(i + 1))) {
                    *slot = a + part * (b - a);
                }
            }
            Input::Call(call, k) => {
                let values = Python::attach(|py| -> PyResult<Vec<f64>> { call.call1(py, (at,))?.extract(py) });
                let values = values.map_err(Failure::Python)?;
                if values.len() != *k {
                    let message = format!("u({at}) must give {k} numbers, got {}", values.len());
                    return Err(Failure::Python(pyo3::exceptions::PyValueError::new_err(message)));
                }
                self.u.copy_from_slice(&values);
            }
        }
        Ok(())
    }

    /// Moves from the beginning to the end of interval `i`.
    fn advance(&mut self, interval: (usize, f64, f64), look: &Look) -> Result<(), Failure> {
        let (_, begin, end) = interval;
        let mut at = begin;
        let smallest = SMALLEST * begin.abs().max(end.abs()).max(end - begin);
        while at < end {
            self.steps += 1;
            if self.steps.is_multiple_of(LOOK) {
                look.check().map_err(Failure::Python)?;
            }
            let wanted = self.step.unwrap_or(0.01 * (end - begin));
            let last = at + 1.01 * wanted >= end;
            let h = if last { end - at } else { wanted };
            let error = self.attempt(at, h, interval)?;
            // NaN counts as far too large.
            let factor = if error.is_finite() { (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.2, 5.0) } else { 0.1 };
            let next = h * factor;
            if error <= 1.0 {
                at = if last { end } else { at + h };
                self.x.copy_from_slice(&self.stage);
                if self.x.iter().any(|v| !v.is_finite()) {
                    return Err(Failure::Diverged { at });
                }
                // A step cut short by the end of the interval says nothing against a longer one.
                self.step = Some(if last { next.max(wanted) } else { next });
            } else if next < smallest {
                return Err(Failure::Stiff { at, step: smallest });
            } else {
                self.step = Some(next);
            }
        }
        Ok(())
    }

    /// Writes the state after a step into `stage`; the error as a part of what is allowed.
    fn attempt(&mut self, at: f64, h: f64, interval: (usize, f64, f64)) -> Result<f64, Failure> {
        for s in 0..7 {
            self.stage.copy_from_slice(&self.x);
            for (a, k) in A[s].iter().zip(&self.k) {
                for (slot, k) in self.stage.iter_mut().zip(k) {
                    *slot += h * a * k;
                }
            }
            self.set_input(at + C[s] * h, interval)?;
            self.field.eval(&self.stage, &self.u, &mut self.k[s]);
        }
        let mut sum = 0.0;
        for i in 0..self.x.len() {
            let error: f64 = h * E.iter().zip(&self.k).map(|(e, k)| e * k[i]).sum::<f64>();
            let allowed = self.tolerance.atol + self.tolerance.rtol * self.x[i].abs().max(self.stage[i].abs());
            sum += (error / allowed).powi(2);
        }
        Ok((sum / self.x.len() as f64).sqrt())
    }
}
