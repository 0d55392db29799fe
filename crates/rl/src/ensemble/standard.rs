//! Columns shifted and scaled to mean 0 and standard deviation 1.

use ndarray::ArrayView2;

/// A column that varies less than this is shifted, and not scaled.
const LEAST_SPREAD: f64 = 1e-12;

/// (v - `center`) / `spread`, column by column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Standard {
    pub(super) center: Vec<f64>,
    pub(super) spread: Vec<f64>,
}

impl Standard {
    /// Leaves `n` columns as they are.
    pub(super) fn identity(n: usize) -> Self {
        Self { center: vec![0.0; n], spread: vec![1.0; n] }
    }

    /// The mean and the standard deviation of those rows of `table` that `rows` names, at least one.
    pub(super) fn of(table: ArrayView2<'_, f64>, rows: &[usize]) -> Self {
        let count = rows.len() as f64;
        let (mut center, mut spread) = (vec![0.0; table.ncols()], vec![0.0; table.ncols()]);
        for &row in rows {
            center.iter_mut().zip(table.row(row)).for_each(|(c, v)| *c += v / count);
        }
        for &row in rows {
            let columns = spread.iter_mut().zip(&center).zip(table.row(row));
            columns.for_each(|((s, c), v): ((&mut f64, &f64), &f64)| *s += (v - c).powi(2) / count);
        }
        spread.iter_mut().for_each(|s| *s = if s.sqrt() < LEAST_SPREAD { 1.0 } else { s.sqrt() });
        Self { center, spread }
    }

    /// One row as the networks see it.
    pub(super) fn apply<'a>(&'a self, row: impl IntoIterator<Item = &'a f64>) -> impl Iterator<Item = f32> {
        row.into_iter().zip(&self.center).zip(&self.spread).map(|((v, c), s)| ((v - c) / s) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn named_rows_alone_set_centre_and_spread_and_constants_are_not_blown_up() {
        let table = array![[1.0, 5.0], [1e9, -1e9], [3.0, 5.0]];
        let standard = Standard::of(table.view(), &[0, 2]);
        assert_eq!((standard.center.as_slice(), standard.spread.as_slice()), (&[2.0, 5.0][..], &[1.0, 1.0][..]));
        assert_eq!(standard.apply(table.row(2)).collect::<Vec<_>>(), [1.0, 0.0]);
    }
}
