//! Loops compiled for the widest vectors the machine has, chosen at run time.

/// Runs `kernel`, compiled for the vector instructions found on this machine, if it is a closure that is `#[inline(always)]`.
///
/// Rust never fuses a product and a sum by itself, and changes the order of no sum, so the results are the same bits on every machine.
#[inline(always)]
pub fn vectorized<R>(kernel: impl FnOnce() -> R) -> R {
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
