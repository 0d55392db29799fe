//! Accelerations of joints, and steps with what they change with the parameters.

use nalgebra::DMatrix;
use sindyna_core::vectorized;

use crate::expr::Tape;
use crate::library::Lagrangian;
use crate::motion::Stepping;

/// A summand of the equation of a joint.
struct Summand {
    /// Place of its parameter among those that are used.
    place: usize,
    row: usize,
    /// The joint whose acceleration it multiplies, if any.
    with: Option<usize>,
    factor: f64,
    /// Its derivatives, as (state, output of the tape).
    along: Vec<(usize, usize)>,
}

/// The equations of a Lagrangian with some of its parameters, compiled.
pub(super) struct Mechanism {
    joints: Vec<(usize, usize)>,
    n_states: usize,
    n_parameters: usize,
    /// States at the start of a flight that it is told to change with: all of them, or none.
    n_starts: usize,
    tape: Tape,
    summands: Vec<Summand>,
}

/// A state, and what it changes with each parameter and each state at the start: for each number of the state a row of 1 + P + S.
#[derive(Debug, Clone)]
pub(super) struct Flight {
    numbers: Vec<f64>,
    width: usize,
}

impl Flight {
    /// Number `i` of the state.
    pub(super) fn state(&self, i: usize) -> f64 {
        self.numbers[i * self.width]
    }

    /// What that changes with each parameter, and each state at the start.
    pub(super) fn changes(&self, i: usize) -> &[f64] {
        &self.row(i)[1..]
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.numbers[i * self.width..][..self.width]
    }

    fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.numbers[i * self.width..][..self.width]
    }

    /// This and `h` times `slope`.
    fn moved(&self, slope: &Self, h: f64) -> Self {
        let numbers = vectorized(
            #[inline(always)]
            || self.numbers.iter().zip(&slope.numbers).map(|(x, s)| x + h * s).collect(),
        );
        Self { numbers, width: self.width }
    }
}

impl Mechanism {
    /// With the parameters `chosen`.
    pub(super) fn new(lagrangian: &Lagrangian, chosen: &[usize], (n_states, n_controls): (usize, usize)) -> Self {
        let joint = |speed: usize| lagrangian.joints.iter().position(|(_, v)| *v == speed);
        let mut exprs = Vec::new();
        let mut summands = Vec::new();
        for (place, &p) in chosen.iter().enumerate() {
            for (row, (expr, rate), factor) in lagrangian.summands(p) {
                summands.push(Summand { place, row, with: rate.and_then(joint), factor, along: Vec::new() });
                exprs.push(expr);
            }
        }
        let mut slopes = Vec::new();
        for (summand, expr) in summands.iter_mut().zip(&exprs) {
            for state in lagrangian.joints.iter().flat_map(|&(q, v)| [q, v]) {
                if let Some(slope) = expr.derivative(state) {
                    summand.along.push((state, exprs.len() + slopes.len()));
                    slopes.push(slope);
                }
            }
        }
        let tape = Tape::new(n_states + n_controls, exprs.iter().chain(&slopes));
        Self { joints: lagrangian.joints.clone(), n_states, n_parameters: chosen.len(), n_starts: 0, tape, summands }
    }

    /// The same whose flights tell what they change with the state at their start, too.
    pub(super) fn with_starts(self) -> Self {
        Self { n_starts: self.n_states, ..self }
    }

    /// The state `x`, which no parameter changes.
    pub(super) fn start(&self, x: &[f64]) -> Flight {
        let width = 1 + self.n_columns();
        let mut start = Flight { numbers: vec![0.0; self.n_states * width], width };
        x.iter().enumerate().for_each(|(i, x)| start.row_mut(i)[0] = *x);
        (0..self.n_starts).for_each(|i| start.row_mut(i)[1 + self.n_parameters + i] = 1.0);
        start
    }

    /// Parameters and states at the start.
    fn n_columns(&self) -> usize {
        self.n_parameters + self.n_starts
    }

