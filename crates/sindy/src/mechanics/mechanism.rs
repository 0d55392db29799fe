//! Accelerations of joints, and steps with what they change with the parameters.

use nalgebra::DMatrix;

use crate::expr::Tape;
use crate::library::Lagrangian;
use crate::motion::Stepping;

/// Part of a state by which it is moved where derivatives are taken.
const NUDGE: f64 = 1e-6;

/// A summand of the equation of a joint.
struct Summand {
    /// Place of its parameter among those that are used.
    place: usize,
    row: usize,
    /// The joint whose acceleration it multiplies, if any.
    with: Option<usize>,
    factor: f64,
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

/// A state and what it changes with each parameter, and each state at the start, one after the other: (1 + P + S) times n numbers.
pub(super) type Flight = Vec<f64>;

impl Mechanism {
    /// With the parameters `chosen`.
    pub(super) fn new(lagrangian: &Lagrangian, chosen: &[usize], (n_states, n_controls): (usize, usize)) -> Self {
        let joint = |speed: usize| lagrangian.joints.iter().position(|(_, v)| *v == speed);
        let mut exprs = Vec::new();
        let mut summands = Vec::new();
        for (place, &p) in chosen.iter().enumerate() {
            for (row, (expr, rate), factor) in lagrangian.summands(p) {
                summands.push(Summand { place, row, with: rate.and_then(joint), factor });
                exprs.push(expr);
            }
        }
        let tape = Tape::new(n_states + n_controls, &exprs);
        Self { joints: lagrangian.joints.clone(), n_states, n_parameters: chosen.len(), n_starts: 0, tape, summands }
    }

    /// The same whose flights tell what they change with the state at their start, too.
    pub(super) fn with_starts(self) -> Self {
        Self { n_starts: self.n_states, ..self }
    }

    /// The state `x`, which no parameter changes.
    pub(super) fn start(&self, x: &[f64]) -> Flight {
        let n = self.n_states;
        let mut at = vec![0.0; n * (1 + self.n_columns())];
        at[..n].copy_from_slice(x);
        (0..self.n_starts).for_each(|i| at[(1 + self.n_parameters + i) * n + i] = 1.0);
        at
    }

    /// Parameters and states at the start.
    fn n_columns(&self) -> usize {
        self.n_parameters + self.n_starts
    }

    /// The state `dt` seconds after `at` under `u` with the parameters `c`, and what it changes with each of them. `None` where masses are singular.
    pub(super) fn step(&self, at: Flight, u: &[f64], c: &[f64], dt: f64, stepping: Stepping) -> Option<Flight> {
        let (n, mut at) = (self.n_states, at);
        match stepping {
            Stepping::Euler => {
                let slope = self.slopes(&at, u, c)?;
                Some(moved(&at, &slope, dt))
            }
            Stepping::SemiImplicit { substeps } => {
                let h = dt / substeps as f64;
                for _ in 0..substeps {
                    let slope = self.slopes(&at, u, c)?;
                    for block in 0..=self.n_columns() {
                        for &(q, v) in &self.joints {
                            let (q, v) = (block * n + q, block * n + v);
                            at[v] += h * slope[v];
                            at[q] += h * at[v];
                        }
                    }
                }
                Some(at)
            }
            Stepping::Continuous { substeps } | Stepping::Classical { substeps } => {
                let h = dt / substeps as f64;
                for _ in 0..substeps {
                    let first = self.slopes(&at, u, c)?;
                    let second = self.slopes(&moved(&at, &first, 0.5 * h), u, c)?;
                    let third = self.slopes(&moved(&at, &second, 0.5 * h), u, c)?;
                    let fourth = self.slopes(&moved(&at, &third, h), u, c)?;
                    for (i, at) in at.iter_mut().enumerate() {
                        *at += h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]);
                    }
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
        let (n, n_joints, n_columns) = (self.n_states, self.joints.len(), self.n_columns());
        let mut registers = vec![0.0; self.tape.n_registers()];
        registers[..n].copy_from_slice(&at[..n]);
        registers[n..n + u.len()].copy_from_slice(u);
        self.tape.run(&mut registers);
        let (mut mass, mut rest) = (vec![0.0; n_joints * n_joints], vec![0.0; n_joints]);
        for (summand, &r) in self.summands.iter().zip(self.tape.outputs()) {
            let value = c[summand.place] * summand.factor * registers[r as usize];
            match summand.with {
                Some(joint) => mass[summand.row * n_joints + joint] += value,
                None => rest[summand.row] -= value,
            }
        }
        // Right sides: accelerations, and what of them each parameter changes.
        let width = 1 + n_columns;
        let mut right = vec![0.0; n_joints * width];
        let factored = Factored::new(mass, n_joints)?;
        let mut acceleration = rest;
        factored.solve(&mut acceleration);
        (0..n_joints).for_each(|i| right[i * width] = 0.0);
        for (summand, &r) in self.summands.iter().zip(self.tape.outputs()) {
            let with = summand.with.map_or(1.0, |joint| acceleration[joint]);
            right[summand.row * width + 1 + summand.place] -= summand.factor * registers[r as usize] * with;
        }
        let along = self.along_states(&at[..n], u, c, &acceleration);
        let mut slope = vec![0.0; at.len()];
        for (joint, &(q, v)) in self.joints.iter().enumerate() {
            slope[q] = at[v];
            slope[v] = acceleration[joint];
        }
        let mut column = vec![0.0; n_joints];
        for p in 0..n_columns {
            let block = &at[(1 + p) * n..(2 + p) * n];
            for (i, value) in column.iter_mut().enumerate() {
                let moved: f64 = self
                    .joints
                    .iter()
                    .enumerate()
                    .map(|(joint, &(q, v))| {
                        let of = |part: usize| along[(i * n_joints + joint) * 2 + part];
                        of(0) * block[q] + of(1) * block[v]
                    })
                    .sum();
                *value = right[i * width + 1 + p] - moved;
            }
            factored.solve(&mut column);
            for (joint, &(q, v)) in self.joints.iter().enumerate() {
                slope[(1 + p) * n + q] = block[v];
                slope[(1 + p) * n + v] = column[joint];
            }
        }
        slope.iter().all(|s| s.is_finite()).then_some(slope)
    }

    /// What the equation of each joint, with these accelerations, changes with position and speed of each: (joint, joint, 2).
    fn along_states(&self, x: &[f64], u: &[f64], c: &[f64], acceleration: &[f64]) -> Vec<f64> {
        let n_joints = self.joints.len();
        let mut registers = vec![[0.0; 2]; self.tape.n_registers()];
        let mut along = vec![0.0; n_joints * n_joints * 2];
        for (joint, &(q, v)) in self.joints.iter().enumerate() {
            for (part, state) in [q, v].into_iter().enumerate() {
                registers.iter_mut().zip(x.iter().chain(u)).for_each(|(r, z)| *r = [*z; 2]);
                let by = NUDGE * x[state].abs().max(1.0);
                registers[state] = [x[state] + by, x[state] - by];
                self.tape.run_first(&mut registers, self.tape.n_ops());
                for (summand, &r) in self.summands.iter().zip(self.tape.outputs()) {
                    let [up, down] = registers[r as usize];
                    let with = summand.with.map_or(1.0, |other| acceleration[other]);
                    let slope = c[summand.place] * summand.factor * with * (up - down) / (2.0 * by);
                    along[(summand.row * n_joints + joint) * 2 + part] += slope;
                }
            }
        }
        along
    }
}

fn moved(at: &Flight, slope: &Flight, h: f64) -> Flight {
    at.iter().zip(slope).map(|(x, s)| x + h * s).collect()
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
}
