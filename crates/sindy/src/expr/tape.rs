//! Terms compiled to a straight line of operations; a subexpression that occurs twice is computed once.

use super::{Expr, Function, power};

/// One operation; its result goes to the register after those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Op {
    Constant(f64),
    Neg(u32),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    Power(u32, i32),
    Call(Function, u32),
}

/// Compiled terms. Registers 0..n_inputs hold z, the others the results of the operations in order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tape {
    n_inputs: usize,
    ops: Vec<Op>,
    outputs: Vec<u32>,
}

impl Tape {
    /// Compiles `terms` over `n_inputs` variables. No term may use a variable beyond them.
    pub(crate) fn new<'a>(n_inputs: usize, terms: impl IntoIterator<Item = &'a Expr>) -> Self {
        let mut tape = Self { n_inputs, ops: Vec::new(), outputs: Vec::new() };
        tape.outputs = terms.into_iter().map(|term| tape.compile(term)).collect();
        tape
    }

    fn compile(&mut self, expr: &Expr) -> u32 {
        let op = match expr {
            Expr::Variable(i) => return *i as u32,
            Expr::Constant(c) => Op::Constant(*c),
            Expr::Neg(a) => Op::Neg(self.compile(a)),
            Expr::Add(a, b) => Op::Add(self.compile(a), self.compile(b)),
            Expr::Sub(a, b) => Op::Sub(self.compile(a), self.compile(b)),
            Expr::Mul(a, b) => Op::Mul(self.compile(a), self.compile(b)),
            Expr::Div(a, b) => Op::Div(self.compile(a), self.compile(b)),
            Expr::Power(a, n) => Op::Power(self.compile(a), *n),
            Expr::Call(f, a) => Op::Call(*f, self.compile(a)),
        };
        let slot = self.ops.iter().position(|known| *known == op).unwrap_or_else(|| {
            self.ops.push(op);
            self.ops.len() - 1
        });
        (self.n_inputs + slot) as u32
    }

    /// Registers a caller must provide.
    pub(crate) fn n_registers(&self) -> usize {
        self.n_inputs + self.ops.len()
    }

    /// Computes every term; the first registers must hold z.
    pub(crate) fn run(&self, registers: &mut [f64]) {
        let (inputs, results) = registers.split_at_mut(self.n_inputs);
        for (slot, op) in self.ops.iter().enumerate() {
            let at = |r: u32| {
                let r = r as usize;
                if r < self.n_inputs { inputs[r] } else { results[r - self.n_inputs] }
            };
            let value = match *op {
                Op::Constant(c) => c,
                Op::Neg(a) => -at(a),
                Op::Add(a, b) => at(a) + at(b),
                Op::Sub(a, b) => at(a) - at(b),
                Op::Mul(a, b) => at(a) * at(b),
                Op::Div(a, b) => at(a) / at(b),
                Op::Power(a, n) => power(at(a), n),
                Op::Call(f, a) => f.eval(at(a)),
            };
            results[slot] = value;
        }
    }

    /// The register of each term.
    pub(crate) fn outputs(&self) -> &[u32] {
        &self.outputs
    }
}
