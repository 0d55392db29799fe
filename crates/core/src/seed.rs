//! One seed, many independent random streams.

use rand_pcg::Pcg64;

/// The random generator used everywhere: PCG64, the generator behind NumPy's `default_rng`.
pub type Rng = Pcg64;

/// The seed of a run. Every consumer of randomness takes a stream of its own, so that none shifts another's numbers.
///
/// Streams follow NumPy: `Seed::new(s).numpy()` draws what `numpy.random.default_rng(s)` draws, so an environment
/// can be reset to exactly the state Gymnasium resets to.
///
/// # References
/// O'Neill (2014), PCG; NumPy NEP 19 and `SeedSequence` (hash constants of M. E. O'Neill's `seed_seq_fe`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seed(u64);

impl Seed {
    /// The seed `value`.
    #[must_use]
    pub fn new(value: u64) -> Self {
        Self(value)
    }

    /// The number this seed was made from.
    #[must_use]
    pub fn value(self) -> u64 {
        self.0
    }

    /// The generator of `numpy.random.default_rng(seed)`.
    #[must_use]
    pub fn numpy(self) -> Rng {
        from_words(&words(self.0))
    }

    /// The stream called `name` with number `index`, independent of every other stream.
    #[must_use]
    pub fn stream(self, name: &str, index: u64) -> Rng {
        let mut entropy = words(self.0);
        // Four words are the pool; what follows is mixed in one by one, as NumPy does with spawn keys.
        entropy.resize(4, 0);
        entropy.extend(name.as_bytes().chunks(4).map(|c| {
            let mut b = [0; 4];
            b[..c.len()].copy_from_slice(c);
            u32::from_le_bytes(b)
        }));
        entropy.extend([name.len() as u32, index as u32, (index >> 32) as u32]);
        from_words(&entropy)
    }
}

fn words(value: u64) -> Vec<u32> {
    let (low, high) = (value as u32, (value >> 32) as u32);
    if high == 0 { vec![low] } else { vec![low, high] }
}

/// `SeedSequence(entropy).generate_state(4, uint64)` fed to PCG64.
fn from_words(entropy: &[u32]) -> Rng {
    const XSHIFT: u32 = 16;
    const POOL: usize = 4;
    let mut hash_const = 0x43b0_d7e5_u32;
    let mut hash = |mut value: u32| {
        value ^= hash_const;
        hash_const = hash_const.wrapping_mul(0x931e_8875);
        value = value.wrapping_mul(hash_const);
        value ^ (value >> XSHIFT)
    };
    let mix = |x: u32, y: u32| {
        let r = x.wrapping_mul(0xca01_f9dd).wrapping_sub(y.wrapping_mul(0x4973_f715));
        r ^ (r >> XSHIFT)
    };
    let mut pool = [0_u32; POOL];
    for (i, p) in pool.iter_mut().enumerate() {
        *p = hash(entropy.get(i).copied().unwrap_or(0));
    }
    for source in 0..POOL {
        for target in 0..POOL {
            if source != target {
                let h = hash(pool[source]);
                pool[target] = mix(pool[target], h);
            }
        }
    }
    for &word in entropy.iter().skip(POOL) {
        for p in &mut pool {
            let h = hash(word);
            *p = mix(*p, h);
        }
    }
    let mut out_const = 0x8b51_f9dd_u32;
    let state: [u128; 8] = std::array::from_fn(|i| {
        let mut value = pool[i % POOL] ^ out_const;
        out_const = out_const.wrapping_mul(0x58f3_8ded);
        value = value.wrapping_mul(out_const);
        u128::from(value ^ (value >> XSHIFT))
    });
    // NumPy joins two words to a u64 (low first) and two u64 to a u128 (high first).
    let u128_at = |i: usize| (state[i + 1] << 32 | state[i]) << 64 | state[i + 3] << 32 | state[i + 2];
    Rng::new(u128_at(0), u128_at(4))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng as _;

    #[test]
    fn default_rng_matches_numpy() {
        // numpy 2.4.6: np.random.default_rng(s).bit_generator.random_raw(2)
        for (seed, raw) in [
            (0, [11_749_869_230_777_074_271, 4_976_686_463_289_251_617]),
            (42, [14_276_969_152_011_380_360, 8_095_878_257_575_067_585]),
            (123_456_789_012, [10_442_050_190_638_768_665, 1_543_454_933_748_037_150]),
        ] {
            let mut rng = Seed::new(seed).numpy();
            assert_eq!([rng.next_u64(), rng.next_u64()], raw, "seed {seed}");
        }
    }

    #[test]
    fn streams_differ_by_name_index_and_seed() {
        let first = |s: u64, name: &str, i| Seed::new(s).stream(name, i).next_u64();
        let drawn = [first(0, "a", 0), first(0, "a", 1), first(0, "b", 0), first(1, "a", 0), first(0, "a\0", 0)];
        for i in 0..drawn.len() {
            for j in 0..i {
                assert_ne!(drawn[i], drawn[j]);
            }
        }
        assert_eq!(first(7, "warm-up", 3), first(7, "warm-up", 3));
    }
}
