//! The right-hand side of a model's equations, explicit or implicit.

use std::cmp::Ordering;

use super::parts::Entry;

/// Numbers kept on the stack during an evaluation; larger models fall back to the heap.
pub(super) const STACK: usize = 96;

/// Smallest pivot, as part of the largest entry of its row, with which derivatives are solved for.
const SINGULAR: f64 = 1e-9;

/// ẋ = h + D ẋ, with h and D linear in the terms.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RightSide {
    /// Per equation: the coefficients and the registers of the terms that make h.
    explicit: Vec<Vec<(f64, u32)>>,
    /// The entries of D.
    coupled: Vec<Coupling>,
    /// States whose derivatives depend on each other through D.
    solved: Vec<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Coupling {
    row: usize,
    column: usize,
    coefficient: f64,
    register: u32,
}

impl RightSide {
    /// The right-hand side of `equations` over terms found in `registers`.
    pub(super) fn new(equations: &[Vec<Entry>], registers: &[u32]) -> Self {
        let explicit = |row: &Vec<Entry>| {
            row.iter().filter(|e| e.rate.is_none()).map(|e| (e.coefficient, registers[e.term])).collect()
        };
        let coupled: Vec<(usize, usize, &Entry)> = equations
            .iter()
            .enumerate()
            .flat_map(|(i, row)| row.iter().filter_map(move |e| e.rate.map(|l| (i, l, e))))
            .collect();
        let mut solved: Vec<usize> = coupled.iter().flat_map(|&(i, l, _)| [i, l]).collect();
        solved.sort_unstable();
        solved.dedup();
        let place = |i: usize| solved.partition_point(|&s| s < i);
        let coupling = |&(i, l, e): &(usize, usize, &Entry)| Coupling {
            row: place(i),
            column: place(l),
            coefficient: e.coefficient,
            register: registers[e.term],
        };
        let coupled = coupled.iter().map(coupling).collect();
        Self { explicit: equations.iter().map(explicit).collect(), coupled, solved }
    }

    /// Whether no derivative depends on another.
    pub(super) fn is_explicit(&self) -> bool {
        self.coupled.is_empty()
    }

    /// Writes ẋ of `L` places side by side, one after the other, of explicit equations.
    pub(super) fn eval_explicit<const L: usize>(&self, registers: &[[f64; L]], x_dot: &mut [f64]) {
        let n = self.explicit.len();
        for (i, weights) in self.explicit.iter().enumerate() {
            let mut sums = [-0.0; L];
            for (c, register) in weights {
                let values = &registers[*register as usize];
                sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += c * v);
            }
            for (l, sum) in sums.into_iter().enumerate() {
                x_dot[l * n + i] = sum;
            }
        }
    }

    /// Writes ẋ; NaN where the implicit equations are as good as singular.
    pub(super) fn eval(&self, registers: &[f64], x_dot: &mut [f64]) {
        self.sums(registers, x_dot);
        self.couple(registers, x_dot);
    }

    /// Writes h.
    #[inline(always)]
    pub(super) fn sums(&self, registers: &[f64], h: &mut [f64]) {
        for (out, weights) in h.iter_mut().zip(&self.explicit) {
            *out = weights.iter().map(|(c, r)| c * registers[*r as usize]).sum();
        }
    }

    /// Puts ẋ in the place of h.
    #[inline(always)]
    pub(super) fn couple(&self, registers: &[f64], x_dot: &mut [f64]) {
        if self.coupled.is_empty() {
            return;
        }
        match self.solved.len() {
            // A size the compiler knows: what mechanics of two bodies are, in the innermost loop of imagination.
            2 => self.solve_for(2, registers, &mut [0.0; 6], x_dot),
            q if q * (q + 1) <= STACK => self.solve_for(q, registers, &mut [0.0; STACK][..q * (q + 1)], x_dot),
            q => self.solve_for(q, registers, &mut vec![0.0; q * (q + 1)], x_dot),
        }
    }

    /// ∂ẋ/∂h over some `states` (q, q), row by row; NaN where the implicit equations are as good as singular.
    pub(super) fn response(&self, registers: &[f64], states: &[usize]) -> Vec<f64> {
        let q = states.len();
        let mut all = vec![0.0; q * q];
        let mut x_dot = vec![0.0; self.explicit.len()];
        for (j, state) in states.iter().enumerate() {
            x_dot.fill(0.0);
            x_dot[*state] = 1.0;
            self.couple(registers, &mut x_dot);
            states.iter().enumerate().for_each(|(i, state)| all[i * q + j] = x_dot[*state]);
        }
        all
    }

    /// Puts X of (I − D) X = H in the place of H (n, width), row by row; NaN where the implicit equations are as good as singular. `system` is room.
    pub(super) fn couple_rows(&self, registers: &[f64], system: &mut Vec<f64>, h: &mut [f64], width: usize) {
        let q = self.solved.len();
        let stride = q + width;
        system.clear();
        system.resize(q * stride, 0.0);
        for (i, &state) in self.solved.iter().enumerate() {
            system[i * stride + i] = 1.0;
            system[i * stride + q..(i + 1) * stride].copy_from_slice(&h[state * width..(state + 1) * width]);
        }
        for c in &self.coupled {
            system[c.row * stride + c.column] -= c.coefficient * registers[c.register as usize];
        }
        let regular = solve(system, q, stride);
        for (i, &state) in self.solved.iter().enumerate() {
            let row = &mut h[state * width..(state + 1) * width];
            row.copy_from_slice(&system[i * stride + q..(i + 1) * stride]);
            if !regular {
                row.fill(f64::NAN);
            }
        }
    }

    /// Puts the solution of the q implicit equations in the place of h; `system` is q (q + 1) zeros.
    #[inline(always)]
    fn solve_for(&self, q: usize, registers: &[f64], system: &mut [f64], x_dot: &mut [f64]) {
        let width = q + 1;
        for (i, &state) in self.solved.iter().enumerate().take(q) {
            system[i * width + i] = 1.0;
            system[i * width + q] = x_dot[state];
        }
        for c in &self.coupled {
            system[c.row * width + c.column] -= c.coefficient * registers[c.register as usize];
        }
        let regular = solve(system, q, width);
        for (i, &state) in self.solved.iter().enumerate().take(q) {
            x_dot[state] = if regular { system[i * width + q] } else { f64::NAN };
        }
    }
}

