//! The one matrix product, and the only unsafe call of the crate.

/// A borrowed matrix of single precision numbers, row-major or the transpose of one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Matrix<'a> {
    data: &'a [f32],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a> Matrix<'a> {
    /// `data` as `rows` rows of `columns` numbers.
    pub(crate) fn new(data: &'a [f32], rows: usize, columns: usize) -> Self {
        assert_eq!(data.len(), rows * columns, "a {rows} × {columns} matrix");
        Self { data, rows, columns, row_stride: columns, column_stride: 1 }
    }

    /// The transpose; nothing is copied.
    pub(crate) fn t(self) -> Self {
        Self {
            data: self.data,
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
        }
    }
}

/// C = A B, single threaded. `c` is row-major, (rows of A, columns of B); what it held is overwritten.
///
/// The order of summation depends on the shapes and on the instruction set, not on anything else.
#[expect(unsafe_code, reason = "gemm takes raw pointers; both the bounds and the absence of aliasing are checked here")]
pub(crate) fn matmul(c: &mut [f32], a: Matrix<'_>, b: Matrix<'_>) {
    assert_eq!(a.columns, b.rows, "inner dimensions");
    assert_eq!(c.len(), a.rows * b.columns, "size of the product");
    // SAFETY: `Matrix::new` and `t` keep (rows - 1)·row_stride + (columns - 1)·column_stride < data.len(), so every
    // element gemm reads lies inside its slice; `c` was just checked to hold rows × columns row-major elements, and
    // as an exclusive borrow overlaps neither operand. Lengths of slices fit isize.
    unsafe {
        gemm::gemm(
            a.rows,
            b.columns,
            a.columns,
            c.as_mut_ptr(),
            1,
            b.columns as isize,
            false,
            a.data.as_ptr(),
            a.column_stride as isize,
            a.row_stride as isize,
            b.data.as_ptr(),
            b.column_stride as isize,
            b.row_stride as isize,
            0.0,
            1.0,
            false,
            false,
            false,
            gemm::Parallelism::None,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_transposes_are_those_of_the_definition() {
        for (m, k, n) in [(1, 1, 1), (5, 3, 7), (64, 4, 1), (1, 64, 64), (33, 17, 2)] {
            let value = |i: usize| ((i * 37 + 11) % 23) as f32 - 11.0;
            let a: Vec<f32> = (0..m * k).map(value).collect();
            let b: Vec<f32> = (0..k * n).map(|i| value(i + 5)).collect();
            let (mut at, mut bt) = (vec![0.0; m * k], vec![0.0; k * n]);
            (0..m * k).for_each(|i| at[i % k * m + i / k] = a[i]);
            (0..k * n).for_each(|i| bt[i % n * k + i / n] = b[i]);
            // Whole numbers below 2²⁴ add exactly, in any order.
            let exact: Vec<f32> =
                (0..m * n).map(|i| (0..k).map(|j| a[i / n * k + j] * b[j * n + i % n]).sum()).collect();
            let mut c = vec![f32::NAN; m * n];
            for left in [Matrix::new(&a, m, k), Matrix::new(&at, k, m).t()] {
                for right in [Matrix::new(&b, k, n), Matrix::new(&bt, n, k).t()] {
                    c.fill(f32::NAN);
                    matmul(&mut c, left, right);
                    assert_eq!(c, exact, "({m}, {k}) × ({k}, {n})");
                }
            }
        }
    }
}
