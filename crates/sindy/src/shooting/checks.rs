//! What equations do at the samples.

use ndarray::Array2;

use super::flow::{Flow, Summand};
use crate::data::Segment;

/// Part of its largest value that the factor of a derivative keeps everywhere.
const LEAST: f64 = 0.02;

/// Part of that which is the derivative itself, at least: without it the equation is one of the product.
const SHARE: f64 = 1e-4;

impl Flow {
    /// What the summand of each coefficient adds to the rates, RMS over the samples `x` (T + 1, n) of `segments`, as a multiple of the
    /// RMS of these rates; one for each coefficient. Of equations that are next to singular it is large.
    pub(crate) fn contributions(&self, segments: &[Segment], x: &[Array2<f64>], xi: &[f64]) -> Vec<f64> {
        let (n, p) = (self.n, self.n_parameters);
        let mut scratch = self.scratch();
        let mut sums = vec![0.0; n * p];
        let mut rates = vec![0.0; n];
        for (segment, x) in segments.iter().zip(x) {
            for (now, u) in x.rows().into_iter().zip(segment.u.rows()) {
                self.rates_at(&now.to_vec(), &u.to_vec(), xi, &mut scratch);
                rates.iter_mut().zip(&scratch.f).for_each(|(sum, [f])| *sum += f * f);
                sums.iter_mut().zip(&scratch.f_xi).for_each(|(sum, [f])| *sum += f * f);
            }
        }
        let of = |parameter: usize| {
            let relative = (0..n).filter(|&i| rates[i] > 0.0).map(|i| sums[i * p + parameter] / rates[i]);
            xi[parameter].abs() * relative.sum::<f64>().sqrt()
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