/// Solves the q equations in the rows (A | B), `width` numbers each, of `system` in place, by elimination with row exchanges; the solution takes the place of B.
/// `false` if A is as good as singular.
#[inline(always)]
fn solve(system: &mut [f64], q: usize, width: usize) -> bool {
    for k in 0..q {
        let size = |i: &usize| system[i * width + k].abs();
        let pivot = (k..q).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(k);
        let largest = (k..q).map(|j| system[pivot * width + j].abs()).fold(0.0, f64::max);
        // NaN is as good as singular.
        if system[pivot * width + k].abs().partial_cmp(&(SINGULAR * largest)) != Some(Ordering::Greater) {
            return false;
        }
        if pivot != k {
            for j in 0..width {
                system.swap(pivot * width + j, k * width + j);
            }
        }
        for i in 0..q {
            if i == k {
                continue;
            }
            let factor = system[i * width + k] / system[k * width + k];
            for j in k..width {
                system[i * width + j] -= factor * system[k * width + j];
            }
        }
    }
    for k in 0..q {
        (q..width).for_each(|j| system[k * width + j] /= system[k * width + k]);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coupled(term: usize, coefficient: f64, rate: usize) -> Entry {
        Entry { term, coefficient, rate: Some(rate) }
    }

    #[test]
    fn coupled_derivatives_are_solved_for() {
        // a = 3 + 0.5 b, b = 1 − 2 a: a = 1.75, b = −2.5; the third equation is explicit.
        let equations = [
            vec![Entry::new(0, 3.0), coupled(0, 0.5, 1)],
            vec![Entry::new(0, 1.0), coupled(0, -2.0, 0)],
            vec![Entry::new(1, 4.0)],
        ];
        let right = RightSide::new(&equations, &[0, 1]);
        let mut x_dot = [0.0; 3];
        right.eval(&[1.0, 0.25], &mut x_dot);
        for (got, expected) in x_dot.iter().zip([1.75, -2.5, 1.0]) {
            assert!((got - expected).abs() < 1e-15, "{x_dot:?}");
        }
    }

    #[test]
    fn singular_equations_give_no_number() {
        let equations = [vec![Entry::new(0, 1.0), coupled(0, 1.0, 1)], vec![coupled(0, 1.0, 0)]];
        let mut x_dot = [0.0; 2];
        RightSide::new(&equations, &[0]).eval(&[1.0], &mut x_dot);
        assert!(x_dot.iter().all(|v| v.is_nan()));
    }
}
