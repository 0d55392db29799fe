//! Equations of motion over samples, as rows that are linear in the parameters.

use nalgebra::{DMatrix, DVector};

use crate::regressor::{inverse_dynamics, momenta};
use crate::{BodiesError, Tree};

/// A recorded motion of a tree of n joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Times of the samples \[s\] (T + 1).
    pub times: Vec<f64>,
    /// Positions of the joints (T + 1, n).
    pub positions: DMatrix<f64>,
    /// Their rates (T + 1, n).
    pub rates: DMatrix<f64>,
    /// Forces on the joints from each sample to the next (T, n), held.
    pub forces: DMatrix<f64>,
    /// Measured accelerations (T + 1, n), at which the forces act in the same moment; `None` if there are none.
    pub accelerations: Option<DMatrix<f64>>,
}

impl Motion {
    /// Steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.forces.nrows()
    }

    pub(crate) fn check(&self, n: usize) -> Result<(), BodiesError> {
        let samples = self.times.len();
        let shape = |what, expected, got| {
            if expected == got { Ok(()) } else { Err(BodiesError::Shape { what, expected, got }) }
        };
        shape("samples of positions", samples, self.positions.nrows())?;
        shape("samples of rates", samples, self.rates.nrows())?;
        shape("steps with forces", samples.saturating_sub(1), self.forces.nrows())?;
        shape("joints with positions", n, self.positions.ncols())?;
        shape("joints with rates", n, self.rates.ncols())?;
        shape("joints with forces", n, self.forces.ncols())?;
        if let Some(a) = &self.accelerations {
            shape("samples of accelerations", samples, a.nrows())?;
            shape("joints with accelerations", n, a.ncols())?;
        }
        let values = self.times.iter().chain(&self.positions).chain(&self.rates).chain(&self.forces);
        if values.chain(self.accelerations.iter().flat_map(|a| a.iter())).any(|v| !v.is_finite()) {
            return Err(BodiesError::NotFinite);
        }
        if self.times.windows(2).any(|t| t[1] <= t[0]) {
            return Err(BodiesError::Times);
        }
        Ok(())
    }

    /// The same with forces that act so many steps later than they were recorded (earlier where that is negative), without the steps whose forces are then not known.
    #[must_use]
    pub fn delayed(&self, steps: i32) -> Self {
        let by = (steps.unsigned_abs() as usize).min(self.steps());
        let kept = self.steps() - by;
        let (from, source) = if steps > 0 { (by, 0) } else { (0, by) };
        let part = self.part(from, from + kept);
        Self { forces: self.forces.rows(source, kept).into_owned(), ..part }
    }

    /// The steps `from` to `to`, that one excluded.
    #[must_use]
    pub fn part(&self, from: usize, to: usize) -> Self {
        let count = to - from;
        Self {
            times: self.times[from..=to].to_vec(),
            positions: self.positions.rows(from, count + 1).into_owned(),
            rates: self.rates.rows(from, count + 1).into_owned(),
            forces: self.forces.rows(from, count).into_owned(),
            accelerations: self.accelerations.as_ref().map(|a| a.rows(from, count + 1).into_owned()),
        }
    }
}

/// Rows of one window or sample: a row for each joint, of the parameters (n, 13 n) and of the forces (n).
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    pub(crate) parameters: DMatrix<f64>,
    pub(crate) forces: DVector<f64>,
}

/// How motions become rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// The forces of the joints, from measured accelerations: a row for each sample.
    Accelerations,
    /// Momenta over each step, along the cubics through positions and rates at both its ends.
    Steps,
    /// Weak form: over windows of so many steps, half of each in the next one, with the test function (1 − s²)³.
    Windows(usize),
}

impl Form {
    /// What it is called in results.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Accelerations => "accelerations".into(),
            Self::Steps => "momenta over single steps".into(),
            Self::Windows(steps) => format!("weak form over {steps} steps"),
        }
    }
}

/// The rows of `motion`; fewer if `go_on` says no.
pub(crate) fn rows(tree: &Tree, motion: &Motion, form: Form, go_on: &dyn Fn() -> bool) -> Vec<Rows> {
    match form {
        Form::Accelerations => of_accelerations(tree, motion, go_on),
        Form::Steps => of_steps(tree, motion, go_on),
        Form::Windows(steps) => of_windows(tree, motion, steps, go_on),
    }
}

fn row(of: &DMatrix<f64>, t: usize) -> Vec<f64> {
    of.row(t).iter().copied().collect()
}

