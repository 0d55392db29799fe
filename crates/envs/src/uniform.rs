//! Uniform draws as NumPy makes them.

use rand::Rng as _;
use sindyna_core::Rng;

/// Draws what `numpy.random.Generator.uniform(low, high)` draws from the same generator: low + (high − low)·k·2⁻⁵³,
/// where k is the upper 53 bits of the next output.
pub(crate) fn uniform(low: f64, high: f64, rng: &mut Rng) -> f64 {
    let unit = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    low + (high - low) * unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::Seed;

    #[test]
    fn draws_are_numpys() {
        // numpy 2.4.6: np.random.default_rng(42).uniform(-0.05, 0.05, 2)
        let mut rng = Seed::new(42).numpy();
        let drawn = [uniform(-0.05, 0.05, &mut rng), uniform(-0.05, 0.05, &mut rng)];
        assert_eq!(drawn, [0.027395604855596334, -0.006112156024794771]);
    }
}
