//! The map from one sample to the next, with its exact derivatives.

use nalgebra::DMatrix;
use ndarray::Array2;

use super::tableau::{EIGHTH, FOURTH, Tableau};
use crate::chain::after_their_rates;
use crate::data::Segment;
use crate::expr::Tape;
use crate::library::Term;
use crate::motion::Stepping;

/// A summand of an equation: coefficient × term, times the derivative of state `rate` if there is one.
#[derive(Debug, Clone, Copy)]
struct Summand {
    row: usize,
    /// Number of the term in [`Flow::values`].
    term: usize,
    rate: Option<usize>,
    /// Number of the coefficient.
    parameter: usize,
}

/// Equations of given structure, stepped by a scheme: x⁺ = F(x, u; ξ) with ∂F/∂x and ∂F/∂ξ by the variational equations.
#[derive(Debug, Clone)]
pub(crate) struct Flow {
    n: usize,
    n_controls: usize,
    n_parameters: usize,
    tape: Tape,
    /// Registers of the terms in use.
    values: Vec<u32>,
    /// Per term: (state, register) of the partial derivatives that are not zero.
    partials: Vec<Vec<(usize, u32)>>,
    summands: Vec<Summand>,
    /// Per state: the state that is declared to be its rate.
    rates: Vec<Option<usize>>,
    /// States with declared rates, each after its rate.
    positions: Vec<usize>,
    stepping: Stepping,
    /// Whether all substeps are classical ones of order four, as those of a model are.
    classical: bool,
    implicit: bool,
}

/// A place on the way through one step, with its weight in the average.
pub(crate) struct Stage<'a> {
    pub(crate) weight: f64,
    /// (x; u) there.
    pub(crate) z: &'a [f64],
    /// ẋ there.
    pub(crate) x_dot: &'a [f64],
}

/// Substeps per interval in which derivatives are followed, at most.
const DERIVATIVE_SUBSTEPS: usize = 2;

/// Substeps from which on one step of order eight stands for so many of order four: it is the more accurate one.
const OF_EIGHTH: usize = 8;

/// Part of its largest value that the factor of a derivative keeps everywhere.
const LEAST: f64 = 0.02;

/// Part of that which is the derivative itself, at least: without it the equation is one of the product.
const SHARE: f64 = 1e-4;

/// Stages of a step, at most.
const STAGES: usize = 11;

impl Flow {
    /// The flow of the equations whose terms are numbered in `supports`, one list per state; coefficients are numbered equation by
    /// equation. States with declared `rates` have no terms.
    pub(crate) fn new(
        terms: &[Term],
        supports: &[Vec<usize>],
        rates: &[Option<usize>],
        n_controls: usize,
        stepping: Stepping,
    ) -> Self {
        let n = rates.len();
        let mut used: Vec<usize> = supports.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let place = |j: &usize| used.partition_point(|u| u < j);
        let mut summands = Vec::new();
        for (row, support) in supports.iter().enumerate() {
            for j in support {
                let parameter = summands.len();
                summands.push(Summand { row, term: place(j), rate: terms[*j].rate, parameter });
            }
        }
        let derivatives: Vec<(usize, usize, crate::Expr)> = used
            .iter()
            .enumerate()
            .flat_map(|(at, &j)| (0..n).filter_map(move |i| terms[j].expr.derivative(i).map(|d| (at, i, d))))
            .collect();
        let expressions = used.iter().map(|&j| &terms[j].expr).chain(derivatives.iter().map(|(_, _, d)| d));
        let tape = Tape::new(n + n_controls, expressions);
        let (values, rest) = tape.outputs().split_at(used.len());
        let mut partials = vec![Vec::new(); used.len()];
        for ((term, state, _), &register) in derivatives.iter().zip(rest) {
            partials[*term].push((*state, register));
        }
        // A circle of rates has no order: nothing moves by the new rates then.
        let positions = after_their_rates(n, |i| rates[i]).unwrap_or_default();
        Self {
            n,
            n_controls,
            n_parameters: summands.len(),
            values: values.to_vec(),
            partials,
            implicit: summands.iter().any(|s| s.rate.is_some()),
            summands,
            rates: rates.to_vec(),
            positions,
            stepping,
            classical: false,
            tape,
        }
    }