fn of_accelerations(tree: &Tree, motion: &Motion, go_on: &dyn Fn() -> bool) -> Vec<Rows> {
    let Some(a) = &motion.accelerations else { return Vec::new() };
    let at = |t: usize| Rows {
        parameters: inverse_dynamics(tree, &row(&motion.positions, t), &row(&motion.rates, t), &row(a, t)),
        forces: motion.forces.row(t).transpose(),
    };
    (0..motion.steps()).take_while(|_| go_on()).map(at).collect()
}

/// Parts of a step at which forces are averaged, with their weights: Gauss–Lobatto of fifth order.
const LOBATTO: [(f64, f64); 4] =
    [(0.0, 1.0 / 12.0), (0.276_393_202_250_021, 5.0 / 12.0), (0.723_606_797_749_979, 5.0 / 12.0), (1.0, 1.0 / 12.0)];

fn of_steps(tree: &Tree, motion: &Motion, go_on: &dyn Fn() -> bool) -> Vec<Rows> {
    let n = tree.len();
    let at = |t: usize| momenta(tree, &row(&motion.positions, t), &row(&motion.rates, t)).0;
    let mut before = at(0);
    let step = |t: usize| {
        let dt = motion.times[t + 1] - motion.times[t];
        let after = at(t + 1);
        let mut parameters = &after - std::mem::replace(&mut before, after.clone());
        for (part, weight) in LOBATTO {
            let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
            for i in 0..n {
                let ends = [
                    motion.positions[(t, i)],
                    motion.rates[(t, i)],
                    motion.positions[(t + 1, i)],
                    motion.rates[(t + 1, i)],
                ];
                (q[i], v[i]) = between(ends, dt, part);
            }
            parameters -= dt * weight * momenta(tree, &q, &v).1;
        }
        Rows { parameters, forces: dt * motion.forces.row(t).transpose() }
    };
    (0..motion.steps()).take_while(|_| go_on()).map(step).collect()
}

/// Position and rate at the part `at` of a step of `dt` seconds on the cubic through both at its ends.
fn between([q, v, q_next, v_next]: [f64; 4], dt: f64, at: f64) -> (f64, f64) {
    let (c, d) = (3.0 * (q_next - q) - dt * (2.0 * v + v_next), 2.0 * (q - q_next) + dt * (v + v_next));
    (q + at * (dt * v + at * (c + at * d)), v + at * (2.0 * c + 3.0 * at * d) / dt)
}

/// ∫ φ ∂L/∂q + φ̇ p dt π = −∫ φ u dt, by the trapezoidal rule over samples, with what is held integrated over each step.
fn of_windows(tree: &Tree, motion: &Motion, steps: usize, go_on: &dyn Fn() -> bool) -> Vec<Rows> {
    if motion.steps() < steps || !go_on() {
        return Vec::new();
    }
    let all: Vec<(DMatrix<f64>, DMatrix<f64>)> =
        (0..motion.times.len()).map(|t| momenta(tree, &row(&motion.positions, t), &row(&motion.rates, t))).collect();
    let hop = (steps / 2).max(1);
    let window = |from: usize| {
        let to = from + steps;
        let (begin, end) = (motion.times[from], motion.times[to]);
        let half = 0.5 * (end - begin);
        let at = |t: f64| (t - begin) / half - 1.0;
        let (n, width) = all[from].0.shape();
        let (mut parameters, mut forces) = (DMatrix::zeros(n, width), DVector::zeros(n));
        for (t, (momenta, others)) in all.iter().enumerate().take(to + 1).skip(from) {
            let s = at(motion.times[t]);
            let (value, slope) = ((1.0 - s * s).powi(3), -6.0 * s * (1.0 - s * s).powi(2) / half);
            let before = if t > from { motion.times[t] - motion.times[t - 1] } else { 0.0 };
            let after = if t < to { motion.times[t + 1] - motion.times[t] } else { 0.0 };
            let weight = 0.5 * (before + after);
            parameters -= weight * (slope * momenta + value * others);
            if t < to {
                let integral = half * (cubed(at(motion.times[t + 1])) - cubed(s));
                forces += integral * motion.forces.row(t).transpose();
            }
        }
        Rows { parameters, forces }
    };
    (0..=motion.steps() - steps).step_by(hop).take_while(|_| go_on()).map(window).collect()
}

/// ∫ (1 − s²)³ ds.
fn cubed(s: f64) -> f64 {
    s - s.powi(3) + 0.6 * s.powi(5) - s.powi(7) / 7.0
}
