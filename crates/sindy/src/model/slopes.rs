//! Partial derivatives of a model's terms, compiled when they are first asked for.

use std::sync::{Arc, OnceLock};

use crate::expr::{Expr, Tape};

/// The terms of a model and their partial derivatives in one tape. The terms lie in the registers in which the model's own tape has them.
#[derive(Debug)]
pub(super) struct Slopes {
    pub(super) tape: Tape,
    /// Per term: the variables of z = (state; control) that it depends on, each with the register of that derivative.
    pub(super) by: Vec<Vec<(usize, u32)>>,
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

impl Shared {
    /// Those of `terms` over so many variables.
    pub(super) fn of(&self, terms: &[Expr], n_variables: usize) -> &Slopes {
        self.0.get_or_init(|| Slopes::new(terms, n_variables))
    }
}

impl PartialEq for Shared {
    /// The terms say it all.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Room for right-hand sides and their slopes.
#[derive(Debug, Default)]
pub(super) struct Room {
    pub(super) registers: Vec<f64>,
    pub(super) system: Vec<f64>,
    /// The right-hand side f (n).
    pub(super) f: Vec<f64>,
    /// ∂f/∂(x; u) (n, n + k), row by row.
    pub(super) slopes: Vec<f64>,
}
