//! Vectors of AVX2 and AVX-512.

use std::arch::x86_64::*;

use super::lanes::Lanes;

/// AVX2 with fused multiply-add.
#[derive(Debug, Clone, Copy)]
pub(super) struct Avx2;

/// AVX-512.
#[derive(Debug, Clone, Copy)]
pub(super) struct Avx512;

/// The lanes below `n` are all ones.
#[inline(always)]
unsafe fn first_lanes(n: usize) -> __m256i {
    // SAFETY: the caller has AVX2.
    unsafe { _mm256_cmpgt_epi32(_mm256_set1_epi32(n as i32), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)) }
}

/// Lane i and lane i + 4 first, then 2 and 1 apart.
#[inline(always)]
unsafe fn sum_of_eight(v: __m256) -> f32 {
    // SAFETY: the caller has AVX2.
    unsafe {
        let four = _mm_add_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps::<1>(v));
        let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
        _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)))
    }
}

/// The transpose of 8 by 8 numbers, in registers.
#[inline(always)]
unsafe fn turn8(from: *const f32, stride: usize, to: *mut f32, to_stride: usize) {
    // SAFETY: the caller has AVX2 and vouches for the memory.
    unsafe {
        let r: [__m256; 8] = std::array::from_fn(|i| _mm256_loadu_ps(from.add(i * stride)));
        // Pairs of rows, then fours, then the halves of the registers.
        let low = |i: usize| _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
        let high = |i: usize| _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
        let (l0, l1, l2, l3) = (low(0), low(1), low(2), low(3));
        let (h0, h1, h2, h3) = (high(0), high(1), high(2), high(3));
        let fours = [
            (_mm256_shuffle_ps::<0x44>(l0, l1), _mm256_shuffle_ps::<0x44>(l2, l3)),
            (_mm256_shuffle_ps::<0xee>(l0, l1), _mm256_shuffle_ps::<0xee>(l2, l3)),
            (_mm256_shuffle_ps::<0x44>(h0, h1), _mm256_shuffle_ps::<0x44>(h2, h3)),
            (_mm256_shuffle_ps::<0xee>(h0, h1), _mm256_shuffle_ps::<0xee>(h2, h3)),
        ];
        for (j, (a, b)) in fours.into_iter().enumerate() {
            _mm256_storeu_ps(to.add(j * to_stride), _mm256_permute2f128_ps::<0x20>(a, b));
            _mm256_storeu_ps(to.add((j + 4) * to_stride), _mm256_permute2f128_ps::<0x31>(a, b));
        }
    }
}

// SAFETY: all functions use AVX2 and FMA only, which is what callers must have detected; part loads and stores are
// masked, so memory outside is not touched.
unsafe impl Lanes for Avx2 {
    type V = __m256;
    const N: usize = 8;
    const ACROSS: usize = 2;

