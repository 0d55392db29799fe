//! What a hidden layer does to its sums.

use serde::{Deserialize, Serialize};

use crate::{affine::relu, simd::vectorized};

/// The function after every layer but the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// max(z, 0).
    Relu,
    /// z/(1 + e⁻ᶻ), also known as SiLU.
    ///
    /// # References
    /// Ramachandran, Zoph, Le (2017), arXiv:1710.05941.
    Swish,
}

impl Activation {
    /// Applies the function to `z` in place.
    pub(super) fn apply(self, z: &mut [f32]) {
        vectorized(
            #[inline(always)]
            || match self {
                Self::Relu => z.iter_mut().for_each(|z| *z = relu(*z)),
                Self::Swish => z.iter_mut().for_each(|z| *z *= sigmoid(*z)),
            },
        );
    }
}

/// y = z σ(z), and in place of z its slope σ + y (1 - σ).
pub(super) fn swish_and_slope(z: &mut [f32], y: &mut [f32]) {
    vectorized(
        #[inline(always)]
        || {
            for (z, y) in z.iter_mut().zip(y) {
                let s = sigmoid(*z);
                *y = *z * s;
                *z = s + *y * (1.0 - s);
            }
        },
    );
}

/// d ← d · `factors`, number by number.
pub(super) fn scale_by(d: &mut [f32], factors: &[f32]) {
    vectorized(
        #[inline(always)]
        || d.iter_mut().zip(factors).for_each(|(d, f)| *d *= f),
    );
}

/// 1/(1 + e⁻ᶻ) to about 2e-7; a number that is none stays none.
#[inline(always)]
fn sigmoid(z: f32) -> f32 {
    1.0 / (1.0 + exp(-z))
}

/// eˣ in single precision, without branches or calls, so that loops over it become vector code: the same bits on every
/// machine. Arguments beyond ±87 count as that.
#[inline(always)]
fn exp(x: f32) -> f32 {
    const MOST: f32 = 87.0;
    /// A number this large holds another in its last bits, rounded to a whole one.
    const ROUND: f32 = 12_582_912.0;
    /// log 2 in two parts, the first with its last bits clear.
    const LN_2: (f32, f32) = (0.693_359_4, -2.121_944_4e-4);
    const INVERSE_FACTORIALS: [f32; 7] = [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    let x = if x < -MOST { -MOST } else { x };
    let x = if x > MOST { MOST } else { x };
    let rounded = x * std::f32::consts::LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    // Taylor's series; |r| is at most log 2 / 2, where the first term left out is 1.2e-7.
    let mut sum = 0.0;
    for c in INVERSE_FACTORIALS {
        sum = sum * r + c;
    }
    sum * f32::from_bits(rounded.to_bits().wrapping_add(127) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swish_and_its_slope_are_those_of_their_definition() {
        for i in -4000..4000 {
            let z = f64::from(i) * 0.01;
            let (s, mut slope, mut y) = (1.0 / (1.0 + (-z).exp()), [z as f32], [0.0]);
            swish_and_slope(&mut slope, &mut y);
            let close = |got: f32, expected: f64| (f64::from(got) - expected).abs() < 1e-6 * (1.0 + z.abs());
            assert!(close(y[0], z * s), "{z}: {} is not {}", y[0], z * s);
            assert!(close(slope[0], s * (1.0 + z * (1.0 - s))), "{z}: slope {}", slope[0]);
            let mut alone = [z as f32];
            Activation::Swish.apply(&mut alone);
            assert_eq!(alone, y, "with and without slope, the bits are the same");
        }
    }

    #[test]
    fn extremes_stay_finite_and_a_broken_number_is_not_hidden() {
        let mut z = [1e30, -1e30, 0.0];
        Activation::Swish.apply(&mut z);
        assert!(z[0] == 1e30 && z[1].abs() < 1e-6 && z[2] == 0.0, "{z:?}");
        for activation in [Activation::Relu, Activation::Swish] {
            let mut z = [f32::NAN];
            activation.apply(&mut z);
            assert!(z[0].is_nan(), "{activation:?}");
        }
    }
}
