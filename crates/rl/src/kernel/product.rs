//! A whole product: which tiles, in which order, and what is copied first.

use std::mem::MaybeUninit;

use super::{
    lanes::Lanes,
    tile::{End, Left, Out, Right, Start, tile},
};

/// Inner indices between two visits of a tile: that many rows of a panel stay in the nearest cache.
const INNER: usize = 128;

/// Numbers in a row of the widest panel.
const WIDEST: usize = 64;

/// Below so many rows a panel of the right factor is used too seldom to be worth a copy.
const FEW_ROWS: usize = 12;

/// C = A B and what comes before and after. `right` is B where `right_stride` is between its rows, and Bᵀ where
/// `transposed`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Job {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) inner: usize,
    pub(super) left: Left,
    pub(super) right: Right,
    pub(super) transposed: bool,
    pub(super) out: *mut f32,
    /// Null, or to what the columns of C are summed up.
    pub(super) column_sums: *mut f32,
    pub(super) start: Start,
    pub(super) end: End,
}

/// Memory for a part of the right factor, on the boundary of a cache line.
#[repr(align(64))]
struct Panel([MaybeUninit<f32>; INNER * WIDEST]);

/// # Safety
/// The instructions of S are there, and all pointers of `job` are good for its sizes.
#[inline(always)]
pub(super) unsafe fn product<S: Lanes>(job: &Job) {
    let mut panel = Panel([MaybeUninit::uninit(); INNER * WIDEST]);
    let width = S::N * S::ACROSS;
    let mut from = 0;
    // An inner dimension of 0 still starts and ends.
    while from < job.inner || from == 0 {
        let inner = INNER.min(job.inner - from);
        let start = if from == 0 { job.start } else { Start::Continue };
        let (end, column_sums) = match from + inner == job.inner {
            true => (job.end, job.column_sums),
            false => (End::Keep, std::ptr::null_mut()),
        };
        let out = Out { data: job.out, stride: job.columns, column_sums };
        let mut column = 0;
        while column < job.columns {
            let left_over = job.columns - column;
            // As few tiles as there can be, and as even: a narrow one keeps the adders waiting for their own sums.
            let vectors = left_over.div_ceil(S::N);
            let across = vectors.div_ceil(vectors.div_ceil(S::ACROSS));
            let taken = left_over.min(across * S::N);
            // SAFETY: the part lies within B, and the panel holds INNER rows of at most WIDEST numbers.
            let right = unsafe {
                if job.transposed {
                    turn::<S>(job, from, inner, column, taken, &mut panel, across * S::N)
                } else if job.rows > FEW_ROWS && job.right.stride > width && inner > 8 {
                    copy::<S>(job, from, inner, column, taken, &mut panel, across * S::N)
                } else {
                    // Without inner indices nothing of it is read.
                    let first = from * job.right.stride + column;
                    Right { data: job.right.data.wrapping_add(first), stride: job.right.stride }
                }
            };
            let part = Part { job, from, inner, right, out, column, taken, start, end };
            // SAFETY: `part` lies within the job.
            unsafe {
                if job.left.column_stride == 1 {
                    part.run::<S, false>(across);
                } else {
                    part.run::<S, true>(across);
                }
            }
            column += taken;
        }
        from += inner.max(1);
    }
}

/// All rows of some columns, over some of the inner indices.
struct Part<'a> {
    job: &'a Job,
    from: usize,
    inner: usize,
    right: Right,
    out: Out,
    column: usize,
    taken: usize,
    start: Start,
    end: End,
}

