//! Matrix products with what comes before and after them, for the shapes of small networks.
//!
//! All `unsafe` code of the crate is here: vectors of the machine ([`lanes`]), one tile of a product ([`tile`]), the
//! walk over the tiles ([`product`]), and products of rows ([`dot`]). What this module lets out is safe: sizes are
//! checked, and no instruction runs that the machine lacks.
#![expect(unsafe_code, reason = "a measured kernel: vector instructions chosen at run time; see docs/notes")]

mod dot;
mod lanes;
#[cfg(target_arch = "aarch64")]
mod lanes_neon;
#[cfg(target_arch = "x86_64")]
mod lanes_x86;
mod product;
#[cfg(test)]
mod tests;
mod tile;

use lanes::Plain;
#[cfg(target_arch = "aarch64")]
use lanes_neon::Neon;
#[cfg(target_arch = "x86_64")]
use lanes_x86::{Avx2, Avx512};
use product::{Job, product};
use tile::{End, Left, Right, Start};

use crate::Isa;

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

/// What is done to a product on its way to memory.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Finish<'a> {
    /// Nothing.
    Plain,
    /// Sums start at the column's bias.
    Biases(&'a [f32]),
    /// The same, and ReLU follows.
    BiasesRelu(&'a [f32]),
    /// Back through a ReLU: 0 where it gave `outputs` that are not positive. Row i belongs to row i of `outputs`, or to
    /// row `rows[i]`.
    ThroughRelu {
        /// Rows as wide as the product.
        outputs: &'a [f32],
        /// Which of them.
        rows: Option<&'a [usize]>,
    },
    /// Back through another function: times its slope there.
    ThroughSlopes(&'a [f32]),
}

/// C = A B, finished. `c` is row-major, (rows of A, columns of B); what it held is overwritten.
///
/// Every number is one chain of fused products, from its bias (or 0) on and over the inner index in order, so it depends
/// neither on the shapes nor on the width of the vectors.
pub(crate) fn matmul(isa: Isa, c: &mut [f32], a: Matrix<'_>, b: Matrix<'_>, finish: Finish<'_>) {
    matmul_and_sums(isa, c, a, b, finish, None);
}

/// [`matmul`], and `sums`, one per column of C, is overwritten with the sums over its rows, added up from the first to the
/// last.
pub(crate) fn matmul_and_sums(
    isa: Isa,
    c: &mut [f32],
    a: Matrix<'_>,
    b: Matrix<'_>,
    finish: Finish<'_>,
    mut sums: Option<&mut [f32]>,
) {
    assert_eq!(a.columns, b.rows, "inner dimensions");
    assert_eq!(c.len(), a.rows * b.columns, "size of the product");
    if let Some(sums) = &mut sums {
        assert_eq!(sums.len(), b.columns, "a sum per column");
        sums.fill(0.0);
    }
    let (start, end) = match finish {
        Finish::Plain => (Start::Zero, End::Keep),
        Finish::Biases(biases) | Finish::BiasesRelu(biases) => {
            assert_eq!(biases.len(), b.columns, "a bias per column");
            let end = if matches!(finish, Finish::Biases(_)) { End::Keep } else { End::Relu };
            (Start::Biases(biases.as_ptr()), end)
        }
        Finish::ThroughRelu { outputs, rows } => {
            let last = rows.map_or(a.rows.checked_sub(1), |rows| {
                assert_eq!(rows.len(), a.rows, "a row of outputs per row");
                rows.iter().copied().max()
            });
            assert!(last.is_none_or(|last| (last + 1) * b.columns <= outputs.len()), "outputs for every row");
            let index = rows.map_or(std::ptr::null(), <[usize]>::as_ptr);
            (Start::Zero, End::Mask { active: outputs.as_ptr(), index })
        }
        Finish::ThroughSlopes(slopes) => {
            assert_eq!(slopes.len(), c.len(), "a slope per number");
            (Start::Zero, End::Scale { factors: slopes.as_ptr() })
        }
    };
    let transposed = b.column_stride != 1;
    let job = Job {
        rows: a.rows,
        columns: b.columns,
        inner: a.columns,
        left: Left { data: a.data.as_ptr(), row_stride: a.row_stride, column_stride: a.column_stride },
        right: Right { data: b.data.as_ptr(), stride: if transposed { b.column_stride } else { b.row_stride } },
        transposed,
        out: c.as_mut_ptr(),
        column_sums: sums.map_or(std::ptr::null_mut(), <[f32]>::as_mut_ptr),
        start,
        end,
    };
    // SAFETY: `Matrix::new` and `t` keep every element within its slice, with one of the strides 1; sizes of C, biases,
    // outputs, slopes and sums were just checked, and C and the sums, exclusive borrows, overlap nothing. `present` finds the
    // instructions.
    unsafe {
        match isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 if isa.present() => product_avx512(&job),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 if isa.present() => product_avx2(&job),
            #[cfg(target_arch = "aarch64")]
            Isa::Neon if isa.present() => product_neon(&job),
            _ => product::<Plain>(&job),
        }
    }
}

/// ys (rows, outputs) = xs (rows, inner) · vectors (outputs, inner), each row with each vector, from the biases on.
///
/// Sums run over sixteen lanes, which are then added in pairs: also that order is the same for every width of vectors.
pub(crate) fn dots(isa: Isa, ys: &mut [f32], xs: &[f32], vectors: &[f32], inner: usize, biases: Option<&[f32]>) {
    let outputs = vectors.len() / inner;
    let rows = xs.len() / inner;
    assert_eq!((outputs * inner, rows * inner), (vectors.len(), xs.len()), "rows of equal length");
    assert_eq!(ys.len(), rows * outputs, "size of the product");
    assert!(biases.is_none_or(|b| b.len() == outputs), "a bias per output");
    let job = dot::Job { ys, xs, vectors, inner, biases };
    // SAFETY: `present` finds the instructions.
    unsafe {
        match isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 if isa.present() => dots_avx512(job),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 if isa.present() => dots_avx2(job),
            #[cfg(target_arch = "aarch64")]
            Isa::Neon if isa.present() => dots_neon(job),
            _ => dot::dots::<Plain>(job),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
unsafe fn product_avx512(job: &Job) {
    // SAFETY: the caller's promise, and the instructions are those of this function.
    unsafe { product::<Avx512>(job) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn product_avx2(job: &Job) {
    // SAFETY: the caller's promise, and the instructions are those of this function.
    unsafe { product::<Avx2>(job) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
unsafe fn dots_avx512(job: dot::Job<'_>) {
    // SAFETY: the caller's promise, and the instructions are those of this function.
    unsafe { dot::dots::<Avx512>(job) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn dots_avx2(job: dot::Job<'_>) {
    // SAFETY: the caller's promise, and the instructions are those of this function.
    unsafe { dot::dots::<Avx2>(job) }
}

#[cfg(target_arch = "aarch64")]
#[target_feature(enable = "neon")]
unsafe fn product_neon(job: &Job) {
    // SAFETY: the caller's promise, and the instructions are those of this function.
    unsafe { product::<Neon>(job) }
}

#[cfg(target_arch = "aarch64")]
#[target_feature(enable = "neon")]
unsafe fn dots_neon(job: dot::Job<'_>) {
    // SAFETY: the caller's promise, and the instructions are those of this function.
    unsafe { dot::dots::<Neon>(job) }
}
