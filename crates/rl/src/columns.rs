//! Tables a few numbers wide, handled a column at a time: their rows are too short to be worth a loop each.

use ndarray::ArrayView2;

use sindyna_core::vectorized;

/// Rows whose numbers of one column are a vector.
const ABREAST: usize = 8;

/// The columns of a row-major table `width` wide.
pub(crate) struct Columns<'a> {
    pub(crate) table: &'a mut [f32],
    pub(crate) width: usize,
}

impl Columns<'_> {
    /// Writes `change`(j, v) for every number v in column j of `from`, rounded, from column `first` on.
    pub(crate) fn map(&mut self, first: usize, from: ArrayView2<'_, f64>, change: impl Fn(usize, f64) -> f64) {
        let from_width = from.ncols();
        let from = from.as_standard_layout();
        let from = from.as_slice().expect("row-major");
        vectorized(
            #[inline(always)]
            || {
                for j in 0..from_width {
                    let mut rows = from.chunks_exact(ABREAST * from_width);
                    let mut to = self.table.chunks_exact_mut(ABREAST * self.width);
                    for (rows, to) in rows.by_ref().zip(to.by_ref()) {
                        let values: [f64; ABREAST] = std::array::from_fn(|row| rows[row * from_width + j]);
                        let values = values.map(|v| change(j, v));
                        for (to, v) in to.chunks_exact_mut(self.width).zip(values) {
                            to[first + j] = v as f32;
                        }
                    }
                    let last = rows.remainder().chunks_exact(from_width);
                    for (to, row) in to.into_remainder().chunks_exact_mut(self.width).zip(last) {
                        to[first + j] = change(j, row[j]) as f32;
                    }
                }
            },
        );
    }

    /// Copies the table `from`, `from_width` wide, to the columns from `first` on.
    pub(crate) fn copy(&mut self, first: usize, from: &[f32], from_width: usize) {
        for j in 0..from_width {
            for (to, row) in self.table.chunks_exact_mut(self.width).zip(from.chunks_exact(from_width)) {
                to[first + j] = row[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn numbers_land_in_their_row_and_column_however_the_table_lies() {
        for rows in [0, 1, 7, 8, 19] {
            let from = Array2::from_shape_fn((2, rows), |(j, row)| (10 * row + j) as f64);
            let mut table = vec![-1.0; rows * 4];
            Columns { table: &mut table, width: 4 }.map(1, from.t(), |j, v| v + 100.0 * j as f64);
            let first: Vec<f32> = (0..rows).map(|row| row as f32).collect();
            Columns { table: &mut table, width: 4 }.copy(0, &first, 1);
            let expected = |row: usize| [row as f32, 10.0 * row as f32, (10 * row + 101) as f32, -1.0];
            assert_eq!(table, (0..rows).flat_map(expected).collect::<Vec<f32>>());
        }
    }
}
