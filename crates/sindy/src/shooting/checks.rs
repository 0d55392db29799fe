//! What equations do at the samples.

use ndarray::Array2;

use super::flow::{Flow, Summand};
use crate::data::Segment;

/// Part of its largest value that the factor of a derivative keeps everywhere.
const LEAST: f64 = 0.02;

/// Part of that which is the derivative itself, at least: without it the equation is one of the product.
const SHARE: f64 = 1e-4;

/// What the summand of a coefficient adds to the rates, as a multiple of the RMS of these.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contribution {
    /// All of it, RMS.
    pub(crate) whole: f64,
    /// The part that no constant in the equation makes up for, RMS.
    pub(crate) beyond_constant: f64,
    /// The part that a constant makes up for, with its sign.
    pub(crate) constant: f64,
}

/// Where a coefficient stands: the row of its equation, and the number of the coefficient of the constant there.
pub(crate) type Place = (usize, Option<usize>);

impl Flow {
    /// What the summand of each coefficient, whose places are `places`, adds to the rates at the samples `x` (T + 1, n) of `segments`. Of equations
    /// that are next to singular it is large.
    pub(crate) fn contributions(
        &self,
        segments: &[Segment],
        x: &[Array2<f64>],
        xi: &[f64],
        places: &[Place],
    ) -> Vec<Contribution> {
        let (n, p) = (self.n, self.n_parameters);
        let mut scratch = self.scratch();
        let mut squares = vec![0.0; n * p];
        let (mut with_one, mut ones) = (vec![0.0; n * p], vec![0.0; n * p]);
        let mut rates = vec![0.0; n];
        for (segment, x) in segments.iter().zip(x) {
            for (now, u) in x.rows().into_iter().zip(segment.u.rows()) {
                self.rates_at(&now.to_vec(), &u.to_vec(), xi, &mut scratch);
                rates.iter_mut().zip(&scratch.f).for_each(|(sum, [f])| *sum += f * f);
                for (i, row) in scratch.f_xi.chunks_exact(p.max(1)).enumerate() {
                    for (parameter, ([f], (equation, constant))) in row.iter().zip(places).enumerate() {
                        // What a constant would add; where equations are coupled only those that are there tell.
                        let one = match constant {
                            Some(constant) => row[*constant][0],
                            None => f64::from(i == *equation && !self.coupled.contains(equation)),
                        };
                        let at = i * p + parameter;
                        squares[at] += f * f;
                        with_one[at] += f * one;
                        ones[at] += one * one;
                    }
                }
            }
        }
        let of = |parameter: usize| {
            let rows = (0..n).filter(|&i| rates[i] > 0.0).map(|i| (i * p + parameter, rates[i]));
            let shared = |at: usize| if ones[at] > 0.0 { with_one[at] / ones[at].sqrt() } else { 0.0 };
            let sum = |part: &dyn Fn(usize) -> f64| rows.clone().map(|(at, rate)| part(at) / rate).sum::<f64>();
            Contribution {
                whole: xi[parameter].abs() * sum(&|at| squares[at]).sqrt(),
                beyond_constant: xi[parameter].abs() * sum(&|at| (squares[at] - shared(at).powi(2)).max(0.0)).sqrt(),
                constant: xi[parameter] * rows.clone().map(|(at, rate)| shared(at) / rate.sqrt()).sum::<f64>(),
            }
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
