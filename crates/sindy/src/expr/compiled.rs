//! A term that is evaluated many times.

use super::{Expr, Tape};

/// Registers on the stack during an evaluation; longer terms fall back to the heap.
const STACK: usize = 96;

/// A term compiled to a straight line of operations: a subexpression that occurs twice is computed once. Its values are those of [`Expr::eval`].
#[derive(Debug, Clone, PartialEq)]
pub struct Compiled {
    tape: Tape,
    /// The register of the value.
    value: usize,
}

impl Compiled {
    /// Compiles `term` over `n_variables` variables z; `None` if it has one beyond them.
    #[must_use]
    pub fn new(term: &Expr, n_variables: usize) -> Option<Self> {
        if term.max_variable().is_some_and(|i| i >= n_variables) {
            return None;
        }
        let tape = Tape::new(n_variables, [term]);
        let value = tape.outputs().first().map_or(0, |register| *register as usize);
        Some(Self { tape, value })
    }

    /// The value at z.
    ///
    /// # Panics
    /// If z has another number of variables.
    #[must_use]
    pub fn eval(&self, z: &[f64]) -> f64 {
        match self.tape.n_registers() {
            needed if needed <= STACK => self.eval_in(&mut [0.0; STACK][..needed], z),
            needed => self.eval_in(&mut vec![0.0; needed], z),
        }
    }

    fn eval_in(&self, registers: &mut [f64], z: &[f64]) -> f64 {
        registers[..self.tape.n_inputs()].copy_from_slice(z);
        self.tape.run(registers);
        registers[self.value]
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    #[test]
    fn values_are_those_of_the_term() {
        let names = ["x".to_owned(), "y".to_owned()];
        for text in ["3", "y", "x*y - exp(-x^2)*x*y", "max(x*y, 1) + clip(x, -1, 1)"] {
            let term = parse(text, &names).expect("a term");
            let compiled = Compiled::new(&term, 2).expect("two variables are enough");
            for z in [[0.3, -2.0], [1.7, 0.9]] {
                assert_eq!(compiled.eval(&z).to_bits(), term.eval(&z).to_bits(), "{text}");
            }
        }
        assert_eq!(Compiled::new(&Expr::Variable(2), 2), None);
    }
}
