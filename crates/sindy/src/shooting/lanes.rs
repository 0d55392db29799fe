//! Numbers side by side.

/// Adds `of` each place to `sum`.
pub(super) fn add<const L: usize>(sum: &mut [f64; L], of: impl Fn(usize) -> f64) {
    for (l, sum) in sum.iter_mut().enumerate() {
        *sum += of(l);
    }
}
