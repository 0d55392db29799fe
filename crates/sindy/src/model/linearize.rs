//! How a step of a model depends on the state and the input.

use ndarray::Array2;
use sindyna_core::{Jacobians, Scheme};

use super::slopes::{Room, Slopes};
use super::{Form, Model};

/// Weights of the stages of Runge–Kutta of fourth order, and how far of a step each lies, by the rates of the one before.
const STAGES: [(f64, f64); 4] = [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)];

/// ∂x/∂(x₀; u) (n, n + k), row by row.
type Sensitivity = Vec<f64>;

impl Model {
    /// ∂x⁺/∂x (n, n) and ∂x⁺/∂u (n, k) of one control interval, from the terms and as it is stepped; `None` for models of raw observations, and where the
    /// equations cannot be solved for the rates.
    pub(super) fn of_step(&self, x: &[f64], u: &[f64]) -> Option<Jacobians> {
        if self.readings().is_some() {
            return None;
        }
        let (n, width) = (x.len(), x.len() + u.len());
        let mut room = Room::default();
        let mut all: Sensitivity = vec![0.0; n * width];
        (0..n).for_each(|i| all[i * width + i] = 1.0);
        let mut rates = vec![0.0; n * width];
        match self.parts.form {
            Form::Discrete => {
                self.rates(x, u, &all, &mut room, &mut rates)?;
                all = rates;
            }
            Form::Increment | Form::Continuous(Scheme::Euler) => {
                self.rates(x, u, &all, &mut room, &mut rates)?;
                add(&mut all, self.parts.dt, &rates);
            }
            Form::SemiImplicit { substeps } => {
                let h = self.parts.dt / substeps.max(1) as f64;
                let mut x = x.to_vec();
                for _ in 0..substeps.max(1) {
                    self.rates(&x, u, &all, &mut room, &mut rates)?;
                    let before = all.clone();
                    add(&mut all, h, &rates);
                    let mut next = x.clone();
                    add(&mut next, h, &room.f);
                    for &i in &self.positions {
                        let mut moved = 0.0;
                        let mut row = before[i * width..(i + 1) * width].to_vec();
                        for entry in &self.parts.equations[i] {
                            let term = &self.terms[entry.term];
                            moved += entry.coefficient * term.eval(&next);
                            for j in 0..n {
                                let slope = term.derivative(j).map_or(0.0, |d| d.eval(&next));
                                add(&mut row, h * entry.coefficient * slope, &all[j * width..(j + 1) * width]);
                            }
                        }
                        next[i] = x[i] + h * moved;
                        all[i * width..(i + 1) * width].copy_from_slice(&row);
                    }
                    x = next;
                }
            }
            Form::Continuous(Scheme::Rk4 { substeps }) => {
                let h = self.parts.dt / substeps.max(1) as f64;
                let mut x = x.to_vec();
                let (mut at, mut s) = (x.clone(), all.clone());
                let (mut step, mut slope) = (vec![0.0; n], vec![0.0; n * width]);
                for _ in 0..substeps.max(1) {
                    step.fill(0.0);
                    slope.fill(0.0);
                    for (stage, (part, weight)) in STAGES.into_iter().enumerate() {
                        at.copy_from_slice(&x);
                        s.copy_from_slice(&all);
                        if stage > 0 {
                            add(&mut at, part * h, &room.f);
                            add(&mut s, part * h, &rates);
                        }
                        self.rates(&at, u, &s, &mut room, &mut rates)?;
                        add(&mut step, weight / 6.0 * h, &room.f);
                        add(&mut slope, weight / 6.0 * h, &rates);
                    }
                    add(&mut x, 1.0, &step);
                    add(&mut all, 1.0, &slope);
                }
            }
        }
        let part =
            |first: usize, columns: usize| Array2::from_shape_fn((n, columns), |(i, j)| all[i * width + first + j]);
        all.iter().all(|v| v.is_finite()).then(|| (part(0, n), part(n, u.len())))
    }

    /// Writes f and ∂f/∂(x; u) at a state `z` of the model into `room`; `None` where the equations cannot be solved for the rates.
    pub(super) fn with_slopes(&self, z: &[f64], u: &[f64], room: &mut Room) -> Option<()> {
        let (n, width) = (z.len(), z.len() + u.len());
        let Slopes { tape, by } = self.slopes.of(&self.terms, width);
        let Room { registers, system, f, slopes } = room;
        registers.resize(tape.n_registers(), 0.0);
        f.resize(n, 0.0);
        self.place(registers, z, u);
        tape.run(registers);
        self.right.eval(registers, f);
        slopes.clear();
        slopes.resize(n * width, 0.0);
        // (I − D) f = h, so (I − D) ∂f = ∂h + ∂D f.
        for (row, slopes) in self.parts.equations.iter().zip(slopes.chunks_exact_mut(width)) {
            for entry in row {
                let times = entry.coefficient * entry.rate.map_or(1.0, |l| f[l]);
                by[entry.term].iter().for_each(|(j, register)| slopes[*j] += times * registers[*register as usize]);
            }
        }
        self.right.couple_rows(registers, system, slopes, width);
        slopes.iter().all(|v| v.is_finite()).then_some(())
    }

    /// Writes the sensitivity of f at `x`, of which that of x itself is `s`.
    fn rates(&self, x: &[f64], u: &[f64], s: &[f64], room: &mut Room, rates: &mut [f64]) -> Option<()> {
        let (n, width) = (x.len(), x.len() + u.len());
        self.with_slopes(x, u, room)?;
        for (rates, slopes) in rates.chunks_exact_mut(width).zip(room.slopes.chunks_exact(width)) {
            rates[..n].fill(0.0);
            rates[n..].copy_from_slice(&slopes[n..]);
            for (slope, s) in slopes[..n].iter().zip(s.chunks_exact(width)) {
                add(rates, *slope, s);
            }
        }
        Some(())
    }
}

/// a + c b in the place of a.
fn add(a: &mut [f64], c: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += c * b);
}
