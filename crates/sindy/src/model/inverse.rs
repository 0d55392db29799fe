//! Which inputs a motion needs.

use super::Model;
use crate::expr::Expr;

impl Model {
    /// The inputs u (k) with which the states `x` (n) have the rates `x_dot` (n): the inverse dynamics. `None` unless the equations of states whose rates are no states are as many as
    /// the inputs, and linear in them.
    ///
    /// With ẋ = f(x, ẋ) + B(x) u this is u = B⁻¹ (ẋ − f). Of a mechanical system, u(q, 0; 0) are the inputs that hold it against gravity, u(q, 0; q̈) − u(q, 0; 0) those of
    /// inertia, u(q, q̇; 0) − u(q, 0; 0) those of Coriolis and centrifugal forces and of friction.
    #[must_use]
    pub fn inverse_dynamics(&self, x: &[f64], x_dot: &[f64]) -> Option<Vec<f64>> {
        let rows: Vec<usize> = (0..self.parts.kinematic.len()).filter(|&i| !self.parts.kinematic[i]).collect();
        let k = self.parts.controls.len();
        if rows.len() != k || self.readings().is_some() || x.len() != self.parts.states.len() {
            return None;
        }
        let terms = self.shifted_terms();
        let n = x.len();
        let is_input = |expr: &Expr| (n..n + k).any(|j| expr.has(j));
        let is_linear = |term: &Expr| (n..n + k).all(|j| term.derivative(j).is_none_or(|slope| !is_input(&slope)));
        if !terms.iter().all(is_linear) {
            return None;
        }
        let left = |u: &[f64]| -> Vec<f64> {
            let z = [x, u].concat();
            let of = |&i: &usize| {
                let sum = self.parts.equations[i].iter().fold(0.0, |sum, entry| {
                    sum + entry.coefficient * terms[entry.term].eval(&z) * entry.rate.map_or(1.0, |l| x_dot[l])
                });
                x_dot[i] - sum
            };
            rows.iter().map(of).collect()
        };
        let without = left(&vec![0.0; k]);
        // (B | ẋ − f), row by row.
        let mut matrix = vec![vec![0.0; k + 1]; k];
        for j in 0..k {
            let mut unit = vec![0.0; k];
            unit[j] = 1.0;
            left(&unit)
                .iter()
                .zip(&without)
                .zip(&mut matrix)
                .for_each(|((with, without), row)| row[j] = without - with);
        }
        matrix.iter_mut().zip(&without).for_each(|(row, without)| row[k] = *without);
        solved(matrix)
    }
}

/// x of A x = b, by elimination in (A | b) with row exchanges; `None` if A is singular.
fn solved(mut matrix: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = matrix.len();
    for j in 0..n {
        let pivot = (j..n).max_by(|&a, &b| matrix[a][j].abs().total_cmp(&matrix[b][j].abs()))?;
        matrix.swap(j, pivot);
        let row = matrix[j].clone();
        if row[j] == 0.0 {
            return None;
        }
        for (_, other) in matrix.iter_mut().enumerate().filter(|(i, other)| *i != j && other[j] != 0.0) {
            let factor = other[j] / row[j];
            other.iter_mut().zip(&row).skip(j).for_each(|(value, of)| *value -= factor * of);
        }
    }
    let values: Vec<f64> = matrix.iter().enumerate().map(|(j, row)| row[n] / row[j]).collect();
    values.iter().all(|v| v.is_finite()).then_some(values)
}

#[cfg(test)]
mod tests {
    use crate::model::{Entry, Form, Model, ModelParts};
    use sindyna_core::{Scheme, VectorField};

    /// Two coupled joints: v̇ = −sin q + 0.3 v̇' cos q + 2 u and v̇' = 0.4 v̇ cos q − v' + u'/(1 + …).
    fn joints(second: &str) -> Model {
        let terms = ["v", "w", "sin(q)", "cos(q)", "u", second].map(str::to_owned).to_vec();
        let implicit = |term, coefficient, rate| Entry { rate: Some(rate), ..Entry::new(term, coefficient) };
        Model::new(ModelParts {
            states: ["q", "p", "v", "w"].map(str::to_owned).to_vec(),
            controls: ["u", "f"].map(str::to_owned).to_vec(),
            form: Form::Continuous(Scheme::Rk4 { substeps: 1 }),
            dt: 0.1,
            readings: None,
            terms,
            equations: vec![
                vec![Entry::new(0, 1.0)],
                vec![Entry::new(1, 1.0)],
                vec![Entry::new(2, -1.0), implicit(3, 0.3, 3), Entry::new(4, 2.0)],
                vec![implicit(3, 0.4, 2), Entry::new(1, -1.0), Entry::new(5, 1.0), Entry::new(4, 0.5)],
            ],
            kinematic: vec![true, true, false, false],
            offsets: vec![0.0; 4],
            n_features: 6,
        })
        .unwrap()
    }

    #[test]
    fn the_inputs_of_a_motion_are_those_that_made_it() {
        let (model, x, u) = (joints("f*cos(p)"), [0.7, -0.4, 1.2, 0.3], [0.8, -1.7]);
        let mut x_dot = [0.0; 4];
        model.eval(&x, &u, &mut x_dot);
        let found = model.inverse_dynamics(&x, &x_dot).unwrap();
        assert!(found.iter().zip(u).all(|(found, u)| (found - u).abs() < 1e-14), "{found:?}");
    }

    #[test]
    fn what_cannot_be_solved_for_inputs_has_none() {
        let (x, x_dot) = ([0.7, -0.4, 1.2, 0.3], [0.1; 4]);
        assert_eq!(joints("f^2").inverse_dynamics(&x, &x_dot), None);
        assert_eq!(joints("v").inverse_dynamics(&x, &x_dot), None, "one input acts nowhere");
        assert_eq!(joints("f").inverse_dynamics(&x[..3], &x_dot), None);
    }
}
