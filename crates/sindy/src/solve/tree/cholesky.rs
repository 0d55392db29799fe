//! The Cholesky factor of a node's Gram matrix.

use super::node::Node;
use crate::solve::problem::{dot, square};

/// The factor L of a node's columns in reverse order, L Lᵀ = S.
///
/// In reverse order, because the first i rows of L⁻¹c then belong to the last i columns.
pub(super) struct Factor {
    /// (f, f) by rows, lower triangle.
    rows: Vec<f64>,
    f: usize,
}

/// Part of a bound that rounding may take.
const SHARE: f64 = 1e-4;

impl Factor {
    /// The factor, unless rounding of the products would be seen in what is computed from it.
    pub(super) fn of(node: &Node) -> Option<Self> {
        Self::shifted(node, 0.0).filter(|factor| {
            let smallest = (0..factor.f).map(|i| factor.rows[i * factor.f + i]).fold(1.0, f64::min);
            node.error.gram * factor.f as f64 <= SHARE * smallest * smallest
        })
    }

    /// The factor of S − shift I, if that is positive definite.
    fn shifted(node: &Node, shift: f64) -> Option<Self> {
        let f = node.len();
        let mut rows = vec![0.0; f * f];
        for i in 0..f {
            let from = &node.gram[(f - 1 - i) * f..(f - i) * f];
            let (done, rest) = rows.split_at_mut(i * f);
            let row = &mut rest[..=i];
            for j in 0..i {
                let other = &done[j * f..=j * f + j];
                row[j] = (from[f - 1 - j] - dot(&row[..j], &other[..j])) / other[j];
            }
            let left = from[f - 1 - i] - shift - square(&row[..i]);
            if left.is_nan() || left <= 0.0 {
                return None;
            }
            row[i] = left.sqrt();
        }
        Some(Self { rows, f })
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.f..=i * self.f + i]
    }

    /// L⁻¹ b, for b in the node's order.
    fn forward(&self, b: &[f64]) -> Vec<f64> {
        let mut w = Vec::with_capacity(self.f);
        for i in 0..self.f {
            let row = self.row(i);
            w.push((b[self.f - 1 - i] - dot(&row[..i], &w)) / row[i]);
        }
        w
    }

    /// S⁻¹ b.
    pub(super) fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = self.forward(b);
        for i in (0..self.f).rev() {
            let row = self.row(i);
            x[i] /= row[i];
            let value = x[i];
            x[..i].iter_mut().zip(row).for_each(|(x, l)| *x -= value * l);
        }
        x.reverse();
        x
    }

    /// The diagonal of S⁻¹.
    pub(super) fn inverse_diagonal(&self) -> Vec<f64> {
        let f = self.f;
        // Row i of L⁻¹ is −1/L_ii Σ_j L_ij (row j of L⁻¹), and 1/L_ii on the diagonal.
        let mut inverse = vec![0.0; f * f];
        let mut diagonal = vec![0.0; f];
        for i in 0..f {
            let row = self.row(i);
            let (done, rest) = inverse.split_at_mut(i * f);
            let new = &mut rest[..=i];
            for (j, l) in row[..i].iter().enumerate() {
                let other = &done[j * f..=j * f + j];
                new.iter_mut().zip(other).for_each(|(n, o)| *n -= l * o);
            }
            new[..i].iter_mut().for_each(|n| *n /= row[i]);
            new[i] = 1.0 / row[i];
            diagonal.iter_mut().zip(new.iter()).for_each(|(d, n)| *d += n * n);
        }
        diagonal.reverse();
        diagonal
    }

    /// For each i the squared residual of the columns from i on.
    pub(super) fn remainders(&self, node: &Node) -> Vec<f64> {
        let mut left = node.rss;
        let mut remainders: Vec<f64> = self
            .forward(&node.overlap)
            .iter()
            .map(|w| {
                left -= w * w;
                left
            })
            .collect();
        remainders.reverse();
        remainders
    }

    /// A number that no eigenvalue of S is below, close to the smallest; `known` if nothing better is found.
    pub(super) fn least_eigenvalue(&self, node: &Node, known: f64) -> f64 {
        /// Steps of the inverse power iteration.
        const STEPS: usize = 6;
        let f = self.f;
        let mut x: Vec<f64> = (0..f).map(|i| 1.0 + 0.3 * ((i * 7 + 3) as f64).sin()).collect();
        let mut estimate = 0.0;
        for _ in 0..STEPS {
            let length = square(&x).sqrt();
            x.iter_mut().for_each(|v| *v /= length);
            let next = self.solve(&x);
            estimate = 1.0 / square(&next).sqrt();
            x = next;
        }
        let rounding = 2.0 * f as f64 * (node.error.gram + 1e-15);
        // That S − shift I has a factor is the proof; the estimate comes from above.
        [0.97, 0.85, 0.6]
            .iter()
            .map(|part| part * estimate)
            .find(|shift| Self::shifted(node, *shift).is_some())
            .map_or(known, |shift| known.max(shift - rounding))
    }
}
