//! What equations do at the samples.

use ndarray::Array2;

use super::flow::{Flow, Summand};
use crate::data::Segment;

/// Part of its largest value that the factor of a derivative keeps everywhere.
const LEAST: f64 = 0.02;

/// Part of that which is the derivative itself, at least: without it the equation is one of the product.
const SHARE: f64 = 1e-4;

/// What the summand of a coefficient adds to the rates, RMS, as a multiple of the RMS of these.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contribution {
    pub(crate) whole: f64,
    /// The part of it that the constant of the equation cannot make up for; all of it where there is none.
    pub(crate) beyond_constant: f64,
}

impl Flow {
    /// What the summand of each coefficient adds to the rates at the samples `x` (T + 1, n) of `segments`; `constants` are for each the
    /// number of the coefficient of the constant in its equation. Of equations that are next to singular it is large.
    pub(crate) fn contributions(
        &self,
        segments: &[Segment],
        x: &[Array2<f64>],
        xi: &[f64],
        constants: &[Option<usize>],
    ) -> Vec<Contribution> {
        let (n, p) = (self.n, self.n_parameters);
        let mut scratch = self.scratch();
        let mut squares = vec![0.0; n * p];
        let mut with_constant = vec![0.0; n * p];
        let mut rates = vec![0.0; n];
        for (segment, x) in segments.iter().zip(x) {
            for (now, u) in x.rows().into_iter().zip(segment.u.rows()) {
                self.rates_at(&now.to_vec(), &u.to_vec(), xi, &mut scratch);
                rates.iter_mut().zip(&scratch.f).for_each(|(sum, [f])| *sum += f * f);
                for (i, row) in scratch.f_xi.chunks_exact(p.max(1)).enumerate() {
                    for (parameter, [f]) in row.iter().enumerate() {
                        squares[i * p + parameter] += f * f;
                        if let Some([one]) = constants.get(parameter).copied().flatten().map(|c| row[c]) {
                            with_constant[i * p + parameter] += f * one;
                        }
                    }
                }
            }
        }
        let of = |parameter: usize| {
            let relative = |left: &dyn Fn(usize) -> f64| {
                let sum = (0..n).filter(|&i| rates[i] > 0.0).map(|i| left(i).max(0.0) / rates[i]).sum::<f64>();
                xi[parameter].abs() * sum.sqrt()
            };
            let whole = |i: usize| squares[i * p + parameter];
            let shared = |i: usize| {
                let one = constants[parameter].map_or(0.0, |c| squares[i * p + c]);
                if one > 0.0 { with_constant[i * p + parameter].powi(2) / one } else { 0.0 }
            };
            Contribution { whole: relative(&whole), beyond_constant: relative(&|i| whole(i) - shared(i)) }
        };
        (0..p - self.inside.len()).map(of).collect()
    }

    /// Whether what each equation multiplies its own derivative by, 1 − Σ ξ w, stays away from zero at the samples `x` (T + 1, n) of
    /// `segments`: where it vanishes the state may be anywhere a moment later.
    pub(crate) fn is_regular(&self, segments: &[Segment], x: &[Array2<f64>], xi: &[f64]) -> bool {
        let own: Vec<&Summand> = self.summands.iter().filter(|s| s.rate == Some(s.row)).collect();
        let mut registers = vec![[0.0]; self.tape.n_registers()];
        let mut modes = vec![[0.0]; self.switches.len()];
        let mut factor = vec![(0.0_f64, 0.0_f64, 0.0_f64); self.n];
        for (segment, x) in segments.iter().zip(x) {
            for (now, u) in x.rows().into_iter().zip(segment.u.rows()).take_while(|_| !own.is_empty()) {
                registers.iter_mut().zip(now.iter().chain(u)).for_each(|(slot, v)| *slot = [*v]);
                self.fill_inside(&mut registers, xi);
                self.signs(&mut registers, &mut modes);
                self.tape.run_first(&mut registers, self.n_ops_of_rates);
                let mut values = vec![1.0; self.n];
                for s in &own {
                    values[s.row] -= s.times(xi) * registers[self.values[s.term] as usize][0];
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
}