    pub(crate) fn n_parameters(&self) -> usize {
        self.n_parameters
    }

    /// The equation each coefficient belongs to.
    pub(crate) fn row_of(&self, parameter: usize) -> usize {
        self.summands[parameter].row
    }

    pub(crate) fn stepping(&self) -> Stepping {
        self.stepping
    }

    /// The same equations stepped in another way.
    pub(crate) fn with_stepping(&self, stepping: Stepping) -> Self {
        Self { stepping, ..self.clone() }
    }

    /// The same with classical substeps only.
    pub(crate) fn classical(&self) -> Self {
        Self { classical: true, ..self.clone() }
    }

    /// The same with no more substeps than derivatives need: they only point the way to the next iterate.
    pub(crate) fn for_derivatives(&self) -> Self {
        match self.stepping {
            Stepping::Continuous { substeps } => {
                self.with_stepping(Stepping::Continuous { substeps: substeps.min(DERIVATIVE_SUBSTEPS) })
            }
            _ => self.clone(),
        }
    }

    /// Scratch space for [`Self::step`].
    pub(crate) fn scratch(&self) -> Scratch {
        let (n, width) = (self.n, self.n + self.n_parameters);
        Scratch {
            registers: vec![0.0; self.tape.n_registers()],
            f: vec![0.0; n],
            coupled: DMatrix::zeros(n, n),
            column: vec![0.0; n],
            f_x: vec![0.0; n * n],
            f_xi: vec![0.0; n * self.n_parameters],
            stage: vec![0.0; n],
            slopes: vec![0.0; STAGES * n],
            s_stage: vec![0.0; n * width],
            s_slopes: vec![0.0; STAGES * n * width],
        }
    }

    /// ẋ at (x; u), and with `derivatives` ∂ẋ/∂x (n, n) and ∂ẋ/∂ξ (n, p), into the scratch space. NaN where the implicit equations
    /// are singular.
    fn rates(&self, x: &[f64], u: &[f64], xi: &[f64], derivatives: bool, scratch: &mut Scratch) {
        let Scratch { registers, f, f_x, f_xi, coupled, column, .. } = scratch;
        let (n, p) = (self.n, self.n_parameters);
        registers[..n].copy_from_slice(x);
        registers[n..n + self.n_controls].copy_from_slice(u);
        self.tape.run(registers);
        let value = |s: &Summand| registers[self.values[s.term] as usize];
        f.fill(0.0);
        for (i, rate) in self.rates.iter().enumerate() {
            if let Some(v) = rate {
                f[i] = x[*v];
            }
        }
        for s in self.summands.iter().filter(|s| s.rate.is_none()) {
            f[s.row] += xi[s.parameter] * value(s);
        }
        let inverse = self.implicit.then(|| {
            coupled.fill_with_identity();
            for s in &self.summands {
                if let Some(l) = s.rate {
                    coupled[(s.row, l)] -= xi[s.parameter] * value(s);
                }
            }
            if !coupled.try_inverse_mut() {
                coupled.fill(f64::NAN);
            }
            column.copy_from_slice(f);
            for (i, f) in f.iter_mut().enumerate() {
                *f = (0..n).map(|j| coupled[(i, j)] * column[j]).sum();
            }
            &*coupled
        });
        if !derivatives {
            return;
        }
        f_x.fill(0.0);
        f_xi.fill(0.0);
        for (i, rate) in self.rates.iter().enumerate() {
            if let Some(v) = rate {
                f_x[i * n + v] = 1.0;
            }
        }
        for s in &self.summands {
            let times = s.rate.map_or(1.0, |l| f[l]);
            f_xi[s.row * p + s.parameter] = value(s) * times;
            for &(k, register) in &self.partials[s.term] {
                f_x[s.row * n + k] += xi[s.parameter] * registers[register as usize] * times;
            }
        }
        if let Some(inverse) = inverse {
            for (matrix, width) in [(f_x, n), (f_xi, p)] {
                for j in 0..width {
                    (0..n).for_each(|k| column[k] = matrix[k * width + j]);
                    for i in 0..n {
                        matrix[i * width + j] = (0..n).map(|k| inverse[(i, k)] * column[k]).sum();
                    }
                }
            }
        }
    }

