//! Loops compiled for the widest vectors this processor has, chosen at run time.

/// Runs `kernel` with the widest vectors this processor has. The results are those of any other processor: nothing is
/// summed across lanes but as it is written, and nothing is fused.
#[inline]
pub(crate) fn wide<R>(kernel: impl FnOnce() -> R) -> R {
    struct Kernel<F>(F);
    impl<R, F: FnOnce() -> R> pulp::WithSimd for Kernel<F> {
        type Output = R;
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) -> R {
            (self.0)()
        }
    }
    pulp::Arch::new().dispatch(Kernel(kernel))
}
