//! How the right-hand side depends on state and input: partial derivatives of the terms, compiled when they are first asked for.

use std::sync::{Arc, OnceLock};

use super::Model;
use crate::expr::{Expr, Tape};

/// The terms of a model and their partial derivatives in one tape. The terms lie in the registers in which the model's own tape has them.
#[derive(Debug)]
struct Slopes {
    tape: Tape,
    /// Per term: the variables of z = (state; control) that it depends on, each with the register of that derivative.
    by: Vec<Vec<(usize, u32)>>,
}

impl Slopes {
    fn new(terms: &[Expr], n_variables: usize) -> Self {
        let mut tape = Tape::new(n_variables, terms);
        let mut by = Vec::with_capacity(terms.len());
        for term in terms {
            let (variables, slopes): (Vec<usize>, Vec<Expr>) =
                (0..n_variables).filter_map(|j| Some((j, term.derivative(j)?))).unzip();
            let first = tape.outputs().len();
            tape.extend(&slopes);
            by.push(variables.into_iter().zip(tape.outputs()[first..].iter().copied()).collect());
        }
        Self { tape, by }
    }
}

/// The derivatives, shared by all models with the same terms.
#[derive(Debug, Clone, Default)]
pub(super) struct Shared(Arc<OnceLock<Slopes>>);

impl PartialEq for Shared {
    /// The terms say it all.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Room for right-hand sides and their slopes.
#[derive(Debug, Default)]
pub(super) struct Room {
    registers: Vec<f64>,
    system: Vec<f64>,
    /// The right-hand side f (n).
    pub(super) f: Vec<f64>,
    /// ∂f/∂(x; u) (n, n + k), row by row.
    pub(super) slopes: Vec<f64>,
}

impl Model {
    /// Writes f and ∂f/∂(x; u) at a state `z` of the model into `room`; `None` where the equations cannot be solved for the rates.
    pub(super) fn with_slopes(&self, z: &[f64], u: &[f64], room: &mut Room) -> Option<()> {
        let (n, width) = (z.len(), z.len() + u.len());
        let Slopes { tape, by } = self.slopes.0.get_or_init(|| Slopes::new(&self.terms, width));
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
}
