//! Equations as a graph. A step of several parts is unrolled, so that no runtime has to know loops.

use sindyna_sindy::export::{Stepping, System};
use sindyna_sindy::{Entry, Expr, Function};

use super::graph::Builder;
use super::proto::data_type;

/// The graph from `x`, (batch, n), and `u`, (batch, k), where there are inputs, to `next`, (batch, n).
pub(crate) fn write(system: &System, text: &[String]) -> Vec<u8> {
    let mut builder = Builder::default();
    let n = system.states.len();
    let x = builder.columns("x", n);
    let u = if system.controls.is_empty() { Vec::new() } else { builder.columns("u", system.controls.len()) };
    let mut graph = Writer { builder, system, u };
    let next = graph.step(&x);
    let mut builder = graph.builder;
    // A sum of constants alone is one number for all of the batch.
    let shape = builder.op("Shape", &[&x[0]]);
    let next: Vec<String> = next.iter().map(|column| builder.op("Expand", &[column, &shape])).collect();
    let next: Vec<&str> = next.iter().map(String::as_str).collect();
    builder.output("next", n, "Concat", &next, Some(("axis", 1)));
    builder.file("step", text)
}

/// Values are columns (batch, 1) or numbers (1, 1).
pub(super) struct Writer<'a> {
    pub(super) builder: Builder,
    pub(super) system: &'a System,
    pub(super) u: Vec<String>,
}

impl<'a> Writer<'a> {
    pub(super) fn op(&mut self, kind: &str, inputs: &[&str]) -> String {
        self.builder.op(kind, inputs)
    }

    fn step(&mut self, x: &[String]) -> Vec<String> {
        let dt = self.system.dt;
        let mut at = x.to_vec();
        let system = self.system;
        match &system.stepping {
            Stepping::Map => self.sums(x),
            Stepping::Rk4 { substeps } => {
                let h = dt / *substeps as f64;
                for _ in 0..*substeps {
                    at = self.classical(&at, h);
                }
                at
            }
            Stepping::Friction(friction) => self.rubbed(friction, dt, x),
            Stepping::SemiImplicitEuler { positions, substeps } => {
                let h = dt / *substeps as f64;
                for _ in 0..*substeps {
                    let rates = self.rates(&at);
                    let mut moved = self.ahead(&at, h, &rates);
                    for &i in positions {
                        let rate = self.rates(&moved).swap_remove(i);
                        moved[i] = self.ahead(&at[i..=i], h, &[rate]).swap_remove(0);
                    }
                    at = moved;
                }
                at
            }
            _ => {
                let rates = self.rates(x);
                self.ahead(x, dt, &rates)
            }
        }
    }

    /// `at` a time h later: one step of classical Runge–Kutta.
    pub(super) fn classical(&mut self, at: &[String], h: f64) -> Vec<String> {
        let k1 = self.rates(at);
        let k2 = self.rates_ahead(at, 0.5 * h, &k1);
        let k3 = self.rates_ahead(at, 0.5 * h, &k2);
        let k4 = self.rates_ahead(at, h, &k3);
        let slopes = k1.iter().zip(&k2).zip(k3.iter().zip(&k4));
        let sums: Vec<String> = slopes
            .map(|((k1, k2), (k3, k4))| {
                let two = self.builder.number(2.0);
                let (k2, k3) = (self.op("Mul", &[&two, k2]), self.op("Mul", &[&two, k3]));
                let sum = self.op("Add", &[k1, &k2]);
                let sum = self.op("Add", &[&sum, &k3]);
                self.op("Add", &[&sum, k4])
            })
            .collect();
        self.ahead(at, h / 6.0, &sums)
    }

    /// x + by · k.
    pub(super) fn ahead(&mut self, x: &[String], by: f64, k: &[String]) -> Vec<String> {
        let by = self.builder.number(by);
        x.iter()
            .zip(k)
            .map(|(x, k)| {
                let moved = self.op("Mul", &[&by, k]);
                self.op("Add", &[x, &moved])
            })
            .collect()
    }

    fn rates_ahead(&mut self, x: &[String], by: f64, k: &[String]) -> Vec<String> {
        let at = self.ahead(x, by, k);
        self.rates(&at)
    }

    /// The sums of all equations without the entries that multiply rates.
    fn sums(&mut self, x: &[String]) -> Vec<String> {
        let system = self.system;
        let free = |row: &'_ Vec<Entry>| row.iter().filter(|e| e.rate.is_none()).copied().collect::<Vec<_>>();
        system.equations.iter().map(|row| self.sum(x, &free(row))).collect()
    }

    fn sum(&mut self, x: &[String], entries: &[Entry]) -> String {
        let system = self.system;
        let mut sum: Option<String> = None;
        for entry in entries {
            let coefficient = self.builder.number(entry.coefficient);
            let summand = match &system.terms[entry.term] {
                one if one.is_one() => coefficient,
                term => {
                    let term = self.term(x, term);
                    self.op("Mul", &[&coefficient, &term])
                }
            };
            sum = Some(match sum {
                Some(before) => self.op("Add", &[&before, &summand]),
                None => summand,
            });
        }
        sum.unwrap_or_else(|| self.builder.number(0.0))
    }

