//! Products of rows with a few vectors: layers with a handful of outputs.

use super::lanes::Lanes;

/// Lanes of a sum, whatever the width of the vectors.
const LANES: usize = 16;

/// What [`super::dots`] describes, its sizes checked.
pub(super) struct Job<'a> {
    pub(super) ys: &'a mut [f32],
    pub(super) xs: &'a [f32],
    pub(super) vectors: &'a [f32],
    pub(super) inner: usize,
    pub(super) biases: Option<&'a [f32]>,
}

/// # Safety
/// The instructions of S are there.
#[inline(always)]
pub(super) unsafe fn dots<S: Lanes>(job: Job<'_>) {
    let Job { ys, xs, vectors, inner, biases } = job;
    let outputs = vectors.len() / inner;
    // Where a row's lanes are one vector, as many rows go together as there are lanes.
    let together = if S::N == LANES { xs.len() / inner / LANES * LANES } else { 0 };
    let (xs, last_xs) = xs.split_at(together * inner);
    let (ys, last_ys) = ys.split_at_mut(together * outputs);
    for (o, vector) in vectors.chunks_exact(inner).enumerate() {
        let bias = biases.map_or(0.0, |b| b[o]);
        for (ys, xs) in ys.chunks_exact_mut(LANES * outputs).zip(xs.chunks_exact(LANES * inner)) {
            // SAFETY: `xs` are as many rows of the length of `vector` as there are lanes.
            let sums = unsafe { dots_of_rows::<S>(xs, vector) };
            for (y, sum) in ys.chunks_exact_mut(outputs).zip(sums) {
                y[o] = bias + sum;
            }
        }
        for (y, x) in last_ys.chunks_exact_mut(outputs).zip(last_xs.chunks_exact(inner)) {
            // SAFETY: both have the length `inner`.
            y[o] = bias + unsafe { dot::<S>(x, vector) };
        }
    }
}

/// The products of [`LANES`] rows with `w`, where a vector has as many lanes.
#[inline(always)]
unsafe fn dots_of_rows<S: Lanes>(xs: &[f32], w: &[f32]) -> [f32; LANES] {
    let (x, n) = (xs.as_ptr(), w.len());
    // SAFETY: offsets stay below n in every row; parts are loaded only as far as they go.
    unsafe {
        let mut sums = [S::splat(0.0); LANES];
        let mut at = 0;
        while at + LANES <= n {
            let w = S::load(w.as_ptr().add(at));
            for (row, sum) in sums.iter_mut().enumerate() {
                *sum = S::fma(S::load(x.add(row * n + at)), w, *sum);
            }
            at += LANES;
        }
        if at < n {
            let w = S::load_part(w.as_ptr().add(at), n - at);
            for (row, sum) in sums.iter_mut().enumerate() {
                *sum = S::fma(S::load_part(x.add(row * n + at), n - at), w, *sum);
            }
        }
        S::sums_of_lanes(sums)
    }
}

#[inline(always)]
unsafe fn dot<S: Lanes>(x: &[f32], w: &[f32]) -> f32 {
    let (x, w, n) = (x.as_ptr(), w.as_ptr(), x.len().min(w.len()));
    let whole = n / LANES * LANES;
    // SAFETY: offsets stay below n; parts are loaded only as far as they go.
    unsafe {
        // At most four vectors make up the lanes.
        let mut sums = [S::splat(0.0); 4];
        let per = LANES / S::N;
        let mut at = 0;
        while at < whole {
            for (v, sum) in sums.iter_mut().enumerate().take(per) {
                let p = at + v * S::N;
                *sum = S::fma(S::load(x.add(p)), S::load(w.add(p)), *sum);
            }
            at += LANES;
        }
        for (v, sum) in sums.iter_mut().enumerate().take(per) {
            let p = at + v * S::N;
            if p < n {
                let left = (n - p).min(S::N);
                *sum = if left == S::N {
                    S::fma(S::load(x.add(p)), S::load(w.add(p)), *sum)
                } else {
                    S::fma(S::load_part(x.add(p), left), S::load_part(w.add(p), left), *sum)
                };
            }
        }
        S::sum_of_lanes(sums)
    }
}