    /// What the summand of each coefficient adds to the rates, RMS over the samples `x` (T + 1, n) of `segments`, as a multiple of the
    /// RMS of these rates (p). Of equations that are next to singular it is large.
    pub(crate) fn contributions(&self, segments: &[Segment], x: &[Array2<f64>], xi: &[f64]) -> Vec<f64> {
        let (n, p) = (self.n, self.n_parameters);
        let mut scratch = self.scratch();
        let mut sums = vec![0.0; n * p];
        let mut rates = vec![0.0; n];
        for (segment, x) in segments.iter().zip(x) {
            for (now, u) in x.rows().into_iter().zip(segment.u.rows()) {
                self.rates(&now.to_vec(), &u.to_vec(), xi, true, &mut scratch);
                rates.iter_mut().zip(&scratch.f).for_each(|(sum, f)| *sum += f * f);
                sums.iter_mut().zip(&scratch.f_xi).for_each(|(sum, f)| *sum += f * f);
            }
        }
        let of = |parameter: usize| {
            let relative = (0..n).filter(|&i| rates[i] > 0.0).map(|i| sums[i * p + parameter] / rates[i]);
            xi[parameter].abs() * relative.sum::<f64>().sqrt()
        };
        (0..p).map(of).collect()
    }

    /// Whether what each equation multiplies its own derivative by, 1 − Σ ξ w, stays away from zero at the samples `x` (T + 1, n) of
    /// `segments`: where it vanishes the state may be anywhere a moment later.
    pub(crate) fn is_regular(&self, segments: &[Segment], x: &[Array2<f64>], xi: &[f64]) -> bool {
        let own: Vec<&Summand> = self.summands.iter().filter(|s| s.rate == Some(s.row)).collect();
        let mut registers = vec![0.0; self.tape.n_registers()];
        let mut factor = vec![(0.0_f64, 0.0_f64, 0.0_f64); self.n];
        for (segment, x) in segments.iter().zip(x) {
            for (now, u) in x.rows().into_iter().zip(segment.u.rows()).take_while(|_| !own.is_empty()) {
                registers.iter_mut().zip(now.iter().chain(u)).for_each(|(slot, v)| *slot = *v);
                self.tape.run(&mut registers);
                let mut values = vec![1.0; self.n];
                for s in &own {
                    values[s.row] -= xi[s.parameter] * registers[self.values[s.term] as usize];
                }
                for ((low, high, reach), value) in factor.iter_mut().zip(values) {
                    if *reach == 0.0 {
                        (*low, *high) = (value, value);
                    }
                    (*low, *high) = (low.min(value), high.max(value));
                    *reach = reach.max(value.abs());
                }
            }
        }
        factor.iter().all(|(low, high, reach)| low.max(-high) >= LEAST * reach && SHARE * reach <= 1.0)
    }

