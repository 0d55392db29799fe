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
        tape.extend(terms);
        tape
    }

    /// Compiles further terms; those before them can still be computed without these.
    pub(crate) fn extend<'a>(&mut self, terms: impl IntoIterator<Item = &'a Expr>) {
        for term in terms {
            let register = self.compile(term);
            self.outputs.push(register);
        }
    }

    /// Number of variables.
    pub(crate) fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    /// Number of operations.
    pub(crate) fn n_ops(&self) -> usize {
        self.ops.len()
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
        self.run_first(registers.as_chunks_mut::<1>().0, self.ops.len());
    }

    /// The same of `L` places side by side, with the first `n_ops` operations alone: the terms that were compiled first.
    pub(crate) fn run_first<const L: usize>(&self, registers: &mut [[f64; L]], n_ops: usize) {
        for (slot, op) in self.ops[..n_ops].iter().enumerate() {
            let (known, rest) = registers.split_at_mut(self.n_inputs + slot);
            let at = |r: u32| &known[r as usize];
            let value: [f64; L] = match *op {
                Op::Constant(c) => [c; L],
                Op::Neg(a) => at(a).map(|a| -a),
                Op::Add(a, b) => both(at(a), at(b), |a, b| a + b),
                Op::Sub(a, b) => both(at(a), at(b), |a, b| a - b),
                Op::Mul(a, b) => both(at(a), at(b), |a, b| a * b),
                Op::Div(a, b) => both(at(a), at(b), |a, b| a / b),
                Op::Power(a, n) => at(a).map(|a| power(a, n)),
                Op::Call(f, a) => at(a).map(|a| f.eval(a)),
            };
            rest[0] = value;
        }
    }

    /// The register of each term.
    pub(crate) fn outputs(&self) -> &[u32] {
        &self.outputs
    }
}

/// `of` the numbers of every place.
fn both<const L: usize>(a: &[f64; L], b: &[f64; L], of: impl Fn(f64, f64) -> f64) -> [f64; L] {
    std::array::from_fn(|l| of(a[l], b[l]))
}
