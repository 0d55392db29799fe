//! Vectors of f32: what the kernels need of an instruction set, and nothing else.

/// A vector of N numbers. The kernels are written once over this trait and compiled once per instruction set.
///
/// # Safety
/// Every function needs the instructions of its implementor, so all of them may only be called where those were
/// detected; pointers must be good for as many numbers as are read or written there.
pub(super) unsafe trait Lanes: Copy {
    /// The vector itself.
    type V: Copy;
    /// Numbers in a vector.
    const N: usize;
    /// Vectors side by side in one tile of a product: as many as leave registers for the rows.
    const ACROSS: usize;
    /// Whether that is more than two.
    const WIDE: bool = Self::ACROSS > 2;

    unsafe fn splat(x: f32) -> Self::V;
    unsafe fn load(p: *const f32) -> Self::V;
    unsafe fn store(p: *mut f32, v: Self::V);
    /// The first `n` < N numbers; the others are 0 and their memory is not touched.
    unsafe fn load_part(p: *const f32, n: usize) -> Self::V;
    unsafe fn store_part(p: *mut f32, n: usize, v: Self::V);
    unsafe fn add(a: Self::V, b: Self::V) -> Self::V;
    unsafe fn mul(a: Self::V, b: Self::V) -> Self::V;
    /// a b + c, rounded once where the hardware can.
    unsafe fn fma(a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// max(v, 0); a number that is none stays none.
    unsafe fn relu(v: Self::V) -> Self::V;
    /// v where `y` > 0, else 0.
    unsafe fn where_positive(v: Self::V, y: Self::V) -> Self::V;
    /// The sum of sixteen lanes spread over 16/N vectors: lane i and lane i + 8 first, then 4, 2, 1 apart.
    unsafe fn sum_of_lanes(sums: [Self::V; 4]) -> f32;
    /// [`Self::sum_of_lanes`] of every vector, where one alone has sixteen lanes.
    #[inline(always)]
    unsafe fn sums_of_lanes(sums: [Self::V; 16]) -> [f32; 16] {
        // SAFETY: the caller's promise.
        sums.map(|sum| unsafe { Self::sum_of_lanes([sum; 4]) })
    }

    /// Writes the transpose of 8 by 8 numbers, rows `stride` apart, with rows `to_stride` apart.
    #[inline(always)]
    unsafe fn turn8(from: *const f32, stride: usize, to: *mut f32, to_stride: usize) {
        for i in 0..8 {
            for j in 0..8 {
                // SAFETY: the caller's promise.
                unsafe { *to.add(j * to_stride + i) = *from.add(i * stride + j) };
            }
        }
    }
}

/// Four numbers, in whatever way the compiler has for them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plain;

// SAFETY: needs no instruction that is not always there.
unsafe impl Lanes for Plain {
    type V = [f32; 4];
    const N: usize = 4;
    const ACROSS: usize = 2;

    #[inline(always)]
    unsafe fn splat(x: f32) -> [f32; 4] {
        [x; 4]
    }
    #[inline(always)]
    unsafe fn load(p: *const f32) -> [f32; 4] {
        // SAFETY: the caller's promise; arrays of f32 are read unaligned.
        unsafe { p.cast::<[f32; 4]>().read_unaligned() }
    }
    #[inline(always)]
    unsafe fn store(p: *mut f32, v: [f32; 4]) {
        // SAFETY: the caller's promise.
        unsafe { p.cast::<[f32; 4]>().write_unaligned(v) }
    }
    #[inline(always)]
    unsafe fn load_part(p: *const f32, n: usize) -> [f32; 4] {
        // SAFETY: only the first n numbers are read.
        std::array::from_fn(|i| if i < n { unsafe { *p.add(i) } } else { 0.0 })
    }
    #[inline(always)]
    unsafe fn store_part(p: *mut f32, n: usize, v: [f32; 4]) {
        for (i, x) in v.into_iter().enumerate().take(n) {
            // SAFETY: only the first n numbers are written.
            unsafe { *p.add(i) = x };
        }
    }
    #[inline(always)]
    unsafe fn add(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    unsafe fn mul(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    unsafe fn fma(a: [f32; 4], b: [f32; 4], c: [f32; 4]) -> [f32; 4] {
        // Never fused: the same bits on every machine, whatever it is compiled for.
        std::array::from_fn(|i| a[i] * b[i] + c[i])
    }
    #[inline(always)]
    unsafe fn relu(v: [f32; 4]) -> [f32; 4] {
        v.map(crate::affine::relu)
    }
    #[inline(always)]
    unsafe fn where_positive(v: [f32; 4], y: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|i| if y[i] > 0.0 { v[i] } else { 0.0 })
    }
    #[inline(always)]
    unsafe fn sum_of_lanes([a, b, c, d]: [[f32; 4]; 4]) -> f32 {
        let four: [f32; 4] = std::array::from_fn(|i| (a[i] + c[i]) + (b[i] + d[i]));
        (four[0] + four[2]) + (four[1] + four[3])
    }
}
