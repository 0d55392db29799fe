//! How a step of a model depends on the state and the input.

use ndarray::{Array2, Axis, concatenate, s};
use sindyna_core::{Jacobians, Scheme};

use super::{Form, Model};

impl Model {
    /// ∂x⁺/∂x (n, n) and ∂x⁺/∂u (n, k) of one control interval, from the terms and as it is stepped; `None` for models of raw observations, and where the
    /// equations cannot be solved for the rates.
    pub(super) fn of_step(&self, x: &[f64], u: &[f64]) -> Option<Jacobians> {
        let n = x.len();
        // ∂x/∂(x; u), and the same of the rates.
        let start = concatenate![Axis(1), Array2::eye(n), Array2::zeros((n, u.len()))];
        let of_rates = |x: &[f64], s: &Array2<f64>| {
            let (a, b) = self.jacobians(x, u).ok()?;
            let mut rates = a.dot(s);
            rates.slice_mut(s![.., n..]).scaled_add(1.0, &b);
            Some(rates)
        };
        let all = match self.parts.form {
            Form::Discrete => of_rates(x, &start)?,
            Form::Increment | Form::Continuous(Scheme::Euler) => &start + &(of_rates(x, &start)? * self.parts.dt),
            Form::SemiImplicit { substeps } => {
                let h = self.parts.dt / substeps.max(1) as f64;
                let (mut x, mut all) = (x.to_vec(), start);
                for _ in 0..substeps.max(1) {
                    let mut next = vec![0.0; n];
                    self.right_side(&x, u, &mut next);
                    next.iter_mut().zip(&x).for_each(|(next, x)| *next = x + h * *next);
                    let before = all.clone();
                    all = &before + &(of_rates(&x, &before)? * h);
                    for &i in &self.positions {
                        let (mut moved, mut row) = (0.0, before.row(i).to_owned());
                        for entry in &self.parts.equations[i] {
                            let term = &self.terms[entry.term];
                            moved += entry.coefficient * term.eval(&next);
                            for j in 0..n {
                                let slope = term.derivative(j).map_or(0.0, |d| d.eval(&next));
                                row.scaled_add(h * entry.coefficient * slope, &all.row(j));
                            }
                        }
                        next[i] = x[i] + h * moved;
                        all.row_mut(i).assign(&row);
                    }
                    x = next;
                }
                all
            }
            Form::Continuous(Scheme::Rk4 { substeps }) => {
                let h = self.parts.dt / substeps.max(1) as f64;
                let (mut x, mut all) = (x.to_vec(), start);
                for _ in 0..substeps.max(1) {
                    let (mut k, mut s) = (vec![0.0; n], Array2::zeros(all.dim()));
                    let (mut step, mut slope) = (vec![0.0; n], Array2::<f64>::zeros(all.dim()));
                    for (part, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
                        let at: Vec<f64> = x.iter().zip(&k).map(|(x, k)| x + part * h * k).collect();
                        s = of_rates(&at, &(&all + &(s * (part * h))))?;
                        self.right_side(&at, u, &mut k);
                        step.iter_mut().zip(&k).for_each(|(step, k)| *step += weight / 6.0 * h * k);
                        slope.scaled_add(weight / 6.0 * h, &s);
                    }
                    x.iter_mut().zip(&step).for_each(|(x, step)| *x += step);
                    all += &slope;
                }
                all
            }
        };
        all.iter()
            .all(|v| v.is_finite())
            .then(|| (all.slice(s![.., ..n]).to_owned(), all.slice(s![.., n..]).to_owned()))
    }
}