    /// Writes x⁺ one step of `dt` \[s\] later, and with `s` also ∂x⁺/∂(x; ξ) (n, n + p), row by row. `visit` sees the stages. `false`
    /// if a number is not finite.
    pub(crate) fn step(
        &self,
        (x, u, dt): (&[f64], &[f64], f64),
        xi: &[f64],
        next: &mut [f64],
        mut s: Option<&mut [f64]>,
        scratch: &mut Scratch,
        visit: &mut dyn FnMut(&Stage<'_>),
    ) -> bool {
        let (n, width) = (self.n, self.n + self.n_parameters);
        next.copy_from_slice(x);
        if let Some(s) = s.as_deref_mut() {
            s.fill(0.0);
            (0..n).for_each(|i| s[i * width + i] = 1.0);
        }
        let mut z = vec![0.0; n + self.n_controls];
        z[n..].copy_from_slice(u);
        match self.stepping {
            Stepping::Euler | Stepping::SemiImplicit => {
                self.rates(x, u, xi, s.is_some(), scratch);
                z[..n].copy_from_slice(x);
                visit(&Stage { weight: 1.0, z: &z, x_dot: &scratch.f });
                (0..n).for_each(|i| next[i] += dt * scratch.f[i]);
                if let Some(s) = s.as_deref_mut() {
                    add_slopes(s, dt, &scratch.f_x, &scratch.f_xi, n, self.n_parameters);
                }
                if self.stepping == Stepping::SemiImplicit {
                    for &i in &self.positions {
                        let Some(v) = self.rates[i] else { continue };
                        next[i] = x[i] + dt * next[v];
                        if let Some(s) = s.as_deref_mut() {
                            for j in 0..width {
                                s[i * width + j] = if i == j { 1.0 } else { 0.0 } + dt * s[v * width + j];
                            }
                        }
                    }
                }
            }
            Stepping::Continuous { substeps } => {
                let (tableau, substeps) = self.scheme(substeps);
                let h = dt / substeps as f64;
                for _ in 0..substeps {
                    for (stage, row) in tableau.a.iter().enumerate() {
                        let mut at = std::mem::take(&mut scratch.stage);
                        for i in 0..n {
                            let slopes = row.iter().enumerate().map(|(j, a)| a * scratch.slopes[j * n + i]);
                            at[i] = next[i] + h * slopes.sum::<f64>();
                        }
                        self.rates(&at, u, xi, s.is_some(), scratch);
                        if tableau.b[stage] > 0.0 {
                            z[..n].copy_from_slice(&at);
                            let weight = tableau.b[stage] / substeps as f64;
                            visit(&Stage { weight, z: &z, x_dot: &scratch.f });
                        }
                        scratch.stage = at;
                        scratch.slopes[stage * n..(stage + 1) * n].copy_from_slice(&scratch.f);
                        if let Some(s) = s.as_deref_mut() {
                            self.variation(stage, row, h, s, scratch);
                        }
                    }
                    for (stage, b) in tableau.b.iter().enumerate().filter(|(_, b)| **b > 0.0) {
                        (0..n).for_each(|i| next[i] += b * h * scratch.slopes[stage * n + i]);
                        if let Some(s) = s.as_deref_mut() {
                            let slopes = &scratch.s_slopes[stage * n * width..(stage + 1) * n * width];
                            s.iter_mut().zip(slopes).for_each(|(s, slope)| *s += b * h * slope);
                        }
                    }
                }
            }
        }
        next.iter().all(|v| v.is_finite()) && s.is_none_or(|s| s.iter().all(|v| v.is_finite()))
    }

    /// The scheme and its number of steps for an interval of `substeps`: many of them are too few for the classical one.
    fn scheme(&self, substeps: usize) -> (&'static Tableau, usize) {
        if substeps < OF_EIGHTH || self.classical { (&FOURTH, substeps) } else { (&EIGHTH, substeps / OF_EIGHTH) }
    }

    /// The slope of ∂x/∂(x₀; ξ) at stage number `stage`, which is `row` of the scheme.
    fn variation(&self, stage: usize, row: &[f64], h: f64, s: &[f64], scratch: &mut Scratch) {
        let (n, p) = (self.n, self.n_parameters);
        let width = n + p;
        let (before, now) = scratch.s_slopes.split_at_mut(stage * n * width);
        scratch.s_stage.copy_from_slice(s);
        for (slopes, a) in before.chunks_exact(n * width).zip(row).filter(|(_, a)| **a != 0.0) {
            scratch.s_stage.iter_mut().zip(slopes).for_each(|(slot, slope)| *slot += a * h * slope);
        }
        let at = &scratch.s_stage;
        for i in 0..n {
            let row = &mut now[i * width..(i + 1) * width];
            row[..n].fill(0.0);
            row[n..].copy_from_slice(&scratch.f_xi[i * p..(i + 1) * p]);
            for k in 0..n {
                let slope = scratch.f_x[i * n + k];
                if slope != 0.0 {
                    row.iter_mut().zip(&at[k * width..(k + 1) * width]).for_each(|(r, a)| *r += slope * a);
                }
            }
        }
    }
}

/// Adds dt [∂ẋ/∂x | ∂ẋ/∂ξ] to S.
fn add_slopes(s: &mut [f64], dt: f64, f_x: &[f64], f_xi: &[f64], n: usize, p: usize) {
    for (i, row) in s.chunks_exact_mut(n + p).enumerate() {
        row[..n].iter_mut().zip(&f_x[i * n..(i + 1) * n]).for_each(|(s, v)| *s += dt * v);
        row[n..].iter_mut().zip(&f_xi[i * p..(i + 1) * p]).for_each(|(s, v)| *s += dt * v);
    }
}

/// Memory a step works in.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    registers: Vec<f64>,
    f: Vec<f64>,
    coupled: DMatrix<f64>,
    column: Vec<f64>,
    f_x: Vec<f64>,
    f_xi: Vec<f64>,
    stage: Vec<f64>,
    slopes: Vec<f64>,
    s_stage: Vec<f64>,
    s_slopes: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;