    #[inline(always)]
    unsafe fn splat(x: f32) -> __m256 {
        unsafe { _mm256_set1_ps(x) }
    }
    #[inline(always)]
    unsafe fn load(p: *const f32) -> __m256 {
        unsafe { _mm256_loadu_ps(p) }
    }
    #[inline(always)]
    unsafe fn store(p: *mut f32, v: __m256) {
        unsafe { _mm256_storeu_ps(p, v) }
    }
    #[inline(always)]
    unsafe fn load_part(p: *const f32, n: usize) -> __m256 {
        unsafe { _mm256_maskload_ps(p, first_lanes(n)) }
    }
    #[inline(always)]
    unsafe fn store_part(p: *mut f32, n: usize, v: __m256) {
        unsafe { _mm256_maskstore_ps(p, first_lanes(n), v) }
    }
    #[inline(always)]
    unsafe fn add(a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_add_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn mul(a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_mul_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn fma(a: __m256, b: __m256, c: __m256) -> __m256 {
        unsafe { _mm256_fmadd_ps(a, b, c) }
    }
    #[inline(always)]
    unsafe fn relu(v: __m256) -> __m256 {
        // Of two numbers, one of them none, `max` gives the second.
        unsafe { _mm256_max_ps(_mm256_setzero_ps(), v) }
    }
    #[inline(always)]
    unsafe fn where_positive(v: __m256, y: __m256) -> __m256 {
        unsafe { _mm256_and_ps(v, _mm256_cmp_ps::<_CMP_GT_OQ>(y, _mm256_setzero_ps())) }
    }
    #[inline(always)]
    unsafe fn sum_of_lanes([low, high, ..]: [__m256; 4]) -> f32 {
        unsafe { sum_of_eight(_mm256_add_ps(low, high)) }
    }
    #[inline(always)]
    unsafe fn turn8(from: *const f32, stride: usize, to: *mut f32, to_stride: usize) {
        unsafe { turn8(from, stride, to, to_stride) }
    }
}

// SAFETY: all functions use AVX-512F only, which is what callers must have detected; part loads and stores are
// masked, so memory outside is not touched.
unsafe impl Lanes for Avx512 {
    type V = __m512;
    const N: usize = 16;
    const ACROSS: usize = 4;

    #[inline(always)]
    unsafe fn splat(x: f32) -> __m512 {
        unsafe { _mm512_set1_ps(x) }
    }
    #[inline(always)]
    unsafe fn load(p: *const f32) -> __m512 {
        unsafe { _mm512_loadu_ps(p) }
    }
    #[inline(always)]
    unsafe fn store(p: *mut f32, v: __m512) {
        unsafe { _mm512_storeu_ps(p, v) }
    }
    #[inline(always)]
    unsafe fn load_part(p: *const f32, n: usize) -> __m512 {
        unsafe { _mm512_maskz_loadu_ps((1_u16 << n) - 1, p) }
    }
    #[inline(always)]
    unsafe fn store_part(p: *mut f32, n: usize, v: __m512) {
        unsafe { _mm512_mask_storeu_ps(p, (1_u16 << n) - 1, v) }
    }
    #[inline(always)]
    unsafe fn add(a: __m512, b: __m512) -> __m512 {
        unsafe { _mm512_add_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn mul(a: __m512, b: __m512) -> __m512 {
        unsafe { _mm512_mul_ps(a, b) }
    }
    #[inline(always)]
    unsafe fn fma(a: __m512, b: __m512, c: __m512) -> __m512 {
        unsafe { _mm512_fmadd_ps(a, b, c) }
    }
    #[inline(always)]
    unsafe fn relu(v: __m512) -> __m512 {
        // Of two numbers, one of them none, `max` gives the second.
        unsafe { _mm512_max_ps(_mm512_setzero_ps(), v) }
    }
    #[inline(always)]
    unsafe fn where_positive(v: __m512, y: __m512) -> __m512 {
        unsafe { _mm512_maskz_mov_ps(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(y, _mm512_setzero_ps()), v) }
    }
    #[inline(always)]
    unsafe fn sum_of_lanes([all, ..]: [__m512; 4]) -> f32 {
        unsafe {
            let high = _mm512_castps_pd(all);
            let high = _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(high));
            sum_of_eight(_mm256_add_ps(_mm512_castps512_ps256(all), high))
        }
    }
    #[inline(always)]
    unsafe fn turn8(from: *const f32, stride: usize, to: *mut f32, to_stride: usize) {
        unsafe { turn8(from, stride, to, to_stride) }
    }
    #[inline(always)]
    unsafe fn sums_of_lanes(a: [__m512; 16]) -> [f32; 16] {
        // Two vectors become one in every step: sums 8, 4, 2 and 1 lanes apart, each vector's beside the other's.
        unsafe {
            let b: [__m512; 8] = std::array::from_fn(|i| {
                let (x, y) = (a[i], a[i + 8]);
                _mm512_add_ps(_mm512_shuffle_f32x4::<0x44>(x, y), _mm512_shuffle_f32x4::<0xee>(x, y))
            });
            let c: [__m512; 4] = std::array::from_fn(|i| {
                let (x, y) = (b[i], b[i + 4]);
                _mm512_add_ps(_mm512_shuffle_f32x4::<0x88>(x, y), _mm512_shuffle_f32x4::<0xdd>(x, y))
            });
            let d: [__m512; 2] = std::array::from_fn(|i| {
                let (x, y) = (c[i], c[i + 2]);
                _mm512_add_ps(_mm512_shuffle_ps::<0x44>(x, y), _mm512_shuffle_ps::<0xee>(x, y))
            });
            let sums = _mm512_add_ps(_mm512_shuffle_ps::<0x88>(d[0], d[1]), _mm512_shuffle_ps::<0xdd>(d[0], d[1]));
            // Where in `sums` each vector's is.
            let order = _mm512_setr_epi32(0, 2, 1, 3, 8, 10, 9, 11, 4, 6, 5, 7, 12, 14, 13, 15);
            std::mem::transmute::<__m512, [f32; 16]>(_mm512_permutexvar_ps(order, sums))
        }
    }
}
