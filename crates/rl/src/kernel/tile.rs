//! One tile of a product: the sums stay in registers from the first to the last.

use super::lanes::Lanes;

/// A left factor, by the strides of its rows and columns; one of the two is 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Left {
    pub(super) data: *const f32,
    pub(super) row_stride: usize,
    pub(super) column_stride: usize,
}

/// A right factor of rows `stride` apart, whose numbers lie side by side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Right {
    pub(super) data: *const f32,
    pub(super) stride: usize,
}

/// What sums start from.
#[derive(Debug, Clone, Copy)]
pub(super) enum Start {
    Zero,
    /// One number per column.
    Biases(*const f32),
    /// The sums of the inner indices before, in the result.
    Continue,
}

/// What becomes of the sums.
#[derive(Debug, Clone, Copy)]
pub(super) enum End {
    Keep,
    Relu,
    /// Sums stay where the number in the same place is positive, and are 0 elsewhere: for each row of the product one
    /// of `active`, that of the same number, or the one `index` names.
    Mask {
        active: *const f32,
        index: *const usize,
    },
    /// Sums are multiplied by the number in the same place.
    Scale {
        factors: *const f32,
    },
}

/// The result: rows `stride` apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Out {
    pub(super) data: *mut f32,
    pub(super) stride: usize,
    /// Null, or what the numbers of each column are added to, row after row.
    pub(super) column_sums: *mut f32,
}

/// ROWS rows of ACROSS vectors, of the last of which `last` numbers count if `PART`. TALL says that the left factor's
/// rows are side by side. `row` and `column` are those of the tile in the result; `left` begins at the tile's row and
/// `right` at its column.
///
/// # Safety
/// The instructions of S are there, and every pointer is good for the tile.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "inlined; the arguments are the loops' state")]
pub(super) unsafe fn tile<S: Lanes, const ROWS: usize, const ACROSS: usize, const PART: bool, const TALL: bool>(
    inner: usize,
    left: Left,
    right: Right,
    out: Out,
    (row, column): (usize, usize),
    last: usize,
    start: Start,
    end: End,
) {
    // SAFETY (whole body): offsets stay within the tile, for which the caller vouches.
    unsafe {
        let load = |p: *const f32, v: usize| {
            if PART && v + 1 == ACROSS { S::load_part(p.add(v * S::N), last) } else { S::load(p.add(v * S::N)) }
        };
        let place = |i: usize| out.data.add((row + i) * out.stride + column);

        let mut sums = [[S::splat(0.0); ACROSS]; ROWS];
        match start {
            Start::Zero => {}
            Start::Biases(biases) => {
                for v in 0..ACROSS {
                    let b = load(biases.add(column), v);
                    for row in &mut sums {
                        row[v] = b;
                    }
                }
            }
            Start::Continue => {
                for (i, row) in sums.iter_mut().enumerate() {
                    for (v, sum) in row.iter_mut().enumerate() {
                        *sum = load(place(i), v);
                    }
                }
            }
        }

        let mut rows = [left.data; ROWS];
        for (i, p) in rows.iter_mut().enumerate() {
            // Without an inner index, or in a tall tile, they are not read and may point anywhere.
            *p = left.data.wrapping_add(i * left.row_stride);
        }
        let mut b = right.data;
        let mut a = left.data;
        for k in 0..inner {
            let mut columns = [S::splat(0.0); ACROSS];
            for (v, c) in columns.iter_mut().enumerate() {
                *c = load(b, v);
            }
            for i in 0..ROWS {
                let x = S::splat(if TALL { *a.add(i) } else { *rows[i].add(k) });
                for v in 0..ACROSS {
                    sums[i][v] = S::fma(x, columns[v], sums[i][v]);
                }
            }
            // After the last index they may point anywhere, and are not read.
            b = b.wrapping_add(right.stride);
            if TALL {
                a = a.wrapping_add(left.column_stride);
            }
        }

        match end {
            End::Keep => {}
            End::Relu => {
                for sum in sums.as_flattened_mut() {
                    *sum = S::relu(*sum);
                }
            }
            End::Scale { factors } => {
                for (i, row_sums) in sums.iter_mut().enumerate() {
                    for (v, sum) in row_sums.iter_mut().enumerate() {
                        *sum = S::mul(*sum, load(factors.add((row + i) * out.stride + column), v));
                    }
                }
            }
            End::Mask { active, index } => {
                for (i, row_sums) in sums.iter_mut().enumerate() {
                    let of = if index.is_null() { row + i } else { *index.add(row + i) };
                    for (v, sum) in row_sums.iter_mut().enumerate() {
                        *sum = S::where_positive(*sum, load(active.add(of * out.stride + column), v));
                    }
                }
            }
        }
        let store = |p: *mut f32, v: usize, x: S::V| {
            let p = p.add(v * S::N);
            if PART && v + 1 == ACROSS { S::store_part(p, last, x) } else { S::store(p, x) }
        };
        for (i, row) in sums.iter().enumerate() {
            for (v, sum) in row.iter().enumerate() {
                store(place(i), v, *sum);
            }
        }
        if !out.column_sums.is_null() {
            let totals = out.column_sums.add(column);
            for v in 0..ACROSS {
                let total = sums.iter().fold(load(totals, v), |total, row| S::add(total, row[v]));
                store(totals, v, total);
            }
        }
    }
}
