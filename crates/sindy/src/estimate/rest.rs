//! What columns of a triangle leave of others.

use crate::Triangle;

/// Part of a column's length that others must leave of it, lest it be taken for a sum of these.
const LEFT: f64 = 1e-9;

/// Columns of a triangle, without what others explain of them.
#[derive(Clone)]
pub(super) struct Rest<'a> {
    triangle: &'a Triangle,
    /// Orthonormal columns that span these others.
    basis: Vec<Vec<f64>>,
}

impl<'a> Rest<'a> {
    /// What `columns` leave of others.
    pub(super) fn without(triangle: &'a Triangle, columns: impl Iterator<Item = usize>) -> Self {
        let mut rest = Self { triangle, basis: Vec::new() };
        for c in columns {
            let left = rest.of(c);
            rest.basis.extend(left.map(unit));
        }
        rest
    }

    /// What is left of column `c`; `None` if that is nothing.
    pub(super) fn of(&self, c: usize) -> Option<Vec<f64>> {
        let column = self.triangle.column(c);
        let mut rest = vec![0.0; self.triangle.n_columns()];
        rest[..column.len()].copy_from_slice(column);
        // Twice is enough (Kahan).
        for q in self.basis.iter().chain(&self.basis) {
            take(&mut rest, q);
        }
        (length(&rest) > LEFT * self.triangle.norm(c)).then_some(rest)
    }

    /// Each one of `columns`, or each two of them if `count` is two, of which `may` holds, with the sum of squares that is left of the last column then;
    /// also the operations that this took.
    pub(super) fn with(
        &self,
        columns: impl Iterator<Item = usize>,
        count: usize,
        may: impl Fn(&[usize]) -> bool,
    ) -> (Vec<(Vec<usize>, f64)>, u64) {
        let Some(y) = self.of(self.triangle.n_columns() - 1) else { return (Vec::new(), 0) };
        let columns: Vec<(usize, Vec<f64>)> = columns.filter_map(|c| Some((c, unit(self.of(c)?)))).collect();
        let mut work = (2 * self.basis.len() + 1) * columns.len() * y.len();
        let mut found = Vec::new();
        for (at, (c, u)) in columns.iter().enumerate() {
            let left = dot(&y, &y) - dot(u, &y).powi(2);
            if count == 1 {
                found.extend(may(&[*c]).then(|| (vec![*c], left.max(0.0))));
                continue;
            }
            for (d, v) in columns[at + 1..].iter().filter(|(d, _)| may(&[*c, *d])) {
                let mut v = v.clone();
                take(&mut v, u);
                let square = dot(&v, &v);
                if square > LEFT * LEFT {
                    found.push((vec![*c, *d], (left - dot(&v, &y).powi(2) / square).max(0.0)));
                }
                work += 4 * y.len();
            }
        }
        (found, work as u64)
    }

    /// The same of column `c` besides; `None` if these explain it.
    pub(super) fn and(&self, c: usize) -> Option<Self> {
        let own = unit(self.of(c)?);
        Some(Self { triangle: self.triangle, basis: self.basis.iter().cloned().chain([own]).collect() })
    }

    /// What is left of the last column without more, and with one of the columns `from` after the other, at most `most`, that which leaves least: the columns and the sum of
    /// squares. Also the operations that this took.
    ///
    /// # References
    /// Chen, Billings, Luo (1989), Int. J. Control 50(5): orthogonal forward regression.
    pub(super) fn forward(&self, from: &[usize], most: usize) -> (Vec<(Vec<usize>, f64)>, u64) {
        let Some(mut y) = self.of(self.triangle.n_columns() - 1) else { return (Vec::new(), 0) };
        let mut left: Vec<(usize, Vec<f64>)> = from.iter().filter_map(|&c| Some((c, unit(self.of(c)?)))).collect();
        let mut work = (2 * self.basis.len() + 1) * from.len() * y.len();
        let mut ways = vec![(Vec::new(), dot(&y, &y))];
        for _ in 0..most {
            left.retain(|(_, v)| length(v) > LEFT);
            let gain = |v: &[f64]| dot(v, &y).powi(2) / dot(v, v);
            let gains: Vec<f64> = left.iter().map(|(_, v)| gain(v)).collect();
            let Some(best) = (0..left.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b])) else { break };
            work += 4 * left.len() * y.len();
            let (c, v) = left.swap_remove(best);
            let q = unit(v);
            take(&mut y, &q);
            left.iter_mut().for_each(|(_, v)| take(v, &q));
            let chosen = ways.last().map_or_else(Vec::new, |(chosen, _)| [&chosen[..], &[c]].concat());
            ways.push((chosen, dot(&y, &y)));
        }
        (ways, work as u64)
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Takes from `a` its part along the unit vector `q`.
fn take(a: &mut [f64], q: &[f64]) {
    let along = dot(a, q);
    a.iter_mut().zip(q).for_each(|(a, q)| *a -= along * q);
}

fn unit(mut a: Vec<f64>) -> Vec<f64> {
    let length = length(&a);
    a.iter_mut().for_each(|a| *a /= length);
    a
}