    /// The state `dt` seconds after `at` under `u` with the parameters `c`, and what it changes with each of them. `None` where masses are singular.
    pub(super) fn step(&self, at: Flight, u: &[f64], c: &[f64], dt: f64, stepping: Stepping) -> Option<Flight> {
        let mut at = at;
        match stepping {
            Stepping::Euler => {
                let slope = self.slopes(&at, u, c)?;
                Some(at.moved(&slope, dt))
            }
            Stepping::SemiImplicit { substeps } => {
                let h = dt / substeps as f64;
                for _ in 0..substeps {
                    let slope = self.slopes(&at, u, c)?;
                    for &(q, v) in &self.joints {
                        for p in 0..at.width {
                            at.row_mut(v)[p] += h * slope.row(v)[p];
                            at.row_mut(q)[p] += h * at.row(v)[p];
                        }
                    }
                }
                Some(at)
            }
            Stepping::Continuous { substeps } | Stepping::Classical { substeps } => {
                let h = dt / substeps as f64;
                for _ in 0..substeps {
                    let first = self.slopes(&at, u, c)?;
                    let second = self.slopes(&at.moved(&first, 0.5 * h), u, c)?;
                    let third = self.slopes(&at.moved(&second, 0.5 * h), u, c)?;
                    let fourth = self.slopes(&at.moved(&third, h), u, c)?;
                    let [first, second, third, fourth] = [first, second, third, fourth].map(|slope| slope.numbers);
                    vectorized(
                        #[inline(always)]
                        || {
                            for (i, at) in at.numbers.iter_mut().enumerate() {
                                *at += h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]);
                            }
                        },
                    );
                }
                Some(at)
            }
        }
    }

    /// The sign of the matrix of masses in the state `x`, with the parameters `c`; `None` where it is not definite.
    pub(super) fn sign_of_masses(&self, x: &[f64], c: &[f64]) -> Option<f64> {
        let mut registers = vec![0.0; self.tape.n_registers()];
        registers[..self.n_states].copy_from_slice(x);
        self.tape.run(&mut registers);
        let mut mass = DMatrix::zeros(self.joints.len(), self.joints.len());
        for (summand, &r) in self.summands.iter().zip(self.tape.outputs()) {
            if let Some(joint) = summand.with {
                mass[(summand.row, joint)] += c[summand.place] * summand.factor * registers[r as usize];
            }
        }
        let is_positive = |mass: DMatrix<f64>| mass.cholesky().is_some();
        if is_positive(mass.clone()) {
            return Some(1.0);
        }
        is_positive(-mass).then_some(-1.0)
    }

    /// The rates of `at`.
    fn slopes(&self, at: &Flight, u: &[f64], c: &[f64]) -> Option<Flight> {
        let (n, n_joints, width) = (self.n_states, self.joints.len(), at.width);
        let mut registers = vec![0.0; self.tape.n_registers()];
        (0..n).for_each(|i| registers[i] = at.state(i));
        registers[n..n + u.len()].copy_from_slice(u);
        self.tape.run(&mut registers);
        let values = |output: usize| registers[self.tape.outputs()[output] as usize];
        let (mut mass, mut acceleration) = (vec![0.0; n_joints * n_joints], vec![0.0; n_joints]);
        for (output, summand) in self.summands.iter().enumerate() {
            let value = c[summand.place] * summand.factor * values(output);
            match summand.with {
                Some(joint) => mass[summand.row * n_joints + joint] += value,
                None => acceleration[summand.row] -= value,
            }
        }
        let factored = Factored::new(mass, n_joints)?;
        factored.solve(&mut acceleration);
        // What the equation of each joint, with these accelerations, changes with parameters, and with each state.
        let mut right = vec![0.0; n_joints * width];
        let mut along = vec![0.0; n_joints * n];
        for (output, summand) in self.summands.iter().enumerate() {
            let with = summand.factor * summand.with.map_or(1.0, |joint| acceleration[joint]);
            right[summand.row * width + 1 + summand.place] -= with * values(output);
            for &(state, slope) in &summand.along {
                along[summand.row * n + state] += c[summand.place] * with * values(slope);
            }
        }
        let inverse = factored.inverse(n_joints);
        let mut slope = Flight { numbers: vec![0.0; at.numbers.len()], width };
        vectorized(
            #[inline(always)]
            || {
                for (right, along) in right.chunks_exact_mut(width).zip(along.chunks_exact(n)) {
                    for (state, &along) in along.iter().enumerate().filter(|(_, along)| **along != 0.0) {
                        right.iter_mut().zip(at.row(state)).skip(1).for_each(|(r, x)| *r -= along * x);
                    }
                }
                for (joint, &(q, v)) in self.joints.iter().enumerate() {
                    slope.row_mut(q).copy_from_slice(at.row(v));
                    for (right, &inverse) in right.chunks_exact(width).zip(&inverse[joint * n_joints..]) {
                        slope.row_mut(v).iter_mut().zip(right).for_each(|(s, r)| *s += inverse * r);
                    }
                    slope.row_mut(v)[0] = acceleration[joint];
                }
            },
        );
        slope.numbers.iter().all(|s| s.is_finite()).then_some(slope)
    }
}

/// A small matrix, row by row, as lower and upper triangles.
struct Factored {
    lu: Vec<f64>,
    order: Vec<usize>,
}

impl Factored {
    fn new(mut lu: Vec<f64>, n: usize) -> Option<Self> {
        let mut order: Vec<usize> = (0..n).collect();
        for k in 0..n {
            let best = (k..n).max_by(|&i, &j| lu[i * n + k].abs().total_cmp(&lu[j * n + k].abs()))?;
            if best != k {
                order.swap(k, best);
                (0..n).for_each(|j| lu.swap(k * n + j, best * n + j));
            }
            let pivot = lu[k * n + k];
            if pivot == 0.0 || !pivot.is_finite() {
                return None;
            }
            for i in k + 1..n {
                lu[i * n + k] /= pivot;
                for j in k + 1..n {
                    lu[i * n + j] -= lu[i * n + k] * lu[k * n + j];
                }
            }
        }
        Some(Self { lu, order })
    }

    fn solve(&self, b: &mut [f64]) {
        let n = b.len();
        let mut z: Vec<f64> = self.order.iter().map(|&i| b[i]).collect();
        for i in 0..n {
            for j in 0..i {
                z[i] -= self.lu[i * n + j] * z[j];
            }
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                z[i] -= self.lu[i * n + j] * z[j];
            }
            z[i] /= self.lu[i * n + i];
        }
        b.copy_from_slice(&z);
    }

    /// The inverse (n, n), row by row.
    fn inverse(&self, n: usize) -> Vec<f64> {
        let mut inverse = vec![0.0; n * n];
        let mut column = vec![0.0; n];
        for j in 0..n {
            column.fill(0.0);
            column[j] = 1.0;
            self.solve(&mut column);
            column.iter().enumerate().for_each(|(i, value)| inverse[i * n + j] = *value);
        }
        inverse
    }
}