impl Part<'_> {
    #[inline(always)]
    unsafe fn run<S: Lanes, const TALL: bool>(&self, across: usize) {
        let part = self.taken < across * S::N;
        // SAFETY: the caller's promise; no tile is wider than ACROSS, at most 4.
        unsafe {
            // A constant alone in its condition: what cannot be is then not even compiled.
            if S::WIDE {
                match (across, part) {
                    (4, true) => return self.rows::<S, 4, true, TALL>(),
                    (4, false) => return self.rows::<S, 4, false, TALL>(),
                    (3, true) => return self.rows::<S, 3, true, TALL>(),
                    (3, false) => return self.rows::<S, 3, false, TALL>(),
                    _ => {}
                }
            }
            match (across, part) {
                (2, true) => self.rows::<S, 2, true, TALL>(),
                (2, false) => self.rows::<S, 2, false, TALL>(),
                (_, true) => self.rows::<S, 1, true, TALL>(),
                (_, false) => self.rows::<S, 1, false, TALL>(),
            }
        }
    }

    #[inline(always)]
    unsafe fn rows<S: Lanes, const ACROSS: usize, const PART: bool, const TALL: bool>(&self) {
        let mut row = 0;
        // SAFETY: tiles end where the rows do.
        unsafe {
            // Enough sums to keep both adders busy, and no more code than that takes.
            while ACROSS < 4 && row + 6 <= self.job.rows {
                self.one::<S, 6, ACROSS, PART, TALL>(row);
                row += 6;
            }
            while S::WIDE && row + 4 <= self.job.rows {
                self.one::<S, 4, ACROSS, PART, TALL>(row);
                row += 4;
            }
            while row + 2 <= self.job.rows {
                self.one::<S, 2, ACROSS, PART, TALL>(row);
                row += 2;
            }
            if row < self.job.rows {
                self.one::<S, 1, ACROSS, PART, TALL>(row);
            }
        }
    }

    #[inline(always)]
    unsafe fn one<S: Lanes, const ROWS: usize, const ACROSS: usize, const PART: bool, const TALL: bool>(
        &self,
        row: usize,
    ) {
        let left = self.job.left;
        // SAFETY: the tile lies within the job.
        unsafe {
            let at = left.data.wrapping_add(row * left.row_stride + self.from * left.column_stride);
            tile::<S, ROWS, ACROSS, PART, TALL>(
                self.inner,
                Left { data: at, ..left },
                self.right,
                self.out,
                (row, self.column),
                self.taken - (ACROSS - 1) * S::N,
                self.start,
                self.end,
            );
        }
    }
}

/// Copies `inner` rows of `taken` columns of B side by side.
#[inline(always)]
unsafe fn copy<S: Lanes>(
    job: &Job,
    from: usize,
    inner: usize,
    column: usize,
    taken: usize,
    panel: &mut Panel,
    stride: usize,
) -> Right {
    let to = panel.0.as_mut_ptr().cast::<f32>();
    // SAFETY: the caller's promise.
    unsafe {
        for k in 0..inner {
            let row = job.right.data.add((from + k) * job.right.stride + column);
            let to = to.add(k * stride);
            let mut j = 0;
            while j + S::N <= taken {
                S::store(to.add(j), S::load(row.add(j)));
                j += S::N;
            }
            if j < taken {
                S::store_part(to.add(j), taken - j, S::load_part(row.add(j), taken - j));
            }
        }
    }
    Right { data: to, stride }
}

/// Like [`copy`], where Bᵀ is given.
#[inline(always)]
unsafe fn turn<S: Lanes>(
    job: &Job,
    from: usize,
    inner: usize,
    column: usize,
    taken: usize,
    panel: &mut Panel,
    stride: usize,
) -> Right {
    let to = panel.0.as_mut_ptr().cast::<f32>();
    let whole = (inner / 8 * 8, taken / 8 * 8);
    // SAFETY: the caller's promise; blocks of 8 by 8 end within `whole`.
    unsafe {
        let source = job.right.data.add(column * job.right.stride + from);
        for j in (0..whole.1).step_by(8) {
            for k in (0..whole.0).step_by(8) {
                S::turn8(source.add(j * job.right.stride + k), job.right.stride, to.add(k * stride + j), stride);
            }
        }
        for j in 0..taken {
            for k in if j < whole.1 { whole.0 } else { 0 }..inner {
                *to.add(k * stride + j) = *source.add(j * job.right.stride + k);
            }
        }
    }
    Right { data: to, stride }
}
