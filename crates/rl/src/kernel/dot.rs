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
    let outputs = job.vectors.len() / job.inner;
    for (o, vector) in job.vectors.chunks_exact(job.inner).enumerate() {
        let bias = job.biases.map_or(0.0, |b| b[o]);
        for (y, x) in job.ys.chunks_exact_mut(outputs).zip(job.xs.chunks_exact(job.inner)) {
            // SAFETY: both have the length `inner`.
            y[o] = bias + unsafe { dot::<S>(x, vector) };
        }
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