    /// A cart with a pole: rates on the right.
    fn flow(stepping: Stepping) -> (Flow, Vec<f64>) {
        let names: Vec<String> = ["x", "a", "v", "w", "u"].map(String::from).into();
        let term = |text: &str, rate| Term {
            expr: parse(text, &names).expect("a term"),
            name: text.into(),
            complexity: 0,
            rate,
        };
        let terms = [
            term("u", None),
            term("w^2*sin(a)", None),
            term("cos(a)", Some(3)),
            term("sin(a)", None),
            term("cos(a)", Some(2)),
            term("w", None),
        ];
        let supports = vec![vec![], vec![], vec![0, 1, 2], vec![3, 4, 5]];
        let rates = [Some(2), Some(3), None, None];
        (Flow::new(&terms, &supports, &rates, 1, stepping), vec![0.9, 0.045, -0.045, 14.7, -1.5, -0.1])
    }

    #[test]
    fn derivatives_of_a_step_are_those_of_differences() {
        for stepping in [Stepping::Euler, Stepping::SemiImplicit, Stepping::Continuous { substeps: 2 }] {
            let (flow, xi) = flow(stepping);
            let (x, u, dt) = ([0.1, 0.4, -0.3, 0.8], [1.3], 0.1);
            let mut scratch = flow.scratch();
            let mut step = |x: &[f64], xi: &[f64], s: Option<&mut [f64]>| {
                let mut next = vec![0.0; 4];
                assert!(flow.step((x, &u, dt), xi, &mut next, s, &mut scratch, &mut |_| {}));
                next
            };
            let mut s = vec![0.0; 4 * 10];
            step(&x, &xi, Some(&mut s));
            for j in 0..10 {
                let mut at = |h: f64| {
                    let (mut x, mut xi) = (x, xi.clone());
                    if j < 4 {
                        x[j] += h
                    } else {
                        xi[j - 4] += h
                    }
                    step(&x, &xi, None)
                };
                let (up, down) = (at(1e-6), at(-1e-6));
                for i in 0..4 {
                    let difference = (up[i] - down[i]) / 2e-6;
                    assert!((s[i * 10 + j] - difference).abs() < 1e-8, "{stepping:?} {i} {j}");
                }
            }
        }
    }
}