    /// The sums, solved for the rates where equations hold some: those of the rows that hold none are known, the others are solved for.
    pub(super) fn rates(&mut self, x: &[String]) -> Vec<String> {
        let mut rates = self.sums(x);
        let system = self.system;
        let coupled: Vec<usize> =
            (0..rates.len()).filter(|&i| system.equations[i].iter().any(|e| e.rate.is_some())).collect();
        let mut rows = Vec::new();
        for &i in &coupled {
            let mut row = Vec::new();
            for l in 0..rates.len() {
                let of: Vec<Entry> = system.equations[i].iter().filter(|e| e.rate == Some(l)).copied().collect();
                let factor = self.sum(x, &of);
                if coupled.contains(&l) {
                    let one = self.builder.number(if i == l { 1.0 } else { 0.0 });
                    row.push(self.op("Sub", &[&one, &factor]));
                } else if !of.is_empty() {
                    let product = self.op("Mul", &[&factor, &rates[l]]);
                    rates[i] = self.op("Add", &[&rates[i], &product]);
                }
            }
            row.push(rates[i].clone());
            rows.push(row);
        }
        for (&i, solved) in coupled.iter().zip(self.solve(rows)) {
            rates[i] = solved;
        }
        rates
    }

    /// Gaussian elimination with the largest pivot of each column, which is exchanged for every element of the batch by itself; the right side is the
    /// last number of each row.
    fn solve(&mut self, mut rows: Vec<Vec<String>>) -> Vec<String> {
        let n = rows.len();
        for k in 0..n {
            for i in k + 1..n {
                let (below, here) = (self.op("Abs", &[&rows[i][k]]), self.op("Abs", &[&rows[k][k]]));
                let larger = self.op("Greater", &[&below, &here]);
                let (upper, lower) = rows.split_at_mut(i);
                for (a, b) in upper[k].iter_mut().zip(&mut lower[0]).skip(k) {
                    (*a, *b) = (self.op("Where", &[&larger, b, a]), self.op("Where", &[&larger, a, b]));
                }
            }
            for i in k + 1..n {
                let factor = self.op("Div", &[&rows[i][k], &rows[k][k]]);
                let (upper, lower) = rows.split_at_mut(i);
                for (a, b) in upper[k].iter().zip(&mut lower[0]).skip(k + 1) {
                    *b = self.less(b, &factor, a);
                }
            }
        }
        let mut solved = vec![String::new(); n];
        for k in (0..n).rev() {
            let mut value = rows[k][n].clone();
            for (factor, known) in rows[k].iter().zip(&solved).skip(k + 1) {
                value = self.less(&value, factor, known);
            }
            solved[k] = self.op("Div", &[&value, &rows[k][k]]);
        }
        solved
    }

    /// a − b · c.
    pub(super) fn less(&mut self, a: &str, b: &str, c: &str) -> String {
        let product = self.op("Mul", &[b, c]);
        self.op("Sub", &[a, &product])
    }

    fn term(&mut self, x: &[String], expr: &Expr) -> String {
        let two = |graph: &mut Self, kind: &str, a: &Expr, b: &Expr| {
            let (a, b) = (graph.term(x, a), graph.term(x, b));
            graph.op(kind, &[&a, &b])
        };
        match expr {
            Expr::Constant(c) => self.builder.number(*c),
            Expr::Variable(i) => x.get(*i).unwrap_or_else(|| &self.u[i - x.len()]).clone(),
            Expr::Neg(a) => {
                let a = self.term(x, a);
                self.op("Neg", &[&a])
            }
            Expr::Add(a, b) => two(self, "Add", a, b),
            Expr::Sub(a, b) => two(self, "Sub", a, b),
            Expr::Mul(a, b) => two(self, "Mul", a, b),
            Expr::Div(a, b) => two(self, "Div", a, b),
            Expr::Power(a, exponent) => {
                let (a, exponent) = (self.term(x, a), self.builder.number(f64::from(*exponent)));
                self.op("Pow", &[&a, &exponent])
            }
            Expr::Call(function, a) => {
                let a = self.term(x, a);
                self.call(*function, &a)
            }
        }
    }

    /// The inverse tangent, which ONNX Runtime has in single precision alone: two of Newton's steps for sin y = a cos y make it one of double precision.
    fn atan(&mut self, a: &str) -> String {
        let single = self.builder.cast(a, data_type::FLOAT);
        let rough = self.op("Atan", &[&single]);
        let mut y = self.builder.cast(&rough, data_type::DOUBLE);
        for _ in 0..2 {
            let (sine, cosine) = (self.op("Sin", &[&y]), self.op("Cos", &[&y]));
            let (ahead, slope) = (self.op("Mul", &[a, &cosine]), self.op("Mul", &[a, &sine]));
            let (left, slope) = (self.op("Sub", &[&ahead, &sine]), self.op("Add", &[&cosine, &slope]));
            let by = self.op("Div", &[&left, &slope]);
            y = self.op("Add", &[&y, &by]);
        }
        y
    }

    fn call(&mut self, function: Function, a: &str) -> String {
        let kind = match function {
            Function::Sin => "Sin",
            Function::Cos => "Cos",
            Function::Exp => "Exp",
            Function::Log => "Log",
            Function::Sqrt => "Sqrt",
            Function::Abs => "Abs",
            Function::Sign => "Sign",
            Function::Tanh => "Tanh",
            // ONNX Runtime has tangents of single precision alone.
            Function::Tan => {
                let (sine, cosine) = (self.op("Sin", &[a]), self.op("Cos", &[a]));
                return self.op("Div", &[&sine, &cosine]);
            }
            Function::Atan => return self.atan(a),
            Function::PositivePart => {
                let zero = self.builder.number(0.0);
                let negative = self.op("Less", &[a, &zero]);
                return self.op("Where", &[&negative, &zero, a]);
            }
        };
        self.op(kind, &[a])
    }
}
